"""Arming end to end: what must hold, and the reason when it does not; and the clocks' wrap."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from e2e import states
from gazeboard.core import ages
from gazelink import codes
from gazesim.lockstep_chair import Lockstep
from promises import END_TO_END, kept

pytestmark = pytest.mark.costly


def refused(chair: Lockstep, reason: str) -> None:
    """Not armed when asked, and the page is told why."""
    chair.page.arm()
    chair.stays_still(400)
    assert not chair.armed(), chair.why()
    assert chair.page.shown["arm_reason"] == reason, chair.page.shown


def inject(fault: str, **arguments: float) -> Callable[[Lockstep], None]:
    return lambda chair: chair.world.faults.inject(fault, **arguments)


def spoil_calibration(chair: Lockstep) -> None:
    chair.board.power_off()
    chair.board.files.texts["settings.json"] = '{"linear_permille": 600}\nbad00bad\n'
    chair.board.power_on()


def pull(chair: Lockstep) -> None:
    chair.cable.pull()


def real_board(chair: Lockstep) -> None:
    chair.board.app.safety.ages.words[ages.SIMULATED] = 0  # what teensy40.py tells it


def weld(chair: Lockstep) -> None:
    chair.world.faults.inject("relay_stuck_closed")


CASES: dict[str, Any] = {
    "not_connected": pull,
    "obstacle_data_old": inject("lidar_stall"),
    "heading_frozen": inject("imu_freeze"),
    "heading_bus": inject("imu_nak"),
    "tilt": inject("tilt", pitch_deg=20.0),
    "wiper": inject("wiper_nak"),
    "emergency": inject("emergency"),
    "relay_stuck": weld,
    "relay_open": inject("relay_stuck_open"),
    "calibration": spoil_calibration,
    "simulated_source": real_board,
}


@pytest.mark.parametrize("reason", CASES)
def test_arming_is_refused_with_the_reason(reason: str) -> None:
    chair = states.chair_in(states.disarmed)
    CASES[reason](chair)
    chair.stays_still(1500)
    if reason == "relay_open":
        chair.page.arm()  # only the test of the relay itself can show it
        chair.stays_still(250)
    refused(chair, reason)
    kept(END_TO_END, "arming", reason)


def test_arming_waits_for_half_a_second_of_proven_neutral() -> None:
    chair = Lockstep()
    chair.until(chair.connected, 400)
    chair.until(lambda: chair.board.app.safety.faults == 0, 400)
    refused_ms = chair.now_ms
    chair.page.arm()
    chair.run(20)
    assert codes.reason_name(chair.board.app.safety.arm_reason) == "neutral_not_proven"
    assert refused_ms < 500
    kept(END_TO_END, "arming", "neutral_not_proven")


def test_arming_is_refused_while_something_is_commanded() -> None:
    chair = states.chair_in(states.disarmed)
    inbox = chair.board.app.inbox  # the host's own arbiter would not let it through: straight in

    def command() -> None:
        inbox.back.verb, inbox.back.ttl_ms = codes.FORWARD, 300
        inbox.back.command_count = (inbox.back.command_count + 1) & 0xFFFF
        inbox.touch()

    chair.watchers.append(command)
    chair.run(200)
    chair.page.arm()
    chair.stays_still(400)
    assert not chair.armed()
    assert codes.reason_name(chair.board.app.safety.arm_reason) == "command_active"
    kept(END_TO_END, "arming", "command_active")


def test_each_arming_proves_the_relay_open_then_closed(chair: Lockstep) -> None:
    chair.make_ready()
    assert not chair.world.relay.closed
    chair.page.arm()
    chair.until(lambda: chair.world.relay.closed, 100)
    assert not chair.armed()  # closed, but not yet for long enough
    chair.until(chair.armed, 200)
    chair.page.say(k="disarm")
    chair.until(lambda: not chair.world.relay.closed, 30)
    kept(END_TO_END, "arming", "relay proven")


def test_a_relay_that_opens_while_driving_disarms(driving: Lockstep) -> None:
    driving.world.faults.inject("relay_stuck_open")
    driving.until(driving.neutral, 40)
    assert driving.fault(codes.RELAY_OPEN)
    assert not driving.armed()
    driving.world.faults.clear("relay_stuck_open")
    driving.needs_a_new_press()


def test_ready_again_by_itself_when_the_cause_has_gone() -> None:
    for fault in ("lidar_stall", "imu_freeze", "imu_nak", "imu_bus_stuck", "tilt"):
        chair = states.driving()
        chair.world.faults.inject(fault)
        chair.run(1000)
        chair.page.release()
        chair.world.faults.clear(fault)
        chair.until(lambda c=chair: c.board.app.safety.faults == 0, 4000)
        chair.needs_a_new_press()


def test_nothing_changes_when_the_microsecond_clock_wraps() -> None:
    for before_ms in (100, 700, 1200, 2000):  # while starting, arming, about to drive, driving
        chair = Lockstep(start_us=(1 << 30) - before_ms * 1000 - 500)
        chair.drive()
        for _ in range(2000):
            chair.one_ms()
            assert not chair.neutral(), chair.why()
        assert chair.board.app.safety.faults == 0
        assert chair.board.clock.ticks_us() < 1 << 29
        chair.page.release()
        chair.until(chair.neutral, 5)
        chair.needs_a_new_press("left")
    kept(END_TO_END, "P14", "the clock wraps at 2^30 us")


@pytest.mark.parametrize("wrap", [1 << 16, 1 << 30], ids=["on the wire", "on the board"])
def test_nothing_changes_when_the_tick_counters_wrap(wrap: int) -> None:
    for before_ms in (300, 1200, 2500):
        chair = Lockstep()
        chair.board.app.outbox.ticks = wrap - before_ms  # before it has said its first word
        chair.drive(ms=100)
        for _ in range(2000):
            chair.one_ms()
            assert not chair.neutral(), chair.why()
        assert chair.board.app.safety.faults == 0
        assert chair.board.app.outbox.ticks & 0xFFFF < 4000
