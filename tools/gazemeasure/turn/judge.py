"""Rates a recorded turn: settling time, overshoot, oscillating, unstable, final error.

Settled: from then on within 1 degree of the setpoint and slower than 1 degree/s for 1 s.
Oscillates: after it first came within 1 degree, the heading left that band on alternating sides
more than twice, or the wiper changed sides more than twice (the counter-deflection that ends a
corrective move belongs to that move and does not count).
Unstable: it oscillates and the last of those swings is no smaller than the first, or the heading
diverged: further from the setpoint than 1.5 x the step and the largest effect of the casters.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gazeboard.core.limits import WIPER_NEUTRAL
from gazechair.base.arrays import FloatArray

WITHIN_DEG = 1.0
UNDER_DPS = 1.0
FOR_MS = 1000
_SWINGS = 2
_CASTERS_DEG = 15.0


DEFINITIONS = (
    "settled: within 1 deg of the setpoint and under 1 deg/s for 1 s (true heading); the time is",
    "  that second's beginning, from the press.",
    "oscillates: after first coming within 1 deg, the heading leaves that band on alternating",
    "  sides more than twice, or the wiper changes sides more than twice (the counter-deflection",
    "  that stops a corrective move belongs to it and does not count).",
    "unstable: oscillates, its last swing no smaller than its first; or was ever further off than",
    "  1.5 x the step and 15 deg, the most that casters do.",
)


@dataclass(frozen=True)
class Turn:
    """One turn as recorded each millisecond from the press on; angle left positive."""

    angle_deg: float
    heading_deg: FloatArray
    """True heading, 0 at the press."""
    rate_dps: FloatArray
    count: NDArray[np.int16]
    """The turn wiper."""


@dataclass(frozen=True)
class Verdict:
    """See the module's docstring; times in s, NaN when it never settled."""

    settled_s: float
    overshoot_deg: float
    end_error_deg: float
    oscillates: bool
    unstable: bool
    stands: bool
    """True if at the end it is neutral, and under 1 degree/s."""
    left_again: bool
    """True if it left the band after it had settled."""
    counts: tuple[int, int]
    """Lowest and highest count of the turn wiper."""


def judge(turn: Turn) -> Verdict:
    """Judge a turn. The recording should continue for at least 1 s after the motion's end."""
    sign = 1.0 if turn.angle_deg > 0 else -1.0
    error = (turn.heading_deg - turn.angle_deg) * sign  # positive: too far
    at = _settled_at(error, turn.rate_dps)
    outside = np.abs(error) > WITHIN_DEG
    swings = _swings(error)
    flips = _flips(error, turn.count)
    oscillates = len(swings) > _SWINGS or flips > _SWINGS
    growing = len(swings) > _SWINGS and swings[-1] >= swings[0]
    step = abs(turn.angle_deg)
    return Verdict(
        settled_s=float("nan") if at is None else at / 1000,
        overshoot_deg=max(0.0, float(error.max())),
        end_error_deg=float(abs(error[-1])),
        oscillates=bool(oscillates),
        unstable=bool(growing) or float(np.abs(error).max()) > 1.5 * step + _CASTERS_DEG,
        stands=bool(turn.count[-1] == WIPER_NEUTRAL and abs(turn.rate_dps[-1]) < UNDER_DPS),
        left_again=bool(at is not None and outside[at:].any()),
        counts=(int(turn.count.min()), int(turn.count.max())),
    )


def _settled_at(error_deg: FloatArray, rate_dps: FloatArray) -> int | None:
    """Index (ms) of the first second that keeps to the definition; None when there is none."""
    good = (np.abs(error_deg) <= WITHIN_DEG) & (np.abs(rate_dps) < UNDER_DPS)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], good.astype(np.int8), [0]))))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        if end - start >= FOR_MS:
            return int(start)
    return None


def _swings(error: FloatArray) -> list[float]:
    """Peaks outside the band after first entering it, one per change of side."""
    inside = np.flatnonzero(np.abs(error) <= WITHIN_DEG)
    if len(inside) == 0:
        return []
    after = error[inside[0] :]
    peaks: list[float] = []
    last = 0.0
    sides = np.where(after > WITHIN_DEG, 1, np.where(after < -WITHIN_DEG, -1, 0))
    edges = np.flatnonzero(np.diff(np.concatenate(([0], sides, [0]))))
    for start, end in pairwise(edges):
        side = sides[start]
        if side == 0:
            continue
        peak = float(np.abs(after[start:end]).max())
        if side == last:
            peaks[-1] = max(peaks[-1], peak)
        else:
            peaks.append(peak)
        last = side
    return peaks


def _flips(error: FloatArray, count: NDArray[np.int16]) -> int:
    """How often the wiper changed sides after the heading first entered the band; the single
    counter-deflection that stops a later move is part of that move and not counted."""
    inside = np.flatnonzero(np.abs(error) <= WITHIN_DEG)
    if len(inside) == 0:
        return 0
    sides = np.sign(count[inside[0] :].astype(np.int32) - WIPER_NEUTRAL)
    starts = np.flatnonzero(np.diff(sides, prepend=0) != 0)
    flips, last, free, begun = 0, 0, False, 0
    for side in sides[starts]:
        if side == 0:
            last = 0
            continue
        if last == 0:  # a move begins
            flips += bool(begun) and int(side) != begun
            begun, free = int(side), bool(begun) or sides[0] == 0
        elif free:
            free = False
        else:
            flips += 1
        last = int(side)
    return flips
