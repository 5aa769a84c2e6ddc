"""How the values of a figure spread: counted in steps, so that a record of many drives is short."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

_STEPS = 500
"""Farther off, a value counts as that; the largest one is kept as it is."""


@dataclass(frozen=True)
class Spread:
    """Absolute values, counted by the step that each lies in. JSON can represent it."""

    step: float
    """In the unit of the values."""
    counts: list[int]
    """How many values lie below the first step, the second, and so on."""
    most: float
    """The largest; inf counts in the last step."""

    @classmethod
    def of(cls, values: ArrayLike, step: float) -> Spread:
        """Count values."""
        found = np.abs(np.asarray(values, dtype=np.float64)).ravel()
        steps = np.minimum(found / step, _STEPS - 1).astype(np.int64)
        return cls(step, np.bincount(steps).tolist(), float(found.max(initial=0.0)))

    @property
    def count(self) -> int:
        """Number of values."""
        return sum(self.counts)

    def percentile(self, percent: float) -> float:
        """The upper end of the step within which so many percent lie: never too good."""
        if not self.count:
            return math.nan
        reached = np.cumsum(self.counts) >= percent / 100.0 * self.count
        ends = int(np.argmax(reached)) + 1
        return self.most if ends == _STEPS else min(self.most, self.step * ends)

    def share_below(self, limit: float) -> float:
        """The share of values below `limit`, which is a multiple of the step."""
        return sum(self.counts[: round(limit / self.step)]) / max(1, self.count)


def together(spreads: Iterable[Spread]) -> Spread:
    """Several, of one step, as one."""
    found = list(spreads)
    counts = np.zeros(max(len(one.counts) for one in found), dtype=np.int64)
    for one in found:
        counts[: len(one.counts)] += np.asarray(one.counts, dtype=np.int64)
    return Spread(found[0].step, counts.tolist(), max(one.most for one in found))
