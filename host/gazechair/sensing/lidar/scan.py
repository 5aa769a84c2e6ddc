"""A scan, where its lidar sits on the chair, and what the view in each direction is worth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gazechair.base.angles import in_turn
from gazechair.sensing.lidar.blind import BINS, BLIND, MASKED, NEAREST_M, SEEN, Blindness
from gazechair.sensing.lidar.nodes import FloatArray

Arc = tuple[float, float]

__all__ = ["BINS", "BLIND", "MASKED", "SEEN", "Arc", "ChairView", "Pose", "Scan", "to_chair"]


@dataclass(frozen=True)
class Scan:
    """The newest measurements all round of one lidar.

    `angles_deg`: the lidar's frame, 0 = its forward, left positive, -180 <= angle < 180.
    `distances_m`: from its centre, 0 = no return. `acquired_s`: CLOCK_MONOTONIC seconds of the
    *oldest* measurement in it, so its age is never understated. `source`: codes.REAL, SIMULATED or
    REPLAYED.
    """

    angles_deg: FloatArray
    distances_m: FloatArray
    acquired_s: float
    source: int

    def __len__(self) -> int:
        return len(self.angles_deg)


@dataclass(frozen=True)
class Pose:
    """Where a lidar sits in the chair's frame: drive axle at the origin, x forward, y left.

    `heading_deg`: where its forward looks, counter-clockwise. `upside_down`: it hangs from its
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
    the scan.
    `states`: (360,), SEEN, BLIND or MASKED; bin i is the directions i - 180 .. i - 179 degrees of
    the chair's frame, as rays from `origin_m`. `acquired_s`, `source`: as of the scan.
    """

    points_m: FloatArray
    states: NDArray[np.uint8]
    origin_m: tuple[float, float]
    acquired_s: float
    source: int


def to_chair(
    scan: Scan, pose: Pose, mask: Sequence[Arc] = (), blindness: Blindness | None = None
) -> ChairView:
    """`scan` in the chair's frame; nothing within `mask` is a point.

    `mask`: arcs [from, to] of the lidar's own frame, counter-clockwise, in which it sees the chair
    itself or nothing ever. `blindness` remembers what was seen before, one for each lidar; without
    it a view that was covered between two far surfaces counts as open (see blind.py).
    """
    directions_deg = pose.directions_deg(scan.angles_deg)
    bins = np.minimum((directions_deg + 180.0).astype(np.int64), BINS - 1)
    masked_bins = _masked_bins(pose, tuple((first, last) for first, last in mask))
    open_ = (~in_arcs(scan.angles_deg, mask)).nonzero()[0]
    bins, distances_m = bins.take(open_), scan.distances_m.take(open_)
    states = (blindness or Blindness()).judge(bins, distances_m, masked_bins, scan.acquired_s)
    returned = (distances_m >= NEAREST_M).nonzero()[0]
    radians = np.radians(directions_deg.take(open_.take(returned)))
    distances_m = distances_m.take(returned)
    points = np.empty((len(radians), 2))
    points[:, 0] = pose.x_m + distances_m * np.cos(radians)
    points[:, 1] = pose.y_m + distances_m * np.sin(radians)
    return ChairView(points, states, (pose.x_m, pose.y_m), scan.acquired_s, scan.source)


def in_arcs(angles_deg: FloatArray, arcs: Sequence[Arc]) -> NDArray[np.bool_]:
    """True where an angle is in one of `arcs`, ends included."""
    inside = np.zeros(len(angles_deg), dtype=np.bool_)
    for from_deg, to_deg in arcs:
        inside |= in_turn(angles_deg - from_deg, 360.0) <= (to_deg - from_deg) % 360.0
    return inside


@lru_cache(maxsize=16)
def _masked_bins(pose: Pose, mask: tuple[Arc, ...]) -> NDArray[np.bool_]:
    # A bin is masked when any part of it is: what is left of it is too little to judge by.
    masked = np.zeros(BINS, dtype=np.bool_)
    for from_deg, to_deg in mask:
        width_deg = (to_deg - from_deg) % 360.0
        ends = pose.directions_deg(np.array([from_deg, to_deg]))
        first = math.floor(float(ends[1 if pose.upside_down else 0]) + 180.0)
        offset = float(ends[1 if pose.upside_down else 0]) + 180.0 - first
        masked[(first + np.arange(math.ceil(width_deg + offset))) % BINS] = True
    masked.flags.writeable = False
    return masked
