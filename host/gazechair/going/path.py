"""A path: straight legs, with a bend or a turn on the spot at each vertex; or why there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.going.bends import Bend
from gazechair.going.smooth import PASSES_M, Pose

NO_LEG_M = 0.03
"""A shorter leg is not driven."""
NO_AIM_M = 0.05
"""Nearer to its leg's end, the chair no longer turns towards that."""
_EASY_S, _EASY_S_PER_M = 20.0, 7.0
_LOOK_M = 1.0
_ALONG_M = 0.4  # nearer to its leg's end, only the leg's direction counts


@dataclass(frozen=True)
class Path:
    """Vertices (N, 2) from the chair to the goal, and the heading to end with (None: any)."""

    points_m: FloatArray
    heading_rad: float | None
    backward: bool = False
    """The first leg is driven backward."""
    clearance_m: float = 0.0
    cost_s: float = 0.0
    """Estimated, for choosing between paths."""
    bends: tuple[Bend | None, ...] = ()
    """The bend at each vertex; None: a turn on the spot."""
    began_rad: float | None = None
    """Where a bend leads a rolling chair into a path: the heading at which that path began."""

    @property
    def is_easy(self) -> bool:
        """Whether a search for a better path is hardly worthwhile."""
        easy_s = _EASY_S + _EASY_S_PER_M * self.length_m
        return self.clearance_m >= PASSES_M and self.cost_s < easy_s

    def bend(self, vertex: int) -> Bend | None:
        """The arc in place of a vertex; None: a turn on the spot."""
        return self.bends[vertex] if vertex < len(self.bends) else None

    def aim_rad(self, leg: int, pose: Pose) -> float | None:
        """Heading to turn to before a leg, towards a point ahead on it; None: no turn is needed."""
        a, b = self.points_m[leg : leg + 2]
        if float(np.hypot(*(b - a))) < NO_LEG_M:
            return None
        along_m, _across, length = on_leg(a, b, pose)
        if length - along_m < NO_AIM_M:
            return None
        aim = a + (b - a) * (min(length, along_m + max(_LOOK_M, 0.5 * length)) / length)
        heading = math.atan2(aim[1] - pose[1], aim[0] - pose[0])
        if length - along_m < _ALONG_M:
            heading = math.atan2(b[1] - a[1], b[0] - a[0])
        return heading + math.pi if self.backward and not leg else heading

    def begun_at(self, vertex: int, pose: Pose) -> Path:
        """The same path with its leg from `vertex` beginning at `pose`; the goal stays."""
        if vertex >= len(self.points_m) - 1:
            return self
        points = self.points_m.copy()
        points[vertex] = pose[:2]
        beside = vertex, vertex + 1
        bends = tuple(None if k in beside else bend for k, bend in enumerate(self.bends))
        return replace(self, points_m=points, bends=bends)

    @property
    def length_m(self) -> float:
        """Length of all legs."""
        return float(np.hypot(*np.diff(self.points_m, axis=0).T).sum())


class Abandoned(Exception):
    """Raised within the planner once nobody waits for its path any more."""


@dataclass(frozen=True)
class NoPath:
    """There is no path; `reason` is a key of the string tables."""

    reason: str


def on_leg(a: FloatArray, b: FloatArray, pose: Pose) -> tuple[float, float, float]:
    """Along, across (left of the leg positive) and its length."""
    dx, dy = float(b[0] - a[0]), float(b[1] - a[1])
    length = math.hypot(dx, dy)
    if length < 1e-9:
        return 0.0, 0.0, 0.0
    ux, uy = dx / length, dy / length
    px, py = pose[0] - float(a[0]), pose[1] - float(a[1])
    return ux * px + uy * py, ux * py - uy * px, length
