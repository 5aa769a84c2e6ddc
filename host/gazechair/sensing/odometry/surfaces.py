"""What odometry remembers: surfaces, coarse and fine, and what the newest turns told."""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.sensing.odometry.apart import WholeTurn
from gazechair.sensing.odometry.local_map import LocalMap, layers_of
from gazechair.sensing.odometry.match import FORWARD, OFFSET, Fit, fit
from gazechair.sensing.odometry.smear import Smear

_KNOWN = 0.85  # if less of what is seen is known, surfaces are added here again
_INSERT_M, _INSERT_RAD = 0.10, math.radians(5.0)
_SEEN_S = 0.4  # for so long a surface has been seen, on average, when it first counts
_LEAST_M2 = 1e-6  # left of the variance, so that it can be inverted
_SAME = 0.7  # two directions of the position are the same, cosine


class Surfaces:
    """In the frame of odometry."""

    def __init__(self) -> None:
        self.fine = LocalMap(0.10)
        self._coarse = LocalMap(0.25)
        self._turn = WholeTurn()
        self._smear = Smear()
        self._begins_anew = False  # with the next piece
        self._open: tuple[FloatArray, ...] = ()  # directions that the newest fit left open
        # Where each lidar's surfaces were renewed: x, y, heading.
        self._inserted: dict[int, tuple[float, float, float]] = {}

    def forget(self) -> None:
        """Nothing that is seen is known."""
        self.fine.clear()
        self._coarse.clear()
        self._turn.forget()
        self._smear, self._begins_anew = Smear(), False
        self._open = ()
        self._inserted.clear()

    def fit(
        self,
        at_s: float,
        points: FloatArray,
        normals: FloatArray,
        prior: FloatArray,
        covariance: FloatArray,
        heading_rad: float,
        learns: bool,
    ) -> Fit:
        """See match.fit.

        Where a direction was open, the surfaces that end that are as far off along it as the chair
        was when it saw them: they tell how far it has come since then, not where it is. Only a fit
        shows that they end it, so such a piece is fitted again.
        """
        known, before = (self._coarse, self.fine), self._turn.until(at_s)
        found = fit(*known, points, normals, prior, covariance, heading_rad, before, learns)
        angle = heading_rad + float(prior[OFFSET])
        ahead = np.array((math.cos(angle), math.sin(angle)))
        for axis in self._open:
            if any(abs(axis @ other) > _SAME for other in found.open_axes):
                continue
            since = since_seen(covariance, axis, ahead)
            if axis @ (covariance - since)[:2, :2] @ axis > 0.0:
                return fit(*known, points, normals, prior, since, heading_rad, before, learns)
        return found

    def note(self, at_s: float, found: Fit) -> None:
        """Later fits of the same turn count with what this one told."""
        self._turn.take(at_s, found.constraints)
        self._open = found.open_axes
        self._begins_anew |= self._smear.take(at_s, found, self._turn.until(at_s))

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
        if self._begins_anew:
            self._begins_anew = False
            self._inserted.clear()
            self.fine.begin_anew(at_s)
            self._coarse.begin_anew(at_s)
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


def since_seen(covariance: FloatArray, axis: FloatArray, ahead: FloatArray) -> FloatArray:
    """The covariance relative to surfaces first seen a moment ago, along `axis`, (2,).

    What the position was off until then is theirs, too; since then the speed was off as it is.
    `ahead`: (2,), where the chair points.
    """
    change = np.eye(len(covariance))
    change[:2, :2] -= np.outer(axis, axis)
    change[:2, FORWARD] = _SEEN_S * (axis @ ahead) * axis
    since = change @ covariance @ change.T
    since[:2, :2] += _LEAST_M2 * np.outer(axis, axis)
    return np.asarray(since)
