"""The states in which anything may happen: how to get into each.

A test gets its own copy of a chair that was brought there once.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

from gazelink import codes
from gazesim.lockstep_chair import Lockstep
from keptchair import KeptChair


def chair_in(enter: Callable[[Lockstep], None]) -> Lockstep:
    """A chair of its own in that state."""
    return _in(enter).copy()


def driving(
    verb: str = "forward", mode: str = "continuous", ms: int = 600, more_ms: int = 0
) -> Lockstep:
    """A chair of its own, driven as by Lockstep.drive, for `ms` and then `more_ms`."""
    chair = _driving(verb, mode, ms).copy()
    chair.run(more_ms)
    assert not chair.neutral(), chair.why()
    return chair


@functools.cache
def _in(enter: Callable[[Lockstep], None]) -> KeptChair[Lockstep]:
    chair = Lockstep()
    enter(chair)
    return KeptChair(chair)


@functools.cache
def _driving(verb: str, mode: str, ms: int) -> KeptChair[Lockstep]:
    chair = Lockstep()
    chair.drive(verb, mode, ms)
    return KeptChair(chair)


def disarmed(chair: Lockstep) -> None:
    """Ready, driving not switched on."""
    chair.make_ready()


def arming(chair: Lockstep) -> None:
    """In the middle of the relay's test."""
    chair.make_ready()
    chair.page.arm()
    chair.until(lambda: chair.board.app.safety.state == codes.ARMING, 10)
    chair.run(30)


def armed(chair: Lockstep) -> None:
    """Armed, nothing commanded."""
    chair.arm()


def moving(chair: Lockstep) -> None:
    """Forward held."""
    chair.drive("forward")


def step(chair: Lockstep) -> None:
    """In a step forward."""
    chair.drive("forward", "step")


def turning(chair: Lockstep) -> None:
    """Left held."""
    chair.drive("left")


def step_turn(chair: Lockstep) -> None:
    """In a step to the left."""
    chair.drive("left", "step", ms=200)


def override(chair: Lockstep) -> None:
    """Overruled by an obstacle, the button still held."""
    chair.drive("forward")
    chair.world.faults.inject("obstacle", ahead_m=0.85)
    chair.until(chair.neutral, 400)
    assert chair.override() == "obstacle_forward", chair.why()
    chair.run(200)
    chair.world.faults.clear("obstacle")


def latched_fault(chair: Lockstep) -> None:
    """Emergency pressed and released: latched."""
    chair.drive("forward")
    chair.world.faults.inject("emergency")
    chair.until(chair.neutral, 10)
    chair.world.faults.clear("emergency")
    chair.run(100)


STATES: tuple[Callable[[Lockstep], None], ...] = (
    disarmed,
    arming,
    armed,
    moving,
    step,
    turning,
    step_turn,
    override,
    latched_fault,
)


def clear_latched(chair: Lockstep) -> None:
    """The caretaker resets a latched fault, if there is one."""
    if chair.board.app.safety.faults & (1 << codes.EMERGENCY):
        assert chair.host is not None
        chair.until(chair.connected, 2000)
        caretaker = chair.host.control.connect("caretaker")
        control = chair.host.control
        assert control.receive(caretaker, {"k": "reset", "token": control.token()}) == []
        chair.until(lambda: not chair.fault(codes.EMERGENCY), 100)
        chair.host.control.disconnect(caretaker)
