"""Whole turns of the foremost lidar, de-skewed, each with its pose by odometry.

Odometry gets the same pieces; its estimates arrive after them. The other lidars are not used: a
person whom the foremost one does not see in a turn counts as not seen.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import from_frame, to_frame
from gazechair.following.legs import Scan
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.points import taken_for

_SAME_S = 1e-4
_TURN_S, _SOON_S = 0.1, 0.09  # length of a turn; least time between two results
_NEAREST_M = 0.15
_KEPT_S = 5.0  # pieces without their estimates, for a caller that comes seldom


@dataclass(frozen=True)
class Turn:
    """A de-skewed turn. `pose`: x, y, heading in radians, in the frame of `track`; see Estimate."""

    scan: Scan
    pose: FloatArray
    track: int


class Turns:
    """Feed it the pieces that odometry gets, then odometry's estimates."""

    def __init__(self) -> None:
        self._waiting: deque[Piece] = deque()
        self._parts: deque[tuple[Piece, Estimate]] = deque()
        self._reported_s = -math.inf
        self._foremost: Piece | None = None

    def piece(self, piece: Piece) -> None:
        """A piece of a turn, whose estimate is still to come."""
        if self._foremost is None or piece.origin_m[0] > self._foremost.origin_m[0]:
            self._foremost = piece
            self._waiting.clear()
            self._parts.clear()
        self._waiting.append(piece)
        while self._waiting and self._waiting[0].middle_s < piece.middle_s - _KEPT_S:
            self._waiting.popleft()

    def estimate(self, estimate: Estimate) -> Turn | None:
        """Take an estimate; returns the last whole turn, 10 times a second, else None."""
        piece, foremost = taken_for(self._waiting, estimate.time_s), self._foremost
        if piece is None or foremost is None or piece.lidar != foremost.lidar:
            return None
        if self._parts and self._parts[-1][1].track != estimate.track:
            self._parts.clear()
        self._parts.append((piece, estimate))
        last_s = float(piece.times_s[-1])
        while self._parts[0][0].times_s[-1] <= last_s - _TURN_S:
            self._parts.popleft()
        if last_s < self._reported_s + _SOON_S:
            return None
        self._reported_s = last_s
        return _whole(list(self._parts), last_s)


def _whole(parts: list[tuple[Piece, Estimate]], last_s: float) -> Turn:
    """One turn seen from the newest pose, ordered by bearing, beginning behind the lidar."""
    newest_piece, newest = parts[-1]
    pose = newest.pose()
    points = np.concatenate(
        [to_frame(_points(*part, last_s - _TURN_S), part[1].pose()) for part in parts]
    )
    points = from_frame(points, pose)
    origin_m = newest_piece.origin_m
    bearing = np.arctan2(points[:, 1] - origin_m[1], points[:, 0] - origin_m[0])
    ordered = points[np.argsort(bearing, kind="stable")]
    return Turn(Scan(ordered, origin_m, last_s), pose, newest.track)


def _points(piece: Piece, estimate: Estimate, since_s: float) -> FloatArray:
    """(N, 2) of the returns since then, in the chair's frame of the estimate."""
    seen = (piece.distances_m >= _NEAREST_M) & (piece.times_s > since_s + _SAME_S)
    angle, distance = np.radians(piece.directions_deg[seen]), piece.distances_m[seen]
    after_s = piece.times_s[seen] - estimate.time_s
    turned = math.radians(estimate.yaw_rate_deg_s) * after_s
    x = piece.origin_m[0] + distance * np.cos(angle)
    y = piece.origin_m[1] + distance * np.sin(angle)
    c, s = np.cos(turned), np.sin(turned)
    return np.stack(
        (
            c * x - s * y + estimate.speed_m_s * after_s,
            s * x + c * y + estimate.sideways_m_s * after_s,
        ),
        axis=1,
    )
