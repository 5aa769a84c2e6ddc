"""The host starts and admits paired devices, whatever happened to its files and disk."""

from __future__ import annotations

import contextlib
import errno
import os
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gazechair.alerts.diary import Diary
from gazechair.base.health import Health, HealthRegistry
from gazechair.commissioning.tune.forward import ForwardNumbers
from gazechair.commissioning.tune.forward_store import ForwardStore
from gazechair.config.settings import Config
from gazechair.driving.error_handler import of_parts
from gazechair.driving.speed_cap_store import SpeedCapStore
from gazechair.first_drive.record import Record
from gazechair.people.pairing import Paired, PairingDesk
from gazechair.people.pairing.local import LocalDoor
from gazechair.people.profiles import Profiles, house_fields
from gazechair.picture.floor import FloorCamera
from gazechair.picture.floor_calibration import Calibration
from gazechair.picture.floor_store import FloorStore
from gazelink.settings_table import PROFILES

YEAR_S = 365 * 86400.0
DAMAGE: dict[str, Callable[[Path], object]] = {
    "erased": lambda file: file.unlink(),
    "empty": lambda file: file.write_bytes(b""),
    "0xff": lambda file: file.write_bytes(b"\xff" * 10_000),
    "deep": lambda file: file.write_bytes(b"[" * 100_000),
    "other json": lambda file: file.write_bytes(b'{"profiles": [1], "chosen": {}}\n7\n"x"\nnull\n'),
    "folder": lambda file: (file.unlink(), file.mkdir()),
    "loop": lambda file: (file.unlink(), file.symlink_to(file)),
}


def profiles(folder: Path) -> Profiles:
    return Profiles(folder, house_fields(Config()))


def keep_cap(folder: Path, permille: int) -> None:
    kept = SpeedCapStore(folder)
    kept.keep(permille)
    kept.write()


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_file_is_no_reason_not_to_start(tmp_path: Path, damage: str, desk: Any) -> None:
    state = tmp_path / "state"
    desk.join()
    profiles(state).change({"save": {"id": "1", "dwell_ms": 700}}, True)
    keep_cap(state, 500)
    for name in ("paired.jsonl", "profiles.json", "speed_cap"):
        DAMAGE[damage](state / name)
    again = type(desk)(state)
    assert again.who(again.join().token) is not None
    found = profiles(state)
    assert found.change({"save": {"id": "1", "dwell_ms": 800}}, True)
    assert profiles(state).chosen()["dwell_ms"] == 800
    assert SpeedCapStore(state).read() in (50, 1000)
    keep_cap(state, 300)
    assert SpeedCapStore(state).read() == 300


def test_devices_that_cannot_be_read_are_told_and_come_back_with_their_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, desk: Any
) -> None:
    """As after an edit by root: until a device is paired anew, the file stays where it is."""
    state = tmp_path / "state"
    token = desk.join().token
    read = Path.read_text

    def refused(path: Path, *args: Any, **more: Any) -> str:
        if path.name == "paired.jsonl":
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return read(path, *args, **more)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "read_text", refused)
        health = Health("devices")
        locked = type(desk)(state, health=health)
        assert locked.who(token) is None
        assert (health.state, health.reason) == ("lost", "devices_damaged")
        assert "Permission denied" in health.detail
        assert locked.problem == health.detail
    assert type(desk)(state).who(token) is not None
    # Pairing goes on, and keeps the old list beside the new one.
    fresh = locked.join().token
    assert (health.state, locked.problem) == ("ok", "")
    assert type(desk)(state).who(fresh) is not None
    (state / "paired.damaged").rename(state / "paired.jsonl")
    assert type(desk)(state).who(token) is not None


def test_a_list_of_devices_that_somebody_deletes_because_it_cannot_be_read_is_written_anew(
    tmp_path: Path, desk: Any
) -> None:
    state = tmp_path / "state"
    desk.join()
    DAMAGE["loop"](state / "paired.jsonl")
    again = type(desk)(state)
    (state / "paired.jsonl").unlink()
    token = again.join().token
    assert type(desk)(state).who(token) is not None


def test_a_clock_that_was_ahead_for_a_while_is_not_when_a_device_was_last_used(
    tmp_path: Path, desk: Any
) -> None:
    """The caretaker revokes what nobody has used for long."""
    paired = desk.join()
    right_s = desk.wall_s
    for wall_s in (right_s + 10 * YEAR_S, right_s + 60.0):
        desk.wall_s = wall_s
        desk.now_s += 100.0
        assert desk.who(paired.token) is not None
        desk.note_uses()
        assert desk.devices()[0].last_used == int(wall_s)
        assert type(desk)(tmp_path / "state").devices()[0].last_used == int(wall_s)


def test_a_caretaker_is_told_of_a_damaged_file_until_it_is_written_again(
    tmp_path: Path, desk: Any
) -> None:
    state = tmp_path / "state"
    desk.join()
    profiles(state).change({"save": {"id": "1", "dwell_ms": 700}}, True)
    keep_cap(state, 500)
    (state / "first_drive.json").write_bytes(b"")
    for name in ("paired.jsonl", "profiles.json", "speed_cap", "first_drive.json"):
        DAMAGE["0xff"](state / name)
    parts = HealthRegistry()
    again = type(desk)(state, health=parts.part("devices"))
    people = Profiles(state, house_fields(Config()), parts.part("profiles"))
    cap = SpeedCapStore(state, parts.part("speed_cap"))
    assert cap.read() == 50
    record = Record(state, parts.part("first_drive"))
    reported = {(problem.key, problem.caretaker_only) for problem in of_parts(parts.states())}
    assert reported == {("devices_damaged", True), ("file_damaged", True)}
    assert {part.reason for part in parts.states().values()} == {key for key, _ in reported}
    again.join()
    people.change({"save": {"id": "1", "dwell_ms": 800}}, True)
    cap.keep(500)
    cap.write()
    record.keep("turn", {"wanted_deg": 90, "turned_deg": 90, "measured_mm": 1, "seen_mm": 1})
    assert of_parts(parts.states()) == []


@pytest.mark.parametrize("damage", ["0xff", "deep", "other json", "loop"])
def test_a_caretaker_is_told_of_damaged_alerts_and_calibrations_until_they_are_written_again(
    tmp_path: Path, damage: str
) -> None:
    parts = HealthRegistry()

    def stores() -> tuple[Diary, ForwardStore, FloorStore]:
        diary = Diary(tmp_path, parts.part("alert_diary"))
        diary.read()
        forward = ForwardStore(tmp_path, parts.part("forward"))
        return diary, forward, FloorStore(tmp_path, parts.part("camera_floor"))

    def write(diary: Diary, forward: ForwardStore, floor: FloorStore) -> None:
        assert diary.write([{"number": 1, "state": "open"}])
        with contextlib.suppress(OSError):  # a link to itself stays until somebody looks
            forward.keep(PROFILES[0], ForwardNumbers(1.0, 0.1, 0.1, 0.1, 1.0, 1.0))
        camera = FloorCamera(640, 480, 500.0, 1.0, 20.0, 0.0, 0.0, 0.0)
        floor.keep(Calibration(camera, 0.01, 0.01))
        assert floor.get() is not None

    write(*stores())
    assert of_parts(parts.states()) == []
    for name in ("alerts.jsonl", "forward.json", "camera_floor.json"):
        DAMAGE[damage](tmp_path / name)
    again = stores()
    reported = [(problem.key, problem.caretaker_only) for problem in of_parts(parts.states())]
    assert reported == [("file_damaged", True)] * 3
    write(*again)
    left = {name for name, part in parts.states().items() if part.reason != "ok"}
    assert left == ({"forward"} if damage == "loop" else set())


def test_a_diary_on_a_full_disk_is_told_and_kept_when_there_is_space_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = HealthRegistry()
    diary = Diary(tmp_path, parts.part("alert_diary"))
    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", _full)
        assert not diary.write([{"number": 1}])
        (reported,) = of_parts(parts.states())
        assert (reported.key, reported.caretaker_only) == ("not_kept", True)
    assert diary.write([{"number": 1}])
    assert of_parts(parts.states()) == []
    assert diary.read() == [{"number": 1}]


def _full(_: int) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


class Hanging:
    """A disk that hangs at its next sync, until released."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.requested, self.gate = threading.Event(), threading.Event()
        fsync = os.fsync

        def hang(handle: int) -> None:
            self.requested.set()
            assert self.gate.wait(60)
            fsync(handle)

        monkeypatch.setattr(os, "fsync", hang)

    def during(self, act: Callable[[], object]) -> threading.Thread:
        thread = threading.Thread(target=act, daemon=True)
        thread.start()
        assert self.requested.wait(60)
        return thread


def test_a_disk_that_hangs_keeps_no_known_device_out(
    desk: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    paired = desk.join()
    desk.wall_s += 7200
    disk = Hanging(monkeypatch)
    desk.who(paired.token)
    thread = disk.during(desk.note_uses)
    assert desk.who(paired.token) == paired.device
    assert desk.is_paired(paired.device.id)
    assert desk.devices()[0].last_used > paired.device.last_used
    assert desk.new_code("viewer")
    disk.gate.set()
    thread.join(60)
    assert desk.who(paired.token).last_used == int(desk.wall_s)


def test_a_disk_that_hangs_at_a_pairing_holds_up_no_wrong_code_and_a_right_one_pairs_once(
    desk: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = desk.new_code("driver").text
    disk = Hanging(monkeypatch)
    found: list[object] = []

    def pair() -> None:
        found.append(desk.pair(code, "tablet", "192.0.2.1"))

    first, second = disk.during(pair), threading.Thread(target=pair, daemon=True)
    second.start()  # tapped twice
    wrong = threading.Thread(target=lambda: found.append(desk.guess()), daemon=True)
    wrong.start()
    wrong.join(20)
    assert found == ["wrong_code"]
    disk.gate.set()
    for thread in (first, second):
        thread.join(60)
    assert sorted(type(one).__name__ for one in found[1:]) == ["Paired", "Rejected"]
    assert len(desk.devices()) == 1


def test_a_disk_that_hangs_at_a_profile_does_not_hold_up_who_reads_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the alerts do, which tell the driver's name."""
    mine = profiles(tmp_path)
    disk = Hanging(monkeypatch)
    thread = disk.during(lambda: mine.change({"save": {"id": "1", "name": "Kees"}}, True))
    assert mine.chosen()["name"] != "Kees"
    assert mine.as_json()["profiles"]
    disk.gate.set()
    thread.join(60)
    assert mine.chosen()["name"] == "Kees"


def test_of_two_who_set_the_speed_cap_the_last_one_s_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = SpeedCapStore(tmp_path)
    kept.start()
    disk = Hanging(monkeypatch)
    disk.during(lambda: kept.keep(500)).join(60)
    for permille in (400, 300):
        kept.keep(permille)  # while the disk hangs
    disk.gate.set()
    kept.stop()
    assert kept.read() == 300


def test_a_disk_that_has_become_read_only_does_not_keep_the_host_from_starting(
    desk: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = tmp_path / "state"
    token = desk.join().token
    opened = os.open

    def read_only(path: Any, flags: int, *more: Any) -> int:
        if flags & (os.O_CREAT | os.O_WRONLY | os.O_RDWR):
            raise OSError(errno.EROFS, os.strerror(errno.EROFS))
        return opened(path, flags, *more)

    def refuse(*_: object) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(os, "open", read_only)
    monkeypatch.setattr(os, "fchmod", refuse)
    again: PairingDesk = type(desk)(state)
    door = LocalDoor(again, state, lambda: "")
    door.start()
    assert again.who(token) is not None
    again.note_uses()
    door.stop()


def test_pairing_goes_on_after_a_disk_that_was_full(
    desk: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = desk.new_code("driver").text

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(Exception, match="disk full"):
            desk.pair(code, "x", "192.0.2.1")
    assert isinstance(desk.pair(code, "x", "192.0.2.1"), Paired)
