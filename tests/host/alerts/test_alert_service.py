"""The alerts' part: from a driver's Help to a message, an answer, the diary; its commands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from controlrig import QUIET, FakeLink
from gazechair import cli
from gazechair.alerts import apprise_route
from gazechair.alerts.book import RETRIES_S
from gazechair.alerts.diary import Diary
from gazechair.alerts.message import Message
from gazechair.alerts.reasons import HELP_WANTED
from gazechair.alerts.service import LOOK_S, Alerts
from gazechair.alerts.watch import Situation
from gazechair.base.health import LOST, OK, STARTING, HealthRegistry
from gazechair.config.rules import Secret
from gazechair.config.settings import AlertsConfig, Config, RouteConfig
from gazechair.driving.control import Control
from gazechair.driving.help_call import COMING_S
from gazelink import codes

ROUTES = (
    RouteConfig("zus", Secret("json://localhost/hush")),
    RouteConfig("sms", Secret("json://localhost/hush2"), 120, ("help",)),
)


class Rig:
    """Control and alerts in virtual time; messages are recorded instead of sent."""

    def __init__(
        self,
        folder: Path,
        routes: tuple[RouteConfig, ...] = ROUTES,
        broker: str = "",
        now_s: float = 10.0,
    ) -> None:
        self.now_s = now_s
        self.folder = folder
        self.parts = HealthRegistry(lambda: self.now_s)
        for name in ("board", "lidar", "camera"):
            self.parts.part(name).set(OK)
        config = Config(routes=routes, alerts=AlertsConfig(mqtt=Secret(broker)))
        self.alerts = Alerts(
            config, folder, self.parts, lambda: self.now_s, lambda: 1e9 + self.now_s
        )
        self.link = FakeLink()
        self.control = Control(
            config, self.link, self.parts, clock=lambda: self.now_s, alerts=self.alerts
        )
        self.alerts.watch(self.control)
        if self.alerts._sender is not None:
            self.alerts._sender.send = self._send  # type: ignore[method-assign]
        self.sent: list[tuple[float, str, str]] = []
        self.problem = ""
        self.page = self.control.connect("driver")

    def _send(self, number: int, route: str, url: str, message: Message) -> str:
        self.sent.append((round(self.now_s - 10.0, 1), route, message.body.splitlines()[0]))
        assert url == next(str(one.url) for one in ROUTES if one.name == route)
        self.alerts.result(number, route, self.problem)
        return ""

    def wait(self, seconds: float) -> None:
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            self.alerts.look()
            self.now_s = round(self.now_s + LOOK_S, 1)

    def help(self, on: bool = True) -> None:
        assert self.control.receive(self.page, {"k": "call", "on": on}) == []

    def row(self) -> dict[str, Any]:
        return dict(self.alerts.as_json()["alerts"][-1])

    def shown(self) -> dict[str, Any]:
        return self.control.snapshot(self.page)


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    rig = Rig(tmp_path)
    sentence = {"id": "1", "name": "Kees", "help_sentence": "Ik zit vast in het park"}
    rig.control.change_profile({"save": sentence}, "caretaker")
    yield rig
    rig.alerts.stop()


def restarted(rig: Rig, folder: Path) -> Rig:
    """The next host, with the diary of this one."""
    Diary(folder).write(rig.alerts.as_json()["alerts"])
    return Rig(folder)


def test_help_goes_out_within_a_look_with_the_drivers_sentence_and_escalates(rig: Rig) -> None:
    before = rig.shown()["alerts"]
    rig.help()
    rig.wait(130)
    message = "Kees: Ik zit vast in het park"
    assert rig.sent == [(0.0, "zus", message), (120.0, "sms", message)]
    assert rig.shown()["alerts"] != before
    assert rig.row()["sentence"] == "Ik zit vast in het park"


def test_who_acknowledges_is_named_and_the_driver_sees_that_somebody_comes(rig: Rig) -> None:
    rig.help()
    rig.wait(10)
    assert rig.alerts.acknowledge(rig.row()["number"], "telefoon van Anna")
    assert (rig.shown()["call"], rig.shown()["coming"]) == (False, True)
    rig.wait(200)
    assert [route for _, route, _ in rig.sent] == ["zus"]
    assert (rig.row()["state"], rig.row()["by"]) == ("acknowledged", "telefoon van Anna")
    assert not rig.alerts.acknowledge(rig.row()["number"], "Bert")


def test_an_answer_by_the_pages_own_button_counts_and_is_named_a_moment_later(rig: Rig) -> None:
    phone = rig.control.connect("caretaker")
    rig.help()
    rig.wait(1)
    rig.control.receive(phone, {"k": "call", "on": False})
    rig.wait(1)
    assert (rig.row()["state"], rig.row()["by"]) == ("acknowledged", "")
    assert rig.alerts.acknowledge(rig.row()["number"], "Anna")
    assert rig.shown()["coming"] is True
    rig.control.receive(phone, {"k": "call", "on": False})  # pressed twice
    rig.wait(1)
    assert (rig.row()["state"], rig.shown()["coming"]) == ("acknowledged", True)
    rig.control.receive(phone, {"k": "call", "on": False, "there": True})
    rig.wait(1)
    assert (rig.row()["state"], rig.row()["by"]) == ("over", "Anna")


def test_the_driver_is_told_whether_a_call_has_reached_somebody(rig: Rig) -> None:
    assert rig.shown()["heard"] is True  # as far as is known
    rig.problem = "no network"
    rig.help()
    rig.wait(1)
    assert rig.shown()["heard"] is False
    rig.problem = ""
    rig.wait(RETRIES_S[0])
    assert rig.shown()["heard"] is True


def test_without_a_route_only_a_caretakers_page_hears(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ())
    assert rig.shown()["heard"] is False
    rig.help()
    rig.wait(1)
    assert rig.row()["deliveries"] == {}


def test_ten_calls_a_second_for_a_minute_neither_flood_nor_hide_the_last(rig: Rig) -> None:
    for number in range(600):
        rig.help(number % 2 == 0)
        rig.alerts.look()
        rig.now_s += 0.1
    assert len(rig.alerts.as_json()["alerts"]) == 1
    assert len(rig.sent) <= 2


def test_a_call_outlives_the_host(rig: Rig, tmp_path: Path) -> None:
    rig.help()
    rig.wait(60)
    again = restarted(rig, tmp_path)
    assert again.shown()["call"] is True
    again.wait(200)
    assert [route for _, route, _ in again.sent] == ["sms"]
    assert [row["count"] for row in again.alerts.as_json()["alerts"]] == [1]


def test_who_is_coming_outlives_the_host_for_the_rest_of_the_time(rig: Rig, tmp_path: Path) -> None:
    rig.help()
    rig.wait(200)
    assert rig.alerts.acknowledge(rig.row()["number"], "Anna")
    rig.wait(100)
    Diary(tmp_path).write(rig.alerts.as_json()["alerts"])
    again = Rig(tmp_path, now_s=rig.now_s)
    again.wait(COMING_S - 101)
    assert (again.shown()["call"], again.shown()["coming"]) == (False, True)
    assert (again.row()["state"], again.row()["by"], again.sent) == ("acknowledged", "Anna", [])
    again.wait(2)
    assert (again.shown()["coming"], again.row()["state"]) == (False, "over")


def test_an_answer_outlives_the_host_while_the_lidar_starts(rig: Rig, tmp_path: Path) -> None:
    rig.parts.part("lidar").set(LOST, "lidar_lost")
    rig.wait(61)
    assert rig.alerts.acknowledge(rig.row()["number"], "Anna")
    again = restarted(rig, tmp_path)
    lidar = again.parts.part("lidar")
    lidar.set(STARTING, "lidar_starting")
    again.wait(10)
    assert again.row()["state"] == "acknowledged"
    lidar.set(LOST, "lidar_lost")
    again.wait(100)
    assert (again.row()["state"], again.row()["by"], again.sent) == ("acknowledged", "Anna", [])


def test_only_another_lost_part_than_before_a_restart_calls_again(rig: Rig, tmp_path: Path) -> None:
    rig.parts.part("log").set(LOST, "log_lost")
    rig.wait(301)
    assert rig.alerts.acknowledge(rig.row()["number"], "Anna")
    again = restarted(rig, tmp_path)
    again.parts.part("log").set(LOST, "log_lost")
    again.wait(301)
    assert again.sent == []
    again.parts.part("map").set(LOST, "map_lost")
    again.wait(301)
    assert [message for _, _, message in again.sent] == ["log: log_lost; map: map_lost"]


def test_a_test_is_sent_everywhere_and_its_failures_are_shown(rig: Rig) -> None:
    rig.problem = "refused"
    rig.alerts.test("telefoon van Anna")
    rig.wait(300)
    assert [(at_s, route) for at_s, route, _ in rig.sent] == [(0.0, "zus"), (0.0, "sms")]
    assert rig.row()["deliveries"]["sms"] == {"state": "failed", "detail": "refused"}
    assert rig.row()["state"] != "open"


def test_without_the_package_the_reason_is_shown(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(apprise_route, "find_spec", lambda _: None)
    rig.help()
    rig.wait(1)
    assert rig.row()["deliveries"]["zus"]["detail"] == apprise_route.MISSING
    rig.alerts.start()
    assert rig.parts.part("alerts").detail == apprise_route.MISSING


def test_without_the_package_the_driver_reads_before_a_call_that_nobody_hears(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(apprise_route, "find_spec", lambda _: None)
    rig.alerts.start()
    assert rig.shown()["heard"] is False


def test_a_broker_sends_no_message_of_a_route(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(apprise_route, "find_spec", lambda _: None)
    rig = Rig(tmp_path, broker="mqtt://house")
    assert rig.alerts._sender is not None
    monkeypatch.setattr(rig.alerts._sender, "start", lambda: None)
    rig.alerts.start()
    assert rig.parts.part("alerts").state == STARTING
    assert rig.shown()["heard"] is False
    rig.alerts.stop()


def test_while_the_sending_process_is_lost_nobody_hears(rig: Rig) -> None:
    rig.parts.part("alerts").set(LOST, "alerts_lost")
    assert rig.shown()["heard"] is False
    rig.parts.part("alerts").set(OK)
    assert rig.shown()["heard"] is True


def test_the_threads_keep_the_diary(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ())
    rig.alerts.test("Anna")
    rig.alerts.start()
    rig.alerts.stop()
    (row,) = Diary(tmp_path).read()
    assert (row["key"], row["by"]) == ("alert_test", "Anna")


def test_without_a_broker_nobody_reads_the_battery(rig: Rig) -> None:
    def battery() -> int:
        raise AssertionError

    rig.alerts._battery = battery
    rig.wait(20)


def test_the_broker_is_told_what_changes_and_again_each_few_seconds(
    rig: Rig, tmp_path: Path
) -> None:
    config = Config(alerts=AlertsConfig(mqtt=Secret("mqtt://house")))
    charges = iter((None, 61, 61))
    alerts = Alerts(
        config, tmp_path / "other", rig.parts, lambda: rig.now_s, lambda: 1e9, lambda: next(charges)
    )
    alerts.watch(rig.control)
    reported: list[tuple[float, dict[str, str]]] = []
    assert alerts._sender is not None
    alerts._sender.update_broker = (  # type: ignore[method-assign]
        lambda url, node, state: reported.append((round(rig.now_s - 10.0, 1), state))
    )
    rig.alerts = alerts
    rig.wait(1)
    rig.help()
    rig.wait(8)
    assert [at_s for at_s, _ in reported] == [0.0, 1.0, 6.0]
    assert reported[0][1] == {"help": "OFF", "state": "ok", "last_alert": ""}
    assert reported[1][1] == {
        "help": "ON",
        "state": "help",
        "last_alert": "De bestuurder vraagt hulp",
    }
    assert reported[2][1] == reported[1][1] | {"battery": "61"}, "read again when it is told again"


def test_a_driver_whose_every_press_is_overruled_is_stuck_until_the_chair_moves(rig: Rig) -> None:
    def press(edge: int, **board: int) -> None:
        token = rig.shown()["token"]
        message = {"verb": "forward", "mode": "continuous", "edge": edge, "token": token}
        rig.control.receive(rig.page, {"k": "cmd", **message})
        rig.link.now = replace(QUIET, state=codes.ARMED, received_s=rig.now_s, **board)
        rig.control.update()

    rig.link.now = replace(QUIET, state=codes.ARMING)
    rig.control.receive(rig.page, {"k": "arm", "token": rig.shown()["token"]})
    for edge in range(1, 65):
        press(edge, override=codes.OBSTACLE_FORWARD)
        rig.wait(1)
    assert (rig.row()["key"], rig.row()["state"]) == ("alert_overruled", "open")
    press(99, motion=codes.MOVING_FORWARD)
    rig.wait(3)
    assert rig.row()["state"] == "over"


def test_an_error_in_a_look_does_not_end_the_looking(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    looks = 0

    def situation() -> Situation:
        nonlocal looks
        looks += 1
        if looks > 2:
            rig.alerts._ended.set()
        raise ValueError

    rig.control.situation = situation  # type: ignore[method-assign]
    rig.alerts._run()
    assert looks == 3
    assert "error in a look" in caplog.text


def file_with(folder: Path, more: str = "") -> str:
    path = folder / "chair.toml"
    path.write_text(f'[web]\nlanguage = "en"\nstate_folder = "{folder}"\n{more}')
    return str(path)


def test_the_command_tests_every_route(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cli.main(["alert", "test", "--config", file_with(tmp_path)]) == 2
    assert "no [[alerts.route]] is configured" in capsys.readouterr().err
    routes = "".join(
        f'[[alerts.route]]\nname = "{name}"\nurl = "{name}://x"\n' for name in ("zus", "sms")
    )
    config = file_with(tmp_path, routes)
    with monkeypatch.context() as patch:
        patch.setattr(apprise_route, "send", lambda url, *_: "refused" if "sms" in url else "")
        assert cli.main(["alert", "test", "--config", config]) == 1
        assert capsys.readouterr().out == "zus: delivered\nsms: refused\n"
        patch.setattr(apprise_route, "send", lambda *_: "")
        assert cli.main(["alert", "test", "--config", config]) == 0
    monkeypatch.setattr(apprise_route, "find_spec", lambda _: None)
    assert cli.main(["alert", "test", "--config", config]) == 2
    assert "pip install 'gazechair[alerts]'" in capsys.readouterr().err


def test_the_command_lists_the_diary(
    rig: Rig, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rig.help()
    rig.wait(1)
    rig.alerts.acknowledge(rig.row()["number"], "Anna")
    Diary(tmp_path).write([*rig.alerts.as_json()["alerts"], {"key": "of another version"}])
    assert cli.main(["alert", "list", "--config", file_with(tmp_path)]) == 0
    listed = capsys.readouterr()
    assert "The driver asks for help, 1x, acknowledged by Anna\n    zus: sent\n" in listed.out
    assert listed.err == ""
    (tmp_path / "alerts.jsonl").write_text("half")
    assert cli.main(["alert", "list", "--config", file_with(tmp_path)]) == 0
    assert "alerts.jsonl: 1 damaged lines are left out" in capsys.readouterr().err


def test_help_is_the_only_alert_a_driver_makes(rig: Rig) -> None:
    rig.help()
    rig.wait(1)
    assert rig.row()["key"] == HELP_WANTED
