"""Routes of the chair's whole footprint through a home: a search over place and heading.

A lattice of 10 cm and 16 headings, whose steps lie on it exactly; a pose is free when the
footprint, 6 cm wider all round, holds nothing. Forward along the heading, or a turn on the spot.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gazechair.base.angles import half_turn_deg
from gazechair.base.arrays import Float32Array, FloatArray, IntArray
from gazesim import chair
from gazesim.homes import Home

FINE_M = 0.025
_EVERY = 4  # fine cells a step of the lattice
_SPARE_M = 0.06
_STEPS = (
    (1, 0), (2, 1), (1, 1), (1, 2), (0, 1), (-1, 2), (-1, 1), (-2, 1),
    (-1, 0), (-2, -1), (-1, -1), (-1, -2), (0, -1), (1, -2), (1, -1), (2, -1),
)  # fmt: skip
HEADINGS_DEG = tuple(math.degrees(math.atan2(dy, dx)) for dx, dy in _STEPS)
_ROUND_DEG = (*HEADINGS_DEG, HEADINGS_DEG[0])
_COSTS = tuple(round(5.0 * math.hypot(dx, dy)) for dx, dy in _STEPS)
_STEP_OF = np.array(_STEPS)
_COST_OF = np.array(_COSTS)
_TURN_COST = 12
_UNREACHED = np.iinfo(np.int32).max

Free = NDArray[np.bool_]
Costs = NDArray[np.int32]


@dataclass(frozen=True)
class Pose:
    """Of the drive axle."""

    x_m: float
    y_m: float
    heading_deg: float


class Router:
    """The free poses of a home as it stands now."""

    def __init__(self, home: Home) -> None:
        points = _samples(home.body_segments())
        low = points.min(axis=0) - 0.1
        size = np.ceil((points.max(axis=0) + 0.1 - low) / FINE_M).astype(int)
        self._low = low
        taken = np.zeros(tuple(size), dtype=np.float32)
        cells = ((points - low) / FINE_M).astype(int)
        taken[cells[:, 0], cells[:, 1]] = 1.0
        self._fine = _free(taken, HEADINGS_DEG)
        self._free: Free = self._fine[:, ::_EVERY, ::_EVERY]
        halfway = [deg + 0.5 * half_turn_deg(after - deg) for deg, after in pairwise(_ROUND_DEG)]
        # Layer k: halfway between the headings k and k + 1.
        self._turns = _free(taken, halfway)[:, ::_EVERY, ::_EVERY].reshape(-1)
        self._shape = self._free.shape[1:]

    def costs_to(self, x_m: float, y_m: float) -> Costs:
        """What it costs from each pose to the free place nearest to (x, y), at any heading."""
        free = self._free
        costs = np.full(free.size, _UNREACHED, dtype=np.int32)
        goal = self._nearest(x_m, y_m)
        if goal is None:
            return costs.reshape(free.shape)
        headings = np.flatnonzero(free[:, goal[0], goal[1]])
        first = (headings * self._shape[0] + goal[0]) * self._shape[1] + goal[1]
        buckets: dict[int, list[IntArray]] = {0: [first]}
        while buckets:
            cost = min(buckets)
            poses = np.unique(np.concatenate(buckets.pop(cost)))
            poses = poses[costs[poses] > cost]
            costs[poses] = cost
            for price, found in self._before(poses):
                found = found[costs[found] > cost + price]
                if len(found):
                    buckets.setdefault(cost + price, []).append(found)
        return costs.reshape(free.shape)

    def _before(self, poses: IntArray) -> list[tuple[int, IntArray]]:
        """Poses from which one move leads to `poses`, by its cost. The border is never free."""
        flat = self._free.reshape(-1)
        layer = self._shape[0] * self._shape[1]
        heading = poses // layer
        found = []
        for side in (1, -1):
            turned = poses + ((heading + side) % len(_STEPS) - heading) * layer
            between = poses if side > 0 else turned
            found.append((_TURN_COST, turned[flat[turned] & self._turns[between]]))
        for cost in set(_COSTS):
            of = np.flatnonzero(_COST_OF[heading] == cost)
            before = poses[of] - _STEP_OF[heading[of]] @ (self._shape[1], 1)
            place = before % layer
            between = np.stack(np.divmod(place, self._shape[1]), axis=1) * _EVERY
            between += _STEP_OF[heading[of]] * _EVERY // 2
            good = flat[before] & self._fine[heading[of], between[:, 0], between[:, 1]]
            found.append((cost, before[good]))
        return found

    def _nearest(self, x_m: float, y_m: float) -> tuple[int, int] | None:
        """The lattice place nearest to it where the chair can turn all round, within 1.5 m."""
        around = self._free.all(axis=0)
        xs, ys = np.nonzero(around)
        if not len(xs):
            return None
        step = FINE_M * _EVERY
        far = np.hypot(self._low[0] + xs * step - x_m, self._low[1] + ys * step - y_m)
        best = int(far.argmin())
        return (int(xs[best]), int(ys[best])) if far[best] < 1.5 else None

    def place(self, x_m: float, y_m: float) -> tuple[float, float] | None:
        """The place nearest to it where the chair can turn all round; None: not within 1.5 m."""
        found = self._nearest(x_m, y_m)
        return None if found is None else self._metres(found)

    def reaches(self, costs: Costs, x_m: float, y_m: float) -> bool:
        """Whether the place nearest to (x, y) leads there."""
        found = self._nearest(x_m, y_m)
        return found is not None and bool((costs[:, found[0], found[1]] < _UNREACHED).all())

    def route(self, costs: Costs, start: Pose) -> list[Pose]:
        """From the free pose nearest to `start` to where `costs` leads; [] when there is none."""
        step = FINE_M * _EVERY
        heading = int(np.argmin([abs(half_turn_deg(d - start.heading_deg)) for d in HEADINGS_DEG]))
        x = round((start.x_m - self._low[0]) / step)
        y = round((start.y_m - self._low[1]) / step)
        at = min(
            (
                (k % len(_STEPS), i, j)
                for k in range(heading - 2, heading + 3)
                for i in range(max(x - 2, 0), min(x + 3, self._shape[0]))
                for j in range(max(y - 2, 0), min(y + 3, self._shape[1]))
                if costs[k % len(_STEPS), i, j] < _UNREACHED
            ),
            key=lambda pose: self._apart(pose, start),
            default=None,
        )
        if at is None:
            return []
        found = [at]
        while costs[at] > 0:
            at = min(self._after(at), key=lambda pose: float(costs[pose]))
            found.append(at)
        return [Pose(*self._metres((i, j)), HEADINGS_DEG[k]) for k, i, j in found]

    def _apart(self, at: tuple[int, int, int], pose: Pose) -> float:
        """How far from it; half a metre for 90 degrees."""
        x_m, y_m = self._metres(at[1:])
        turned = abs(half_turn_deg(HEADINGS_DEG[at[0]] - pose.heading_deg))
        return math.hypot(x_m - pose.x_m, y_m - pose.y_m) + turned / 180.0

    def _after(self, at: tuple[int, int, int]) -> list[tuple[int, int, int]]:
        heading, x, y = at
        dx, dy = _STEPS[heading]
        turns = self._turns.reshape(self._free.shape)
        found = []
        for side in (1, -1):
            after = (heading + side) % len(_STEPS), x, y
            if turns[heading if side > 0 else after[0], x, y]:
                found.append(after)
        between = x * _EVERY + dx * _EVERY // 2, y * _EVERY + dy * _EVERY // 2
        if self._fine[heading, between[0], between[1]]:
            found.append((heading, x + dx, y + dy))
        return found

    def _metres(self, place: tuple[int, int]) -> tuple[float, float]:
        step = FINE_M * _EVERY
        return float(self._low[0] + place[0] * step), float(self._low[1] + place[1] * step)


def unreached(home: Home) -> set[str]:
    """The names of places that the chair cannot get to from the first one, or not turn in."""
    router = Router(home)
    names = list(home.places)
    costs = router.costs_to(*home.places[names[-1]])
    return {name for name in names if not router.reaches(costs, *home.places[name])}


def _samples(segments: FloatArray) -> FloatArray:
    """Points along the segments, closer than the fine cells."""
    length = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    count = np.ceil(length / (0.8 * FINE_M)).astype(int) + 1
    which = np.repeat(np.arange(len(segments)), count)
    share = (np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)) / np.repeat(
        np.maximum(count - 1, 1), count
    )
    begin, end = segments[which, :2], segments[which, 2:]
    return np.asarray(begin + share[:, None] * (end - begin))


def _free(taken: Float32Array, headings_deg: Sequence[float]) -> Free:
    """For each heading and fine cell, whether the footprint there holds nothing."""
    pad = math.ceil(2.0 * (chair.FRONT_M + 0.2) / FINE_M)
    shape = tuple(_smooth(n + pad) for n in taken.shape)
    spectrum = np.fft.rfft2(taken, shape)
    found = np.empty((len(headings_deg), *taken.shape), dtype=np.bool_)
    reach = math.ceil((math.hypot(chair.FRONT_M, chair.HALF_WIDTH_M) + 0.1) / FINE_M)
    cells = np.arange(-reach, reach + 1) * FINE_M
    xs, ys = np.meshgrid(cells, cells, indexing="ij")
    for k, heading_deg in enumerate(headings_deg):
        c, s = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
        ahead, left = c * xs + s * ys, c * ys - s * xs
        inside = (ahead <= chair.FRONT_M + _SPARE_M) & (ahead >= chair.REAR_M - _SPARE_M)
        inside &= np.abs(left) <= chair.HALF_WIDTH_M + _SPARE_M
        mask = np.zeros(shape, dtype=np.float32)
        i, j = np.nonzero(inside)
        mask[i - reach, j - reach] = 1.0  # negative indices wrap, as the transform does
        hits = np.fft.irfft2(spectrum * np.conj(np.fft.rfft2(mask)), shape)
        found[k] = hits[: taken.shape[0], : taken.shape[1]] < 0.5
    edge = reach
    found[:, :edge], found[:, -edge:] = False, False
    found[:, :, :edge], found[:, :, -edge:] = False, False
    return found


def _smooth(least: int) -> int:
    """The next size that a Fourier transform is quick with."""
    size = least
    while True:
        left = size
        for prime in (2, 3, 5):
            while left % prime == 0:
                left //= prime
        if left == 1:
            return size
        size += 1
