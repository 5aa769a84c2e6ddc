"""Looks: the last turn of every lidar, de-skewed, at odometry's pose."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.mapping.locating.map_match import Look, together
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.points import seen_points, taken_for

_TURN_S = 0.11  # of a lidar, with some slack
_KEPT = 16  # pieces: of four lidars


@dataclass(frozen=True)
class Seen:
    """What the lidars see at an estimate's pose."""

    look: Look
    odometry: FloatArray
    """(3,): x, y in metres, heading in radians, full turns counted; in odometry's frame."""
    estimate: Estimate


class Looks:
    """Feed it the pieces that odometry gets, and odometry's estimates."""

    def __init__(self) -> None:
        self._pieces: deque[Piece] = deque(maxlen=_KEPT)
        self._known: deque[tuple[Piece, Estimate]] = deque(maxlen=_KEPT)

    def piece(self, piece: Piece) -> None:
        """A piece of a turn, whose estimate is still to come."""
        self._pieces.append(piece)

    def estimate(self, estimate: Estimate) -> bool:
        """Take an estimate; True: `seen` gives what was seen at its pose."""
        if self._known and self._known[-1][1].track != estimate.track:
            self._known.clear()
        piece = taken_for(self._pieces, estimate.time_s)
        if piece is None or estimate.left_out:
            return False
        self._known.append((replace(piece, as_of_s=estimate.time_s), estimate))
        return True

    @property
    def newest(self) -> Estimate:
        """The newest estimate."""
        return self._known[-1][1]

    @property
    def track(self) -> int:
        """Of the newest estimate; see Estimate.track."""
        return self.newest.track

    @property
    def pose(self) -> FloatArray:
        """Of the newest estimate; see Seen.odometry."""
        return self.newest.pose()

    def seen(self) -> Seen:
        """Everything seen within the last turn, relative to the newest pose."""
        newest = self.newest
        here = self.pose
        looks = []
        for piece, estimate in self._known:
            if estimate.time_s > newest.time_s - _TURN_S:
                after_s = piece.times_s - estimate.time_s
                turned = math.radians(estimate.yaw_rate_deg_s) * after_s
                points, _ = seen_points(piece, turned, estimate.speed_m_s, estimate.sideways_m_s)
                origins = np.tile(piece.origin_m, (len(points), 1))
                looks.append(Look(points, origins).moved(between(here, estimate.pose())))
        return Seen(together(looks), here, newest)
