"""A scan, its lidar's pose on the chair, and the state of the view in each direction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gazechair.base.angles import in_turn
from gazechair.base.arrays import BoolArray, ByteArray, FloatArray
from gazechair.sensing.lidar.blind import BINS, BLIND, MASKED, NEAREST_M, SEEN, Blindness

Arc = tuple[float, float]

__all__ = [
    "BINS",
    "BLIND",
    "MASKED",
    "PLACED_ROWS",
    "SEEN",
    "Arc",
    "ChairView",
    "Placing",
    "Pose",
    "Scan",
    "to_chair",
    "view_of",
]

# Rows of a Placing's result. A code is BINS * kind of measurement + bin of the chair's frame.
PLACED_ROWS = 5
_CODE, _X, _Y, _BEARING, _RANGE = range(PLACED_ROWS)
_KINDS = 4
_IN_MASK, _NOTHING, _AT_WINDOW, _RETURNED = range(_KINDS)


@dataclass(frozen=True)
class Scan:
    """One lidar's newest measurements, in all directions.

    `angles_deg`: the lidar's frame, 0 = its forward, left positive, -180 <= angle < 180.
    `distances_m`: from its centre, 0 = no return. `acquired_s`: CLOCK_MONOTONIC seconds of the
    *oldest* measurement in it, so its age is never understated. `source`: codes.REAL, SIMULATED or
    REPLAYED. `placed`: the result of `placing` for its measurements, if there is one.
    """

    angles_deg: FloatArray
    distances_m: FloatArray
    acquired_s: float
    source: int
    placed: FloatArray | None = None
    placing: Placing | None = None

    def __len__(self) -> int:
        return len(self.angles_deg)


@dataclass(frozen=True)
class Pose:
    """Where a lidar sits in the chair's frame: drive axle at the origin, x forward, y left.

    `heading_deg`: direction of its forward, counter-clockwise. `upside_down`: it hangs from its
    base, so that its left is the chair's right.
    """

    x_m: float = 0.0
    y_m: float = 0.0
    heading_deg: float = 0.0
    upside_down: bool = False

    def directions_deg(self, angles_deg: FloatArray) -> FloatArray:
        """The lidar's angles as directions in the chair's frame, -180 <= direction < 180."""
        turned = -angles_deg if self.upside_down else angles_deg
        return in_turn(turned + self.heading_deg + 180.0, 360.0) - 180.0


@dataclass(frozen=True)
class ChairView:
    """What one lidar sees, in the chair's frame.

    `points_m`: (N, 2), x and y of every return outside the mask from 5 cm on, in the order of
    the scan. `polar`: their bearings (radians) and ranges about `origin_m`, as (2, N).
    `states`: (360,), SEEN, BLIND or MASKED; bin i is the directions i - 180 .. i - 179 degrees of
    the chair's frame, as rays from `origin_m`. `acquired_s`, `source`: as of the scan.
    """

    points_m: FloatArray
    states: ByteArray
    origin_m: tuple[float, float]
    acquired_s: float
    source: int
    polar: FloatArray | None = None


class Placing:
    """Transforms the measurements of one lidar to the chair's frame, each only once."""

    def __init__(self, pose: Pose, mask: Sequence[Arc] = ()) -> None:
        """`mask`: arcs [from, to] of the lidar's own frame, counter-clockwise, in which it sees the
        chair itself, or never sees anything."""
        self.pose = pose
        self._mask = tuple((first, last) for first, last in mask)
        self.masked_bins = _masked_bins(pose, self._mask)

    def __call__(
        self, angles_deg: FloatArray, distances_m: FloatArray, found: FloatArray | None = None
    ) -> FloatArray:
        """(5, N): code, x, y, bearing and range of each; x, y and bearing only for returns.

        `found` takes the result.
        """
        pose = self.pose
        if found is None:
            found = np.empty((PLACED_ROWS, len(angles_deg)))
        directions_deg = pose.directions_deg(angles_deg)
        bins = np.minimum((directions_deg + 180.0).astype(np.int64), BINS - 1)
        kinds = (distances_m > 0.0).astype(np.int64)
        kinds += distances_m >= NEAREST_M
        kinds += _NOTHING
        if self._mask:
            kinds *= ~in_arcs(angles_deg, self._mask)  # _IN_MASK is 0
        kinds *= BINS
        np.add(kinds, bins, out=found[_CODE], casting="unsafe")
        x, y, bearings = found[_X], found[_Y], found[_BEARING]
        np.radians(directions_deg, out=bearings)
        np.multiply(np.cos(bearings, out=x), distances_m, out=x)
        np.multiply(np.sin(bearings, out=y), distances_m, out=y)
        x += pose.x_m
        y += pose.y_m
        found[_RANGE] = distances_m
        return found


def to_chair(
    scan: Scan, pose: Pose, mask: Sequence[Arc] = (), blindness: Blindness | None = None
) -> ChairView:
    """`scan` in the chair's frame, without points within `mask`.

    `mask`: arcs [from, to] of the lidar's own frame, counter-clockwise, in which it sees the chair
    itself, or never sees anything. `blindness` remembers the views before, one for each lidar;
    without it a view that was covered between two far surfaces counts as open (see blind.py).
    """
    return view_of(scan, Placing(pose, mask), blindness)


def view_of(scan: Scan, placing: Placing, blindness: Blindness | None = None) -> ChairView:
    """As to_chair, by a `placing`, whose result is reused if the scan already has it."""
    placed = scan.placed if scan.placing is placing else None
    if placed is None:
        placed = placing(scan.angles_deg, scan.distances_m)
    codes = placed[_CODE].astype(np.int64)
    counts = np.bincount(codes, minlength=_KINDS * BINS).reshape(_KINDS, BINS)
    chosen = (codes >= _RETURNED * BINS).nonzero()[0]

    def nearest_m() -> FloatArray:
        found = np.full(BINS, np.inf)
        bins = codes.take(chosen) - _RETURNED * BINS
        np.minimum.at(found, bins, scan.distances_m.take(chosen))
        return found

    states = (blindness or Blindness()).judge(
        counts[_NOTHING],
        counts[_AT_WINDOW],
        counts[_RETURNED],
        placing.masked_bins,
        scan.acquired_s,
        nearest_m,
    )
    returned = placed[_X:].take(chosen, axis=1)
    points, polar = returned[: _BEARING - _X].T, returned[_BEARING - _X :]
    origin_m = (placing.pose.x_m, placing.pose.y_m)
    return ChairView(points, states, origin_m, scan.acquired_s, scan.source, polar)


def in_arcs(angles_deg: FloatArray, arcs: Sequence[Arc]) -> BoolArray:
    """True where an angle is in one of `arcs`, ends included."""
    inside = np.zeros(len(angles_deg), dtype=np.bool_)
    for from_deg, to_deg in arcs:
        inside |= in_turn(angles_deg - from_deg, 360.0) <= (to_deg - from_deg) % 360.0
    return inside


@lru_cache(maxsize=16)
def _masked_bins(pose: Pose, mask: tuple[Arc, ...]) -> BoolArray:
    # A bin is masked when any part of it is: the rest is too little to judge.
    masked = np.zeros(BINS, dtype=np.bool_)
    for from_deg, to_deg in mask:
        width_deg = (to_deg - from_deg) % 360.0
        ends = pose.directions_deg(np.array([from_deg, to_deg]))
        first = math.floor(float(ends[1 if pose.upside_down else 0]) + 180.0)
        offset = float(ends[1 if pose.upside_down else 0]) + 180.0 - first
        masked[(first + np.arange(math.ceil(width_deg + offset))) % BINS] = True
    masked.flags.writeable = False
    return masked
