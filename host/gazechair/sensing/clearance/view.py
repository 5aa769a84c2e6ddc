"""Determines whether the lidars see each part of a motion's sweep: seen, blind or never seen."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gazechair.base.arrays import ByteArray, FloatArray, IntArray
from gazechair.base.footprint import Footprint, Margins, inside
from gazechair.sensing.clearance.arcs import ArcReach, corners_of
from gazechair.sensing.clearance.sweeps import Sweeps
from gazechair.sensing.clearance.zone import UNKNOWN, StopZone
from gazechair.sensing.lidar.blind import BINS, BLIND, SEEN
from gazelink import arcs, codes

_CELL_M = 0.03
_BORDER_M = 0.8  # the straight sweeps end this far before and behind the outline

States = NDArray[np.uint8]


class SweepView:
    """The sweeps of one footprint, within the stop zone, as the lidars at `origins_m` see them."""

    def __init__(self, footprint: Footprint, origins_m: Sequence[tuple[float, float]]) -> None:
        self._cells, self._contacts, self._ways = _cells_round(corners_of(footprint))
        self._origins_m = tuple(origins_m)
        self.use(UNKNOWN)

    def use(self, zone: StopZone) -> None:
        """Use another stop zone: each sweep ends where the chair has stopped."""
        # Per direction, the bins of its cells, a column for each lidar, without equal rows.
        ends = np.where(np.isfinite(self._contacts), self._contacts, np.nan) <= zone.far
        self._bins = [
            _bins(self._cells[ends[:, direction]], self._origins_m)
            for direction in range(len(codes.DIRECTIONS))
        ]
        # The same for driving and turning at once, per quadrant.
        self._arc_bins = []
        for quadrant in range(arcs.QUADRANTS):
            ways = self._ways[:, _arc_column(quadrant, zone)]
            units = 1000.0 * zone.far[quadrant % 2] / arcs.UNIT_MM
            swept = (ways <= units) & (ways < arcs.FAR)
            self._arc_bins.append(_bins(self._cells[swept], self._origins_m))

        self._judged: tuple[bytes | None, tuple[int, int, int]] = (None, (0, 0, 0))

    def judge(self, states: Sequence[States]) -> tuple[int, int, int]:
        """(blind, unseen, arc views) from each lidar's 360 states (SEEN, BLIND, MASKED).

        Blind and unseen have a bit per direction. A place that any lidar sees is seen. Blind: the
        sweep enters a place that would be seen if a lidar were not blind there. Unseen: it enters a
        place that no lidar ever sees. Arc views: the same with a bit per quadrant, blind in the low
        nibble, unseen in the high one.
        """
        same = b"".join(one.tobytes() for one in states)
        if same != self._judged[0]:  # else nothing has changed since the last view
            blind, unseen = _dark(self._arc_bins, states)
            both = blind | unseen << arcs.QUADRANTS
            self._judged = (same, (*_dark(self._bins, states), both))
        return self._judged[1]


@lru_cache(maxsize=8)
def _cells_round(
    corners: tuple[tuple[float, float], ...],
) -> tuple[FloatArray, FloatArray, ByteArray]:
    """The cells round an outline, their contacts by Sweeps, and the ways along arcs to them."""
    footprint = Footprint(corners, Margins(0.0, 0.0, 0.0))
    body = footprint.body
    low, high = body.min(axis=0) - _BORDER_M, body.max(axis=0) + _BORDER_M
    xs, ys = (np.arange(low[k], high[k], _CELL_M) for k in (0, 1))
    cells = np.stack(np.meshgrid(xs, ys), axis=2).reshape(-1, 2)
    cells = cells[~inside(body, cells)]
    contacts = Sweeps(footprint).contacts(cells)
    return cells, contacts, ArcReach(footprint, cells).ways(cells, contacts)


def _bins(swept_m: FloatArray, origins_m: Sequence[tuple[float, float]]) -> IntArray:
    bins = np.empty((len(swept_m), len(origins_m)), dtype=np.int64)
    for at, origin in enumerate(origins_m):
        bearings = np.arctan2(swept_m[:, 1] - origin[1], swept_m[:, 0] - origin[0])
        bins[:, at] = np.minimum(np.degrees(bearings) + 180.0, BINS - 1)
    return np.unique(bins, axis=0)


def _dark(sweeps: Sequence[IntArray], states: Sequence[States]) -> tuple[int, int]:
    blind = unseen = 0
    for sweep, bins in enumerate(sweeps):
        dark = np.ones(len(bins), dtype=np.bool_)
        lost = np.zeros(len(bins), dtype=np.bool_)
        for at, of_lidar in enumerate(states):
            here = of_lidar[bins[:, at]]
            dark &= here != SEEN
            lost |= here == BLIND
        blind |= bool((dark & lost).any()) << sweep
        unseen |= bool((dark & ~lost).any()) << sweep
    return blind, unseen


def _arc_column(quadrant: int, zone: StopZone) -> int:
    """The column of the least turn that covers the stop zone's, else of the widest."""
    turn_deg = zone.far[codes.DIR_LEFT + quadrant // 2]
    row = next((k for k, deg in enumerate(arcs.TURNS_DEG) if deg >= turn_deg), arcs.ROWS - 1)
    return quadrant * arcs.ROWS + row
