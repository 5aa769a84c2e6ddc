"""Latest-value slots and the health of parts."""

import threading

import pytest

from gazechair.base.health import DEGRADED, LOST, OK, STARTING, Health, HealthRegistry
from gazechair.base.latest_value import Latest


class Clock:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def test_an_empty_slot_has_no_value_and_no_age() -> None:
    slot: Latest[int] = Latest()
    assert slot.get() is None
    assert slot.age_s() is None
    assert slot.wait(0) is None


def test_the_newest_value_wins_and_ages() -> None:
    clock = Clock()
    slot: Latest[str] = Latest(clock)
    slot.put("old")
    assert slot.put("new", born_s=99.5) == 2
    clock.now_s = 101.0
    assert slot.get() == "new"
    assert slot.age_s() == 1.5


def test_waiting_ends_with_a_newer_value_only() -> None:
    slot: Latest[int] = Latest()
    version = slot.put(1)
    assert slot.wait(0, after=version) is None
    writer = threading.Thread(target=lambda: slot.put(2), name="writer")
    writer.start()
    entry = slot.wait(30, after=version)
    writer.join(30)
    assert entry is not None
    assert (entry.value, entry.version) == (2, version + 1)


def test_a_cleared_slot_is_empty_and_versions_go_on() -> None:
    slot: Latest[int] = Latest()
    slot.put(1)
    slot.clear()
    assert slot.get() is None
    assert slot.put(2) == 2


def test_a_part_begins_as_starting_with_its_own_reason() -> None:
    health = Health("lidar")
    assert (health.state, health.reason) == (STARTING, "lidar_starting")


def test_since_moves_with_state_or_reason_not_with_detail() -> None:
    clock = Clock()
    health = Health("lidar", clock)
    clock.now_s = 101
    health.set(DEGRADED, "lidar_lost", "12 points")
    clock.now_s = 102
    health.set(DEGRADED, "lidar_lost", "13 points")
    assert (health.now().since_s, health.detail) == (101, "13 points")
    health.set(OK)
    assert (health.now().since_s, health.reason, health.detail) == (102, "ok", "")


def test_changes_are_told_once() -> None:
    reported: list[int] = []
    registry = HealthRegistry(on_change=lambda: reported.append(1))
    part = registry.part("camera")
    part.set(LOST, "camera_lost")
    part.set(LOST, "camera_lost")
    assert len(reported) == 1
    assert registry.part("camera") is part


def test_a_change_is_said_once_in_the_log(caplog: pytest.LogCaptureFixture) -> None:
    part = Health("board")
    for detail in ("/dev/x is in use by another program; end that one", "still"):
        part.set(LOST, "board_lost", detail)
    assert caplog.messages == ["board is lost: /dev/x is in use by another program; end that one"]


def test_an_unknown_state_is_refused() -> None:
    with pytest.raises(ValueError, match="unwell"):
        Health("board").set("unwell")


def test_registry_as_json_tells_what_to_do() -> None:
    registry = HealthRegistry()
    registry.part("camera").set(LOST, "camera_lost", "no such device")
    registry.part("mode follow").set(LOST, "plugin_hangs")
    registry.part("board").set(LOST, "unknown_40")
    reported = registry.as_json()
    assert reported["camera"]["do"] == "Ask for help: check the camera."
    assert reported["mode follow"]["do"] == "Ask whoever set up the chair."
    assert "do" not in reported["board"]


def test_registry_as_json_tells_how_long() -> None:
    clock = Clock()
    registry = HealthRegistry(clock)
    registry.part("board").set(OK)
    clock.now_s += 2
    assert registry.as_json() == {
        "board": {"state": "ok", "reason": "ok", "detail": "", "for_s": 2.0}
    }
