"""What lies around safety and motion in a tick, each answer chosen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from gazeboard.core.motion import Motion
from gazeboard.core.safety import Safety
from gazeboard.core.tick import Tick

AUTO_CAP = 400  # permille, of an auto motion


@dataclass
class Facts:
    """What happened in one tick besides the inputs, for the invariants."""

    contact: bool
    emergency_open: bool
    message: bool
    button: bool
    late: bool
    disarm: bool
    arms: int
    reset: bool
    stopped: bool
    new_session: bool
    presses: int = 0  # by anyone, with this tick
    verified: bool = True
    raised: bool = False
    stepped: bool = True
    toggled: bool = False
    well: bool = True
    end_reason: int | None = None
    disobeys: bool = False
    often: bool = False  # writes fail often, though never three in a row


class Raised(Exception):
    """An exception in the tick, wherever."""


class Around:
    """Obstacles, obedience, profile check and clock at once, as `facts` and `strikes` say."""

    agreed = sluggish = owes = False
    arcs = None
    caps = (1000, 1000, 1000, 1000)  # what obstacles permit beside the blocked bits only reduces
    auto_caps = (AUTO_CAP,) * 4

    facts: Facts
    strikes: Callable[[str], bool]

    def __init__(self) -> None:
        self.blocked: Any = 15
        self.motion: Motion

    def tick(self, safety: Safety, motion: Motion) -> Tick:
        """The order of a tick with these two and what lies around them."""
        self.motion = motion
        return Tick(safety, motion, self, _Obedience(self), self, self)

    @property
    def late(self) -> bool:
        """What the clock says."""
        return self.facts.late

    def step(self, i: Any, *_of_the_tick: Any) -> None:
        """What obstacles block; the profile check decides nothing."""
        self.blocked = i.clearance_blocked

    def auto_blocked(self, i: Any) -> Any:
        """For an auto motion, what no lidar sees, too."""
        return Both(i.clearance_blocked, i.clearance_unseen)


class Both:
    """Bits that are set when either's are."""

    def __init__(self, one: Any, other: Any) -> None:
        self._either = one, other

    def __and__(self, mask: int) -> Any:
        if mask == 15:
            return self
        one, other = self._either
        return one & mask | other & mask


class _Obedience:
    """Whether the chair obeys, and whether writes fail too often."""

    wiper_debt = 1  # asked after each write

    def __init__(self, around: Around) -> None:
        self._around = around

    def step(self, _i: Any, _linear_permille: int, _turn_permille: int, armed: bool) -> bool:
        """After the motion."""
        facts, motion = self._around.facts, self._around.motion
        if motion.ended:
            facts.end_reason = motion.end_reason
        if facts.raised:
            raise Raised
        facts.disobeys = armed and self._around.strikes("obeys")
        return facts.disobeys

    def wipers_written(self, _verified: bool) -> bool:
        """After the write."""
        self._around.facts.often = self._around.strikes("often")
        return self._around.facts.often
