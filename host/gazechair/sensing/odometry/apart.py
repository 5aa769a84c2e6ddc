"""Directions of the position that nothing determines, or one thing alone, which may move.

A bed that is pushed along a corridor, or a person, looks like the end of the corridor: what it
alone tells of the position along the corridor is nothing that is known.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray

CORRELATED = 2.0
"""Errors of neighbouring points are correlated: so many points count as one."""

LEAST = 150.0
"""1/m^2: what tells less of a direction may be noise."""

_TURN_S = 0.11  # of a lidar, with some slack: half a turn sees half of a thing
_LONG_M, _WIDE_M = 3.0, 1.3  # along the direction, and across it: a bed, with who pushes it
_EDGES = 0.05, 0.95  # of the information of a thing, across: its sides


@dataclass(frozen=True)
class Constraints:
    """What points tell of the position: each in a direction of its own."""

    rows: FloatArray
    """(N, 2), the directions."""
    places_m: FloatArray
    """(N, 2)."""
    strength: FloatArray
    """(N,), 1/m^2."""

    def open_axes(self) -> list[FloatArray]:
        """The directions that are not determined by at least two things, or a wide one."""
        axes = np.linalg.eigh((self.rows.T * self.strength) @ self.rows)[1].T
        return [
            axis
            for axis, other in zip(axes, axes[::-1], strict=True)
            if not _is_by_several(
                self.places_m @ axis, self.places_m @ other, self.strength * (self.rows @ axis) ** 2
            )
        ]


class WholeTurn:
    """What the newest turn of every lidar tells; feed it each piece."""

    def __init__(self) -> None:
        self._pieces: deque[tuple[float, Constraints]] = deque()

    def take(self, at_s: float, told: Constraints) -> None:
        """Add a piece."""
        self._pieces.append((at_s, told))

    def forget(self) -> None:
        """The places of earlier pieces are unrelated."""
        self._pieces.clear()

    def until(self, at_s: float) -> list[Constraints]:
        """The pieces of the turn before a time."""
        while self._pieces and self._pieces[0][0] < at_s - _TURN_S:
            self._pieces.popleft()
        return [told for _, told in self._pieces]


def together(parts: list[Constraints]) -> Constraints:
    """Several as one."""
    return Constraints(
        np.concatenate([one.rows for one in parts]),
        np.concatenate([one.places_m for one in parts]),
        np.concatenate([one.strength for one in parts]),
    )


def _is_by_several(along_m: FloatArray, across_m: FloatArray, information: FloatArray) -> bool:
    """Whether at least two things, or a wide one, tell the position along a direction.

    (N,) each: the points along and across it, and how much each tells, 1/m^2.
    """
    total = float(information.sum())
    if total < LEAST:
        return False
    order = np.argsort(along_m)
    along, summed = along_m[order], np.concatenate(([0.0], np.cumsum(information[order])))
    ends = np.searchsorted(along, along + _LONG_M, side="right")
    within = summed[ends] - summed[:-1]
    first = int(np.argmax(within))
    if total - within[first] >= LEAST:
        return True
    thing = order[first : ends[first]]
    thing = thing[np.argsort(across_m[thing])]
    shares = np.cumsum(information[thing]) / within[first]
    left, right = across_m[thing[np.searchsorted(shares, _EDGES)]]
    return bool(right - left > _WIDE_M)
