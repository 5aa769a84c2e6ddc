"""Plug-ins as real processes: they work, fail in every way, recover, and delay nobody."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from controlrig import Rig
from gazechair.base.child_process import END
from gazechair.base.child_records import DATA, RecordReader
from gazechair.base.health import HealthRegistry
from gazechair.config import configuration
from gazechair.plugins import describe, found, service
from gazechair.plugins.found import Found
from gazechair.service import doctor
from gazelink import codes
from patience import wait_until

SAMPLES = {
    ("input", "metronome"): "pluginsamples:Metronome",
    ("mode", "straight"): "pluginsamples:Straight",
    ("input", "liar"): "pluginsamples:Liar",
    ("input", "flood"): "pluginsamples:Flood",
    ("input", "gone"): "pluginsamples_that_is_not_there:X",
    ("mode", "wrong"): "pluginsamples:Metronome",
}


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [Found(kind, name, entry, "samples") for (kind, name), entry in SAMPLES.items()]
    monkeypatch.setattr(found, "installed", lambda: rows)


class House:
    """A daemon's plug-ins beside a page that has armed, in real time."""

    def __init__(self, config: str) -> None:
        self.rig = Rig()
        self.rig.control._clock = time.monotonic
        self.rig.arm()
        self.parts = HealthRegistry()
        plugins = configuration.parse(config, "chair.toml").plugins
        self.plugins = service.Plugins(plugins, self.rig.control, self.parts)
        self.plugins.start(lambda plugin, _health: plugin.start())
        self.ending = threading.Event()
        self.beating = threading.Thread(target=self._beat, name="page")
        self.edge = 0
        self.tile = ""
        self.beating.start()

    def _beat(self) -> None:
        while not self.ending.wait(0.02):
            token = self.rig.look()["token"]
            self.rig.say(k="hb", token=token)
            if self.tile:
                self.rig.say(k="mode", mode=self.tile, edge=self.edge, token=token)
            self.rig.control.update()

    def health(self, part: str) -> Any:
        return self.parts.part(part)

    def moves(self) -> bool:
        command = self.rig.control._arbiter.command
        return command.verb != codes.STOP and command.ttl_deadline_s > time.monotonic()

    def end(self) -> None:
        self.plugins.stop()
        self.ending.set()
        self.beating.join()


@pytest.fixture
def house() -> Iterator[Callable[[str], House]]:
    made: list[House] = []

    def make(config: str) -> House:
        made.append(House(config))
        return made[-1]

    before = set(threading.enumerate())
    yield make
    for one in made:
        one.end()
    assert set(threading.enumerate()) == before


def test_an_input_drives_and_killed_or_stopped_it_ends_and_comes_back(
    house: Callable[[str], House],
) -> None:
    home = house("[input.metronome]\n")
    plugin = home.plugins.running["input.metronome"]
    for number, ended in ((signal.SIGKILL, "ended"), (signal.SIGSTOP, "hangs")):
        wait_until(home.moves, "it drives")
        assert home.health("input metronome").state == "ok"
        assert plugin.pid is not None
        os.kill(plugin.pid, number)
        before = plugin.restarts
        wait_until(lambda: not home.moves(), "it stops")
        wait_until(lambda before=before: plugin.restarts > before, "it is started again")
        assert ended in home.health("input metronome").detail


@pytest.mark.parametrize(
    ("config", "part", "why"),
    [
        ("[input.metronome]\nhow = 'raise'\n", "input metronome", "RuntimeError: it broke"),
        ("[input.metronome]\nlinear = 2000\n", "input metronome", "chair.toml:2: input.metronome."),
        ("[input.metronome]\nlin = 2\n", "input metronome", "is no setting; [input.metronome] has"),
        ("[input.gone]\n", "input gone", "No module named 'pluginsamples_that_is_not_there'"),
        ("[input.nobody]\n", "input nobody", "chair.toml:1: no input called nobody is installed"),
        ("[mode.wrong]\n", "mode wrong", "is no Mode"),
        ("[input.liar]\n", "input liar", "in the future"),
        ("[input.flood]\n", "input flood", "more than 400 records a second"),
    ],
)
def test_one_that_fails_is_named_in_one_line(
    house: Callable[[str], House], config: str, part: str, why: str
) -> None:
    home = house(config)
    wait_until(lambda: home.health(part).state == "lost", "it is lost")
    detail = home.health(part).detail
    assert why in detail
    assert "\n" not in detail
    assert not home.moves()


@pytest.mark.parametrize(
    ("config", "reason"),
    [
        ("[input.metronome]\nhow = 'raise'\n", "plugin_raised"),
        ("[input.metronome]\nlinear = 2000\n", "plugin_setting"),
        ("[input.metronome]\nhow = 'die'\n", "plugin_ended"),
        ("[input.nobody]\n", "plugin_missing"),
        ("[input.liar]\n", "plugin_wrong"),
    ],
)
def test_pages_are_told_what_is_wrong_and_when_it_is_tried_again(
    house: Callable[[str], House], config: str, reason: str
) -> None:
    home = house(config)

    def row() -> Any:
        return home.rig.control.welcome(home.rig.page)["plugins"][0]

    wait_until(lambda: row()["reason"] == reason, reason)
    if reason == "plugin_missing":
        assert row()["again"] is None
        return
    wait_until(lambda: row()["again"] is not None, "the next try")
    reported = row()
    if reported["again"] is not None:  # the next try may have begun this moment
        assert -100 < reported["again"] - home.rig.look()["token"] <= 10_000
    assert (reported["kind"], reported["state"]) == ("input", "lost")
    assert 0 < len(reported["detail"]) <= 200
    assert reported["names"]["nl"] == "Metronoom"


def test_pages_are_told_of_all_in_the_order_of_the_configuration(
    house: Callable[[str], House],
) -> None:
    home = house("[mode.straight]\n[mode.wrong]\n[input.metronome]\n")

    def rows() -> Any:
        return home.rig.control.welcome(home.rig.page)["plugins"]

    assert [row["name"] for row in rows()] == ["straight", "wrong", "metronome"]
    wait_until(lambda: [row["state"] for row in rows()] == ["ok", "lost", "ok"], "their health")
    assert rows()[0]["icon"] == "●"
    assert rows()[0]["again"] is None
    assert rows()[1]["names"] == {}
    assert "is no Mode" in rows()[1]["detail"]


def test_a_mode_is_asked_while_its_tile_is_held(house: Callable[[str], House]) -> None:
    home = house("[mode.straight]\n")
    wait_until(lambda: home.rig.control.welcome(home.rig.page)["modes"] != [], "it is offered")
    assert home.rig.control.welcome(home.rig.page)["modes"][0]["names"]["nl"] == "Rechtuit"
    stop = threading.Event()

    def board() -> None:
        while not stop.wait(0.01):
            home.rig.board(state=codes.ARMED, received_s=time.monotonic())

    telling = threading.Thread(target=board)
    telling.start()
    try:
        home.edge, home.tile = 1, "straight"

        def drives() -> bool:
            home.edge += not home.rig.control.mode_context().mode  # a stall ended the press
            return home.moves()

        wait_until(drives, "it drives")
        assert home.rig.control._arbiter.command.linear_permille == 500
    finally:
        home.tile = ""
        stop.set()
        telling.join()
    wait_until(lambda: not home.moves(), "it stops")


def test_the_doctor_and_the_list_name_each(tmp_path: Any) -> None:
    file = tmp_path / "chair.toml"
    file.write_text("[input.metronome]\nhow = 'fly'\n[mode.straight]\n[input.gone]\n")
    config = configuration.load(file)
    metronome, gone, straight = doctor._plugins(config)
    assert (metronome.level, straight.level, gone.level) == ("FAIL", "OK", "FAIL")
    assert metronome.found.startswith(f"{file}:2: input.metronome.how must be ")
    assert straight.found == "Drives straight on for 3 s."
    assert "No module" in gone.found
    reported = describe.describe(found.find("input", "metronome"))
    assert "linear = 600" in reported.table
    assert "[input.metronome]" in reported.table


def test_two_packages_with_one_name_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [Found("input", "a", "x:Y", "one"), Found("input", "a", "z:Y", "two")]
    monkeypatch.setattr(found, "installed", lambda: rows)
    with pytest.raises(LookupError, match="one and two both offer the input a"):
        found.find("input", "a")


def test_a_process_that_ends_in_order_closes_its_plugin() -> None:
    argument = {"kind": "input", "name": "tidy", "entry": "pluginsamples:Tidy", "settings": {}}
    process = subprocess.Popen(
        [sys.executable, "-m", "gazechair.plugins.child", json.dumps({**argument, "how": "serve"})],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=dict(os.environ, PYTHONPATH=os.pathsep.join(p for p in sys.path if p)),
    )
    assert process.stdout is not None
    reader = RecordReader()
    while DATA not in [kind for kind, _ in reader.feed(os.read(process.stdout.fileno(), 4096))]:
        pass
    process.send_signal(END)
    assert process.communicate(timeout=30)[1] == b"closed"
    assert process.returncode == 0
