"""One tick as the invariants see it: before, after, what was read, what happened."""

from __future__ import annotations

from typing import Any, NamedTuple

from gazelink import codes
from gazeprove.around import Facts
from gazeprove.core import Core
from gazeprove.inputs import Scope


def bits(*faults: int) -> int:
    """The faults' bits, set."""
    return sum(1 << fault for fault in faults)


class After(NamedTuple):
    """One tick, as the invariants see it."""

    was: dict[str, Any]  # fields of safety before, time passed included
    core: Core
    read: dict[str, Any]
    facts: Facts
    linear: int
    turn: int
    fitted: bool
    simulated: bool
    moving: bool  # a wiper was written that is not neutral

    @classmethod
    def of(
        cls, was: dict[str, Any], core: Core, read: dict[str, Any], facts: Facts, scope: Scope
    ) -> After:
        """The tick that `core` has just made."""
        linear, turn = core.motion.linear_permille, core.motion.turn_permille
        fitted, simulated = scope.relay_fitted, scope.simulated
        moving = linear != 0 or turn != 0
        return cls(was, core, read, facts, linear, turn, fitted, simulated, moving)

    @property
    def reset(self) -> bool:
        """The latched faults were reset by one of the two ways there are."""
        by_order = self.facts.reset and not self.facts.new_session
        return self.facts.stepped and (by_order or self.core.safety._button_ms == 3000)

    @property
    def auto(self) -> bool:
        """It moves, and nobody holds it."""
        return self.moving and self.read.get("mode") == codes.AUTO

    @property
    def handed_over(self) -> bool:
        """Somebody else owns the chair than before this tick, or did in between."""
        s = self.core.safety
        to_and_fro = self.facts.arms > 1 and self.read.get("arm_owner") in (1, 2)
        return bool(s.state == codes.ARMED and (self.was["owner"] != s.owner or to_and_fro))

    @property
    def badly_written(self) -> bool:
        """The wipers were not read back as written, now or too often."""
        return not self.facts.verified or self.facts.often
