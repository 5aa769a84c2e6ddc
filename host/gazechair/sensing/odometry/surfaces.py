"""What odometry remembers: surfaces, coarse and fine, and what the newest turns told."""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.footprint import FloatArray
from gazechair.sensing.odometry.apart import WholeTurn
from gazechair.sensing.odometry.local_map import LocalMap, layers_of
from gazechair.sensing.odometry.match import Fit, fit

_KNOWN = 0.85  # if less of what is seen is known, surfaces are added here again
_INSERT_M, _INSERT_RAD = 0.10, math.radians(5.0)


class Surfaces:
    """In the frame of odometry."""

    def __init__(self) -> None:
        self.fine = LocalMap(0.10)
        self._coarse = LocalMap(0.25)
        self._turn = WholeTurn()
        # Where each lidar's surfaces were renewed: x, y, heading.
        self._inserted: dict[int, tuple[float, float, float]] = {}

    def forget(self) -> None:
        """Nothing that is seen is known."""
        self.fine.clear()
        self._coarse.clear()
        self._turn.forget()
        self._inserted.clear()

    def fit(
        self,
        at_s: float,
        points: FloatArray,
        normals: FloatArray,
        prior: FloatArray,
        covariance: FloatArray,
        heading_rad: float,
    ) -> Fit:
        """See match.fit."""
        known, before = (self._coarse, self.fine), self._turn.until(at_s)
        return fit(*known, points, normals, prior, covariance, heading_rad, before)

    def note(self, at_s: float, found: Fit) -> None:
        """Later fits of the same turn count with what this one told."""
        self._turn.take(at_s, found.told)

    def renew(
        self,
        lidar: int,
        at_s: float,
        points: FloatArray,
        normals: FloatArray,
        pose: tuple[float, float, float],
        known: float,
    ) -> None:
        """Add a piece, (N, 2) points and normals as seen from `pose`, unless it shows nothing new.

        `known`: the share of the points that lie near known surfaces.
        """
        x, y, angle = pose
        if (before := self._inserted.get(lidar)) is not None:
            moved = math.hypot(x - before[0], y - before[1])
            new = known < _KNOWN
            if moved < _INSERT_M and abs(angle - before[2]) < _INSERT_RAD and not new:
                return
        self._inserted[lidar] = pose
        c, s = math.cos(angle), math.sin(angle)
        rotation = np.array(((c, s), (-s, c)))
        places, layers = points @ rotation + (x, y), layers_of(normals @ rotation)
        for surfaces in (self.fine, self._coarse):
            surfaces.follow(x, y)
            surfaces.insert(places, layers, at_s)
