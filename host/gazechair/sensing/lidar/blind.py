"""Is a direction without a return open space, or is the lidar blind there? Judged degree by degree.

The S2 answers "nothing" for open space beyond its range (30 m; 16 m in the standard scan) and for a
covered window alike. They differ in this:

- Open space lies between far things. A gap whose visible border is near is not open: the lidar is
  blind there (a cover, or something black or shining).
- Open space comes gradually, as the chair turns and moves. A wide arc that was seen and is gone a
  turn later was covered, whatever borders it; it stays blind until it returns something.
- Nothing is nearer than the lidar's own housing: returns below 5 cm come from its window.
- Without any return at all nothing is known: blind all round.

A gap of up to 8 degrees counts as seen: the window's optics are wider, no cover is so small.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gazechair.base.arrays import BoolArray, ByteArray, FloatArray, IntArray

BINS = 360
SEEN, BLIND, MASKED = 0, 1, 2

NEAREST_M = 0.05
FAR_M = 8.0
NARROW_DEG = 8
UNMEASURED_DEG = 3  # without any measurement (bytes were lost), a wider gap is blind
SUDDEN_DEG = 30
SUDDEN_S = 0.15
_MIN_SHARE = 0.25  # of a degree's measurements that must have a return
_BORDER = 3  # degrees of a gap's border that are examined


class Blindness:
    """Evaluates the views of one lidar in the order in which they arrive."""

    def __init__(self) -> None:
        self._had: BoolArray = np.zeros(BINS, dtype=np.bool_)  # had a return in the last view
        self._lost_s: FloatArray = np.full(BINS, -np.inf)
        self._covered: BoolArray = np.zeros(BINS, dtype=np.bool_)

    def judge(
        self,
        nothing: IntArray,
        at_window: IntArray,
        hits: IntArray,
        masked: BoolArray,
        at_s: float,
        nearest_m: Callable[[], FloatArray],
    ) -> ByteArray:
        """SEEN, BLIND or MASKED for each of the 360 bins.

        `nothing`, `at_window`, `hits`: per bin, the measurements outside the mask without return,
        nearer than NEAREST_M, and farther. `masked`: per bin. `nearest_m`: returns the nearest hit
        per bin, inf for none. `at_s`: the time of the view, seconds that never run backwards.
        """
        measured = nothing + at_window + hits
        has = (hits >= 1) & (hits >= _MIN_SHARE * measured) & (at_window <= hits)
        lacks = ~(has | masked)
        self._remember(has, lacks, at_s)
        blind = self._covered | (at_window > hits)
        wide = [run for run in runs(lacks) if run[1] > NARROW_DEG]
        if wide:
            by_bin_m = nearest_m()
            for first, count in wide:
                if not _between_far(first, count, has, masked, by_bin_m):
                    blind[(first + np.arange(count)) % BINS] = True
        for first, count in runs((measured == 0) & ~masked):
            if count > UNMEASURED_DEG:
                blind[(first + np.arange(count)) % BINS] = True
        states = blind * np.uint8(BLIND)  # SEEN is 0
        states[masked] = MASKED
        return states

    def _remember(self, has: BoolArray, lacks: BoolArray, at_s: float) -> None:
        self._lost_s[self._had & ~has] = at_s
        self._had = has
        self._covered &= ~has
        fresh = lacks & (at_s - self._lost_s <= SUDDEN_S)
        for first, count in runs(fresh):
            if count >= SUDDEN_DEG:
                self._covered[(first + np.arange(count)) % BINS] = True


def _between_far(
    first: int, count: int, has: BoolArray, masked: BoolArray, nearest_m: FloatArray
) -> bool:
    """True when every visible border of the gap is far, and there is one."""
    borders = 0
    for start in (first - _BORDER, first + count):
        border = (start + np.arange(_BORDER)) % BINS
        border = border[has[border] & ~masked[border]]
        if len(border):
            borders += 1
            if nearest_m[border].min() < FAR_M:
                return False
    return borders > 0


def runs(flags: BoolArray) -> list[tuple[int, int]]:
    """Runs of True round the circle, as (first bin, count)."""
    count = int(np.count_nonzero(flags))
    if not count:
        return []
    if count == len(flags):
        return [(0, count)]
    start = int(flags.argmin())
    turned = np.roll(flags, -start)
    edges = np.diff(np.concatenate(([False], turned, [False])).astype(np.int8))
    firsts = np.flatnonzero(edges == 1)
    counts = np.flatnonzero(edges == -1) - firsts
    return [((int(f) + start) % len(flags), int(c)) for f, c in zip(firsts, counts, strict=True)]
