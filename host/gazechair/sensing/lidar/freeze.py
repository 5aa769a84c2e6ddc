"""Detects a lidar that repeats old data: true ranges are never the same twice.

It compares the sum of the distances in each degree, turn by turn. True ranges have a noise of some
millimetres, so few sums agree by chance; those of a frozen device all do.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.sensing.lidar.nodes import Nodes

_BINS = 360
_QUARTER = 90
_QUARTER_OF = (np.arange(_BINS) // _QUARTER).astype(np.uint8)
_SAME_SHARE = 0.9
_LEAST_BINS = 20  # degrees of a quarter that must have returns for a verdict
_QUARTERS = 2  # unchanged quarters in a row: frozen
_UNPROVEN_QUARTERS = 16  # quarters without a verdict: too little data, counts as proven


class FreezeWatch:
    """Feed it all nodes in order. `proven`: they change, or are too few; `frozen`: they do not."""

    def __init__(self) -> None:
        self.proven = False
        self.frozen = False
        self._before: FloatArray = np.full(_BINS, np.nan)
        self._sums: FloatArray = np.zeros(_BINS)
        self._quarter = -1
        self._same = 0
        self._unproven = 0

    def take(self, nodes: Nodes) -> None:
        """Process `nodes`, which follow the previous ones."""
        if not len(nodes):
            return
        bins = np.minimum((nodes.angles_deg + 180.0).astype(np.int64), _BINS - 1)
        quarters = _QUARTER_OF.take(bins)
        others = (quarters[1:] != quarters[:-1]).nonzero()[0] + 1
        for first, last in pairwise((0, *others.tolist(), len(bins))):
            if quarters[first] != self._quarter:
                self._finish()
                self._quarter = int(quarters[first])
            here = slice(first, last)
            self._sums += np.bincount(bins[here], nodes.distances_m[here], _BINS)

    def _finish(self) -> None:
        """A quarter turn is complete: compare it with the same quarter a turn before."""
        if self._quarter < 0:
            return
        # The degrees at its ends may be cut differently each time.
        inner = slice(self._quarter * _QUARTER + 1, (self._quarter + 1) * _QUARTER - 1)
        now, before = self._sums[inner], self._before[inner]
        some = (now > 0.0) & (before > 0.0)
        count = int(np.count_nonzero(some))
        if count >= _LEAST_BINS:
            same = np.count_nonzero(np.abs(now[some] - before[some]) < 1e-9) / count
            self._same = self._same + 1 if same >= _SAME_SHARE else 0
            self.proven |= self._same == 0
            self.frozen = self._same >= _QUARTERS
        else:
            self._unproven += 1
            self.proven |= self._unproven >= _UNPROVEN_QUARTERS
        whole = slice(self._quarter * _QUARTER, (self._quarter + 1) * _QUARTER)
        self._before[whole] = self._sums[whole]
        self._sums[:] = 0.0
