"""P21 end to end: something between the wipers and the chair holds the turn axis deflected."""

from __future__ import annotations

import pytest

from e2e import states
from gazeboard.core import limits
from gazelink import codes
from gazesim.lockstep_chair import Lockstep
from promises import END_TO_END, measured


def trips(chair: Lockstep, cause: str) -> None:
    """Disarmed within the promise's time, neutral, latched; the relay then stops the chair."""
    ms = chair.until(lambda: chair.fault(codes.DISOBEYS), 4000)
    assert not chair.armed()
    assert chair.wipers() == (170, 170)
    measured(END_TO_END, "P21", cause, ms, limits.OBEYS_MS)
    chair.run(20)
    assert chair.enable_off()
    chair.comes_to_rest()
    assert chair.page.shown["arm_reason"] == "disobeys"
    chair.world.faults.clear("joystick_stuck")
    chair.page.release()
    chair.run(200)
    assert chair.fault(codes.DISOBEYS)
    assert chair.host is not None
    caretaker = chair.host.control.connect("caretaker")
    control = chair.host.control
    assert control.receive(caretaker, {"k": "reset", "token": control.token()}) == []
    chair.until(lambda: not chair.fault(codes.DISOBEYS), 100)
    chair.arm()


@pytest.mark.parametrize("turn", [1.0, -0.5])
def test_p21_turning_on_with_neutral_put_out(turn: float) -> None:
    chair = states.driving("left" if turn > 0 else "right")
    chair.world.faults.inject("joystick_stuck", turn=turn)
    chair.page.release()
    chair.until(lambda: chair.wipers() == (170, 170), 100)
    trips(chair, "turns on with neutral put out")


def test_p21_turning_against_the_command() -> None:
    chair = states.driving("left", ms=400)
    chair.world.faults.inject("joystick_stuck", turn=-1.0)
    trips(chair, "turns against the command, its braking and starting included")


def test_p21_beginning_to_turn_at_a_standstill() -> None:
    chair = Lockstep()
    chair.arm()
    chair.run(2500)
    chair.world.faults.inject("joystick_stuck", turn=0.5)
    trips(chair, "begins to turn at a standstill, the chair's start included")
