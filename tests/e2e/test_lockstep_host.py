"""P2 and P9 end to end: the host is killed, stopped or cut off; the board's service loop stalls."""

from __future__ import annotations

import pytest

from e2e import states
from gazeboard.core import limits
from gazelink import codes
from gazesim.lockstep_chair import Lockstep
from promises import END_TO_END, measured

pytestmark = pytest.mark.costly

PHASES_MS = (0, 6, 13, 19)  # of the 20 ms in which the host repeats a command


def note_silence(chair: Lockstep, cause: str) -> None:
    """From the last decoded frame until both wipers are neutral."""
    received_before_ms = chair.unheard_ms
    neutral_ms = chair.until(chair.neutral, 150)
    silent_ms = received_before_ms + neutral_ms
    measured(END_TO_END, "P2", cause, silent_ms, limits.HOST_SILENT_MS)


def note_disarmed(chair: Lockstep, cause: str) -> None:
    chair.until(lambda: not chair.armed(), 600)
    measured(END_TO_END, "P2", f"{cause}: disarmed", chair.unheard_ms, limits.HOST_LOST_MS)


@pytest.mark.parametrize(
    ("verb", "mode"),
    [("forward", "continuous"), ("left", "continuous"), ("forward", "step"), ("right", "step")],
)
def test_p2_host_killed(verb: str, mode: str) -> None:
    for phase_ms in PHASES_MS:
        chair = states.driving(verb, mode, 300)
        chair.until(lambda c=chair: c.unheard_ms == 0, 20)
        chair.run(phase_ms)
        chair.kill_host()
        note_silence(chair, "host killed")
    note_disarmed(chair, "host killed")
    chair.comes_to_rest()
    chair.start_host()
    chair.needs_a_new_press()


@pytest.mark.parametrize("frozen_ms", [150, 320, 480, 1000, 3000])
def test_p2_host_stopped_then_going_on_with_a_backlog(frozen_ms: int) -> None:
    for phase_ms in PHASES_MS:
        chair = states.driving()
        chair.until(lambda c=chair: c.unheard_ms == 0, 20)
        chair.run(phase_ms)
        assert chair.host is not None
        chair.host.frozen = True
        note_silence(chair, "host stopped")
    if frozen_ms > 600:
        note_disarmed(chair, "host stopped")
    chair.stays_still(max(0, frozen_ms - chair.unheard_ms))
    chair.host.frozen = False  # the page has gone on holding all the time
    chair.needs_a_new_press()


def test_p2_a_host_stopped_for_less_than_the_promise_changes_nothing(driving: Lockstep) -> None:
    assert driving.host is not None
    for _ in range(5):
        driving.host.frozen = True
        driving.run(60)
        driving.host.frozen = False
        for _ in range(200):
            driving.one_ms()
            assert not driving.neutral(), driving.why()


def test_p2_cable_pulled(driving: Lockstep) -> None:
    driving.cable.pull()
    note_silence(driving, "cable pulled")
    note_disarmed(driving, "cable pulled")
    driving.stays_still(1000)
    driving.cable.plug()
    driving.needs_a_new_press()


@pytest.mark.parametrize("blocked_ms", [60, 300, 480])
def test_p9_service_loop_blocked_in_usb(driving: Lockstep, blocked_ms: int) -> None:
    driving.board.blocked = True
    neutral_ms = driving.until(driving.neutral, 100)
    measured(END_TO_END, "P9", "service loop blocked", neutral_ms, limits.SERVICE_STALLED_MS)
    driving.stays_still(blocked_ms - neutral_ms)
    driving.board.blocked = False  # half a second of frames waits in the line
    driving.needs_a_new_press()
    assert driving.board.watchdog_bites == 0


def test_p9_service_loop_blocked_for_good_disarms_then_the_watchdog_resets(
    driving: Lockstep,
) -> None:
    driving.board.blocked = True
    gone_ms = driving.until(lambda: not driving.armed(), 600)
    cause = "service loop blocked: disarmed"
    measured(END_TO_END, "P9", cause, gone_ms, limits.SERVICE_LOST_MS)
    driving.until(lambda: driving.board.watchdog_bites == 1, 20)
    driving.board.blocked = False
    driving.until(lambda: driving.board.app is not None, 400)
    assert driving.board.app.reset_cause == 3
    driving.needs_a_new_press()


def test_p9_a_line_that_takes_nothing_holds_nothing_up(driving: Lockstep) -> None:
    driving.cable.to_host.take = lambda limit: b""  # the host's process reads no more
    neutral_ms = driving.until(driving.neutral, 500)
    assert neutral_ms <= limits.COMMAND_TTL_MS + limits.FRAME_STALE_MS
    assert driving.board.app.safety.faults & (1 << codes.SERVICE_STALLED) == 0
    driving.comes_to_rest()
