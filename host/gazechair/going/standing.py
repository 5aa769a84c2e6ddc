"""Finds what the board may take for a standing person: isolated things of a person's width.

The board stops the chair some 0.7 m before them, until they have stood still for ten seconds, and
creeps from then on (sensing.clearance.standing). Paths that head for them cost more.
"""

from __future__ import annotations

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray
from gazechair.base.footprint import Footprint
from gazechair.going.outline import outline
from gazechair.sensing.clearance.standing import WIDE_M
from gazechair.sensing.clearance.stood import CALM_S

STOPS_M = 0.75
"""Distance before such a thing at which the board stops the chair, an error of the map included."""
WAITS_S, CREEPS_S_PER_M = CALM_S + 2.0, 12.0
PATIENCE_S = CALM_S + 3.0
"""Waiting before such a thing for longer does not help: it is none, or the way stays blocked."""
_CELLS_M = 0.005, 0.1  # in a map's cells a thing is up to this much narrower or wider
_WIDE_M = WIDE_M[0] - _CELLS_M[0], WIDE_M[1] + _CELLS_M[1]
_APART_CELLS = 2  # nearer cells are parts of one thing
_BESIDE_M = 0.07  # added on each side of the chair: margin, errors of the pose and of steering


def standing_m(occupied: BoolArray, cell_m: float, low_m: FloatArray) -> FloatArray:
    """Centres (N, 2) of the cells of such things, in the map's frame."""
    left = {(int(x), int(y)) for x, y in np.argwhere(occupied)}
    reach = range(-_APART_CELLS, _APART_CELLS + 1)
    around = [(dx, dy) for dx in reach for dy in reach if dx or dy]
    found: list[tuple[int, int]] = []
    while left:
        begin = left.pop()
        thing, todo = [begin], [begin]
        while todo:
            x, y = todo.pop()
            for dx, dy in around:
                near = (x + dx, y + dy)
                if near in left:
                    left.remove(near)
                    thing.append(near)
                    todo.append(near)
        size = np.ptp(np.array(thing), axis=0) + 1
        if (
            _WIDE_M[0] <= float(size.max()) * cell_m
            and float(np.hypot(*size)) * cell_m <= (_WIDE_M[1])
        ):
            found += thing
    cells = np.array(found, dtype=np.float64).reshape(-1, 2)
    return np.asarray((cells + 0.5) * cell_m + low_m)


class Ahead:
    """Tells whether such a thing is ahead of a chair with a given footprint."""

    def __init__(self, footprint: Footprint) -> None:
        ends = np.concatenate(outline(footprint))
        self._front_m, self._rear_m = float(ends[:, 0].max()), float(-ends[:, 0].min())
        self.half_m = float(np.abs(ends[:, 1]).max()) + _BESIDE_M

    @property
    def reach_m(self) -> tuple[float, float]:
        """Range of distances ahead of the drive axle in which such a thing stops the chair."""
        return self._front_m, self._front_m + STOPS_M

    def leg_s(self, things_m: FloatArray, a: FloatArray, b: FloatArray, backward: bool) -> float:
        """Seconds that they cost on the straight leg from `a` to `b`."""
        along = b - a
        length = float(np.hypot(*along))
        if not len(things_m) or length < 1e-6:
            return 0.0
        along = along / length
        off = things_m - a
        ahead = off @ along - (self._rear_m if backward else self._front_m)
        across = off[:, 0] * -along[1] + off[:, 1] * along[0]
        met = ahead[(np.abs(across) < self.half_m) & (ahead > 0.0) & (ahead < length + STOPS_M)]
        if not len(met):
            return 0.0
        return WAITS_S + CREEPS_S_PER_M * min(length, length + STOPS_M - float(met.min()))

    def meets(self, things_m: FloatArray, poses: FloatArray) -> bool:
        """Whether one stops a chair that drives forward at one of the poses (N, 3)."""
        off = things_m[:, None, :] - poses[:, :2]
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        ahead = off[..., 0] * c + off[..., 1] * s - self._front_m
        across = off[..., 1] * c - off[..., 0] * s
        return bool(((np.abs(across) < self.half_m) & (ahead > 0.0) & (ahead < STOPS_M)).any())
