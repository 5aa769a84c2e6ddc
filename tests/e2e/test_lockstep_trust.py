"""What the board believes about the chair end to end: the driver turns the chair's own knob."""

from __future__ import annotations

import pytest

from e2e import states
from gazeboard.core import limits
from gazesim.lockstep_chair import Lockstep
from promises import END_TO_END, kept

pytestmark = pytest.mark.costly

STANDS_MS = 2500 + limits.TRUST_STANDING_MS


def trusted_in_1_2(chair: Lockstep) -> None:
    """Profile 1.2 selected on both sides, all that settings may let out, and trust gained."""
    chair.world.chair.set_profile("1.2")
    app = chair.board.app
    app.settings.profile = 0
    app.settings.linear_permille = app.settings.turn_permille = 1000
    app._apply_settings()
    chair.drive("left", ms=4000)
    assert app.profile_check.agreed


def drive_at_a_wall(chair: Lockstep) -> None:
    """Straight on with a wall ahead; the board's bound is never below what the chair does."""
    chair.world.faults.inject("obstacle", ahead_m=2.6, left_m=0.0, size_m=1.0)
    chair.page.press("forward", "continuous")
    fastest, stood_ms = 0.0, 0
    for _ in range(9_000):
        chair.one_ms()
        stood_ms = stood_ms + 1 if fastest and chair.stands() else 0
        if stood_ms > 1000:
            break
        speed = chair.world.chair.speed_m_s * 1000
        fastest = max(fastest, speed)
        bound = chair.board.app.speed_mm_s()
        # What an uneven floor adds is within the margin.
        assert speed <= bound * 1.1 + 10, chair.why()
        assert not chair.world.collisions, (speed, bound, chair.why())
    assert fastest > 150, "it drove"


def test_a_knob_turned_at_a_standstill_is_not_overlooked() -> None:
    chair = states.chair_in(trusted_in_1_2)
    chair.page.release()
    chair.run(STANDS_MS)
    chair.world.chair.set_profile("5.1")
    drive_at_a_wall(chair)
    kept(END_TO_END, "P5", "the chair's profile is switched on its own knob")


def test_trust_gained_long_ago_is_over_while_it_drives() -> None:
    """Straight on for half a minute, then the knob: from there on the fastest chair counts."""
    chair = states.chair_in(trusted_in_1_2)
    chair.page.release()
    chair.run(100)
    chair.page.press("forward", "continuous")
    chair.until(lambda: not chair.board.app.profile_check.agreed, limits.TRUST_MS)
    assert not chair.neutral()
    chair.world.chair.set_profile("5.1")
    drive_at_a_wall(chair)
