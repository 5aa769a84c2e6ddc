"""What the board has refused on the way to one goal, and what another try there costs."""

from __future__ import annotations

from gazechair.going.plan import Pose, Refused
from gazechair.going.stuck import apart

_AGAIN_S, _SHUT_S = 12.0, 60.0


class Refusals:
    """Refused poses, the newest last."""

    def __init__(self) -> None:
        self._refused: list[Refused] = []

    @property
    def all(self) -> tuple[Refused, ...]:
        """For the planner."""
        return tuple(self._refused)

    @property
    def may_pass(self) -> bool:
        """Whether a path that meets the newest refusal again is still worth a try."""
        return bool(self._refused) and self._refused[-1].price_s < _SHUT_S

    def add(self, pose: Pose, turns: bool, shut: bool, person: bool = False) -> None:
        """Record that the board refuses to turn, or to drive on; `shut`: waiting was in vain.

        `person`: it stands before what may be a person.
        """
        again = any(self._same(one, pose, turns) for one in self._refused)
        price_s = _SHUT_S if shut or again else _AGAIN_S
        self._refused.append(Refused(*pose, turns, price_s, person))

    def shut_before(self, pose: Pose, turns: bool) -> bool:
        """Whether this pose was shut already before the newest refusal."""
        return any(
            self._same(one, pose, turns) and one.price_s >= _SHUT_S for one in self._refused[:-1]
        )

    @staticmethod
    def _same(one: Refused, pose: Pose, turns: bool) -> bool:
        return one.turns == turns and not apart(one.pose, pose)
