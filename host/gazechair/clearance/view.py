"""Which part of each motion's sweep is looked at by any lidar: seen, gone blind, or never seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gazechair.clearance.footprint import Footprint, Margins, inside
from gazechair.clearance.sweeps import Sweeps
from gazechair.clearance.zone import STOP_ZONE
from gazechair.lidar.blind import BINS, BLIND, SEEN
from gazelink import codes

_CELL_M = 0.03
_BORDER_M = 0.8  # the straight sweeps end this far before and behind the outline

States = NDArray[np.uint8]


class SweepView:
    """The sweeps of one footprint, within the stop zone, as the lidars at `origins_m` see them."""

    def __init__(self, footprint: Footprint, origins_m: Sequence[tuple[float, float]]) -> None:
        body = footprint.body
        low, high = body.min(axis=0) - _BORDER_M, body.max(axis=0) + _BORDER_M
        xs, ys = (np.arange(low[k], high[k], _CELL_M) for k in (0, 1))
        cells = np.stack(np.meshgrid(xs, ys), axis=2).reshape(-1, 2)
        cells = cells[~inside(body, cells)]
        contacts = Sweeps(Footprint(body.tolist(), Margins(0.0, 0.0, 0.0))).contacts(cells)
        # Per direction, the bins in which each cell is seen, a column for each lidar, no row twice.
        self._bins: list[NDArray[np.int64]] = []
        for direction in range(len(codes.DIRECTIONS)):
            swept = cells[contacts[:, direction] <= STOP_ZONE[direction]]
            bins = np.empty((len(swept), len(origins_m)), dtype=np.int64)
            for at, origin in enumerate(origins_m):
                bearings = np.arctan2(swept[:, 1] - origin[1], swept[:, 0] - origin[0])
                bins[:, at] = np.minimum(np.degrees(bearings) + 180.0, BINS - 1)
            self._bins.append(np.unique(bins, axis=0))

    def judge(self, states: Sequence[States]) -> tuple[int, int]:
        """(blind, unseen): a bit per direction, from each lidar's 360 states (SEEN, BLIND, MASKED).

        A place that any lidar sees is seen. Blind: the sweep enters a place that would be seen if a
        lidar were not blind there. Unseen: it enters a place that no lidar ever sees.
        """
        blind = unseen = 0
        for direction, bins in enumerate(self._bins):
            dark = np.ones(len(bins), dtype=np.bool_)
            lost = np.zeros(len(bins), dtype=np.bool_)
            for at, of_lidar in enumerate(states):
                here = of_lidar[bins[:, at]]
                dark &= here != SEEN
                lost |= here == BLIND
            blind |= bool((dark & lost).any()) << direction
            unseen |= bool((dark & ~lost).any()) << direction
        return blind, unseen
