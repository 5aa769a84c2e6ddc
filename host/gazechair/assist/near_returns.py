"""The returns of each lidar's newest turn, in the chair's present frame."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from gazechair.base.angles import half_turn_deg
from gazechair.base.arrays import FloatArray
from gazechair.sensing.clearance.surface import surfaces
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.lidar.blind import NEAREST_M

OLD_S = 0.15
"""If the heading or the data of any lidar is older, nothing is known."""
_KEPT_S = 1.0  # how long headings are kept
_HALVES = 2  # half turns kept of each lidar
_FARTHEST_M = 5.0


class NearReturns:
    """Newest returns, corrected for the chair's turning since (heading sensor), not its travel."""

    def __init__(self, lidars: int) -> None:
        """`lidars`: their number; all must deliver."""
        self._halves: list[deque[tuple[float, FloatArray]]] = [
            deque(maxlen=_HALVES) for _ in range(lidars)
        ]
        self._times: deque[float] = deque()
        self._headings: deque[float] = deque()  # degrees, not wrapped
        self._received_s = -math.inf

    def motion(self, motion: Motion) -> None:
        """The board's newest heading. Without one, nothing counts that was seen by those before."""
        if motion.heading_deg is None:
            self._times.clear()
            self._headings.clear()
            for halves in self._halves:
                halves.clear()
            return
        heading = motion.heading_deg
        if self._headings:
            heading = self._headings[-1] + half_turn_deg(heading - self._headings[-1])
        self._times.append(motion.time_s)
        self._headings.append(heading)
        while self._times[0] < motion.time_s - _KEPT_S:
            self._times.popleft()
            self._headings.popleft()

    def see(self, lidar: int, piece: Piece) -> None:
        """Half a turn of the lidar with that number."""
        if not self._times:
            return
        near = (piece.distances_m >= NEAREST_M) & (piece.distances_m <= _FARTHEST_M)
        turned = np.interp(piece.times_s[near], self._times, self._headings)
        # In a frame that does not turn with the chair.
        angles = np.radians(piece.directions_deg[near] + turned)
        mount = np.radians(turned)
        x_m, y_m = piece.origin_m
        middle = np.radians(np.interp(piece.middle_s, self._times, self._headings))
        c, s = math.cos(middle), math.sin(middle)
        points = np.empty((len(angles), 2))
        points[:, 0] = piece.distances_m[near] * np.cos(angles)
        points[:, 1] = piece.distances_m[near] * np.sin(angles)
        points[:, 0] += x_m * np.cos(mount) - y_m * np.sin(mount)
        points[:, 1] += x_m * np.sin(mount) + y_m * np.cos(mount)
        origin = (c * x_m - s * y_m, s * x_m + c * y_m)
        smooth = surfaces(points, origin).points_m if len(points) else points
        self._halves[lidar].append((float(piece.times_s[-1]), smooth))

    def heading_deg(self, now_s: float) -> float | None:
        """The newest heading, not wrapped; None: not known."""
        if not self._times or now_s - self._times[-1] > OLD_S:
            return None
        return self._headings[-1]

    def rate_deg_s(self) -> float:
        """The chair's turn rate, left positive."""
        if len(self._times) < 2:
            return 0.0
        first = max(0, len(self._times) - 6)
        dt_s = self._times[-1] - self._times[first]
        return (self._headings[-1] - self._headings[first]) / dt_s if dt_s > 0.0 else 0.0

    def points_m(self, now_s: float) -> FloatArray | None:
        """All returns, (N, 2); None: data of a lidar or the heading is missing or old."""
        heading = self.heading_deg(now_s)
        if heading is None:
            return None
        for halves in self._halves:
            if len(halves) < _HALVES or now_s - halves[-1][0] > OLD_S:
                return None
        points = np.concatenate([points for halves in self._halves for _, points in halves])
        c, s = math.cos(math.radians(heading)), math.sin(math.radians(heading))
        return np.asarray(points @ np.array(((c, -s), (s, c))))
