"""The speed cap outlasts the host."""

from __future__ import annotations

import errno
import logging
import threading
from pathlib import Path
from typing import Any

import pytest

from gazechair.base import state_file
from gazechair.base.health import OK, HealthRegistry
from gazechair.base.reasons import SPEED_CAP
from gazechair.base.state_folder import replace_file
from gazechair.config.settings import Config
from gazechair.driving import speed_cap_store
from gazechair.driving.control import Control
from gazechair.driving.speed_cap_store import SpeedCapStore
from patience import wait_until


class NoBoard:
    """A link without a board."""

    def __getattr__(self, _: str) -> Any:
        return lambda *_: None


def host(folder: Path | None) -> Control:
    parts = HealthRegistry()
    for name in ("board", "lidar", "camera"):
        parts.part(name).set(OK)
    kept = SpeedCapStore(folder, parts.part(SPEED_CAP))
    return Control(Config(), NoBoard(), parts, speed_cap=kept)


def cap_of(control: Control) -> int:
    return int(control.snapshot(control.connect("viewer"))["cap_permille"])


def test_a_cap_set_by_a_caretaker_holds_after_a_restart(tmp_path: Path) -> None:
    for before, permille in ((1000, 300), (300, 500), (500, 1000)):
        control = host(tmp_path / "state")
        assert cap_of(control) == before
        control.start()
        caretaker = control.connect("caretaker")
        for requested in (400, permille):
            assert control.receive(caretaker, {"k": "cap", "permille": requested}) == []
        control.stop()
    assert cap_of(host(tmp_path / "state")) == 1000


def test_a_disk_that_hangs_does_not_delay_a_stop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hangs, gate = threading.Event(), threading.Event()

    def hang(*_: object) -> None:
        hangs.set()
        assert gate.wait(60)

    monkeypatch.setattr(state_file, "replace_file", hang)
    control = host(tmp_path)
    control.start()
    caretaker = control.connect("caretaker")

    def say() -> None:
        control.receive(caretaker, {"k": "cap", "permille": 300})
        control.receive(caretaker, {"k": "stop"})

    page = threading.Thread(target=say, daemon=True)
    page.start()
    assert hangs.wait(60)
    page.join(10)
    assert not page.is_alive()
    assert control.stopped_s() > 0
    gate.set()
    control.stop()


def test_a_refused_cap_changes_nothing(tmp_path: Path) -> None:
    control = host(tmp_path)
    driver = control.connect("driver")
    assert control.receive(driver, {"k": "cap", "permille": 300})[0]["reason"] == "not_allowed"
    assert cap_of(host(tmp_path)) == 1000


@pytest.mark.parametrize(("text", "cap"), [("", 50), ("fast", 50), ("-1", 50), ("9999", 1000)])
def test_a_damaged_file_is_slow_never_fast(tmp_path: Path, text: str, cap: int) -> None:
    (tmp_path / "speed_cap").write_text(text)
    assert SpeedCapStore(tmp_path).read() == cap


def test_a_disk_that_takes_nothing_does_not_undo_the_cap(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("")
    control = host(None)
    control._speed_cap = SpeedCapStore(tmp_path / "file")
    control.start()
    caretaker = control.connect("caretaker")
    with caplog.at_level(logging.WARNING):
        control.receive(caretaker, {"k": "cap", "permille": 300})
        control.stop()
    assert cap_of(control) == 300
    assert "the speed cap ends with this host" in caplog.text


def test_a_cap_that_is_not_stored_is_told_to_the_caretaker_and_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    full = [True]

    def write(path: Path, content: bytes, *_: object) -> None:
        if full[0]:
            raise OSError(errno.ENOSPC, "No space left on device")
        replace_file(path, content)

    monkeypatch.setattr(speed_cap_store, "_WRITE_AGAIN_S", 0.05)
    monkeypatch.setattr(state_file, "replace_file", write)
    control = host(tmp_path)
    control.start()
    pages = [control.connect(role) for role in ("caretaker", "driver")]

    def shown() -> list[str]:
        control.update()
        return [str(control.snapshot(page)["message"]) for page in pages]

    control.receive(pages[0], {"k": "cap", "permille": 300})
    wait_until(lambda: shown() == ["not_kept", "ok"])
    assert cap_of(control) == 300
    full[0] = False
    wait_until(lambda: shown() == ["ok", "ok"])
    assert cap_of(host(tmp_path)) == 300
    control.stop()


def test_a_newer_cap_replaces_one_that_could_not_be_stored(tmp_path: Path) -> None:
    (tmp_path / "state").write_text("")
    kept = SpeedCapStore(tmp_path / "state")
    kept.keep(300)
    kept.write()
    kept.keep(400)
    (tmp_path / "state").unlink()
    kept.write()
    assert kept.read() == 400
    (tmp_path / "state" / "speed_cap").unlink()
    kept.write()
    assert kept.read() == 1000  # nothing is left to be written
