"""A path: straight legs, with a bend or a turn on the spot at each vertex; or why there is none."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gazechair.base.footprint import FloatArray
from gazechair.going.bends import Bend
from gazechair.going.smooth import PASSES_M, Pose

_EASY_S, _EASY_S_PER_M = 20.0, 7.0


@dataclass(frozen=True)
class Way:
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

    def begun_at(self, vertex: int, pose: Pose) -> Way:
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


@dataclass(frozen=True)
class NoWay:
    """There is no path; `reason` is a key of the string tables."""

    reason: str
