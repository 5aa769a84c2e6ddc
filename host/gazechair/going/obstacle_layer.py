"""Overlays obstacles that are not in the map on the costmap, and tracks people who walk."""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.footprint import Footprint
from gazechair.base.poses import to_frame
from gazechair.going.costmap import Costmap
from gazechair.going.maybe_persons import maybe_persons_m
from gazechair.going.outline import own_place
from gazechair.going.people import People
from gazechair.going.plan import Pose

_WALKER_M = 0.45
"""All returns within this distance of a walking person count as theirs."""


class ObstacleLayer:
    """What one chair sees around it, in one map."""

    def __init__(self, costmap: Costmap, footprint: Footprint) -> None:
        self._costmap, self._own_place = costmap, own_place(footprint)
        self.people = People()
        self._points_m = self._origins_m = np.zeros((0, 2))
        self._pose = np.zeros(3)

    def scan(self, points_m: FloatArray, origins_m: FloatArray, at_s: float, pose: Pose) -> None:
        """Take in one lidar rotation, of a chair whose pose is known; see Mission.scan."""
        others = ~self._own_place.contains(points_m)
        self._points_m, self._origins_m = points_m[others], origins_m[others]
        self._pose = np.array(pose)
        in_map = to_frame(self._points_m, self._pose)
        self._costmap.clear(in_map, to_frame(self._origins_m, self._pose), at_s)
        new = self._costmap.see(in_map, at_s, (pose[0], pose[1]))
        self.people.look(new, at_s)
        for x, y in self._walkers_m():  # plans ignore walkers: they will be elsewhere
            self._costmap.forget(x, y, _WALKER_M)

    def suspect(self) -> None:
        """Make it costly to head for what may be a standing person now; walkers are left out."""
        found = to_frame(maybe_persons_m(self._points_m, self._origins_m), self._pose)
        for x, y in self._walkers_m():
            found = found[np.hypot(found[:, 0] - x, found[:, 1] - y) > _WALKER_M]
        self._costmap.suspect(found)

    def walker_within(self, x_m: float, y_m: float, within_m: float) -> bool:
        """Whether somebody walks within a distance of a point."""
        return any(math.dist(one, (x_m, y_m)) < within_m for one in self._walkers_m())

    def _walkers_m(self) -> list[tuple[float, float]]:
        return [(one.x_m, one.y_m) for one in self.people.tracks if one.walks]
