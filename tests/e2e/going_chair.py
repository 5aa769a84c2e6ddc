"""A chair that is taken to a place, in virtual time: the daemon's parts and the whole firmware.

Where it is in the map is told by the simulator: a double for odometry and mapping, in tests alone.
"""

from __future__ import annotations

from collections import deque
from pathlib import Path

import numpy as np

from gazechair.base import health as states
from gazechair.base.supervisor import Status
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.locating.whereabouts import Whereabouts
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.places import Drawn
from gazechair.sensing.odometry.estimate import Estimate
from gazesim.producer_chair import ProducerChair
from gazesim.rooms import Room

CELL_M = 0.05
WHERE_MS = 100
PATH_MS = 60  # of what a page sends: network, host and cable
POSE_LOST_MS = 500


def bare_floor(size_m: float, drawn: Drawn) -> HomeMap:
    """A square floor without walls in sight, centred at the origin."""
    cells = round(size_m / CELL_M)
    passes = np.full((cells, cells), 9, dtype=np.uint16)
    hits = np.zeros_like(passes)
    hits[[0, -1]] = hits[:, [0, -1]] = 99
    low = np.full(2, -size_m / 2.0)
    return HomeMap("Thuis", OccupancyGrid(CELL_M, low, hits, passes), drawn=drawn)


class GoingChair(ProducerChair):
    """`located`: its pose in the map is told; `measured`: odometry's, which that needs."""

    def __init__(self, folder: Path, drawn: Drawn, room: str | Room = "open") -> None:
        self.located = self.measured = True
        self._truth: deque[tuple[float, float, float, float, float, float]] = deque(maxlen=300)
        self._at: Estimate | None = None
        super().__init__(folder, bare_floor(12.0, drawn), room)
        self.until(lambda: not self.board.app.obstacles.blocked & 15, 700)

    def child_fails(self, how: str = "killed") -> None:
        """Its process is killed, or hangs."""
        if how == "hung":
            self.stopped = True
            return
        self.alive = False
        self.service._on_status(Status(states.LOST, "plugin_lost", "", "ended"))

    def loses_its_pose(self) -> None:
        """Neutral and over in time; the chair stays there when the pose is back."""
        self.measured = False
        ms = self.until(self.neutral, POSE_LOST_MS)
        self.until(lambda: self.news["state"] == "ended", POSE_LOST_MS + PATH_MS - ms)
        self.measured = True  # too late: the chair may be elsewhere
        self.stays_still(1500)

    def _daemon(self) -> None:
        chair, now_s = self.world.chair, self.now_s()
        pose = chair.x_m, chair.y_m, chair.heading_deg, chair.speed_m_s, chair.yaw_rate_deg_s
        self._truth.append((now_s, *pose))
        super()._daemon()

    def _locate(self) -> None:
        if self.now_ms % WHERE_MS == 0 and self.located and self._at is not None:
            at = self._at
            place = at.x_m, at.y_m, at.heading_deg
            where = Whereabouts(at.time_s, self.map, *place, 0.02, 0.3, 0.9)
            self.service.where(where)

    def _half_turn(self, half: HalfTurn) -> None:
        piece = self._lidars.piece(half)
        if piece is None or not self.measured:
            return
        at_s = piece.middle_s
        _, x, y, heading, speed, rate = min(self._truth, key=lambda row: abs(row[0] - at_s))
        sigmas = (0.0, 0.0, 0.1, 0.02)
        matched, doubts, track = 1.0, (), 1
        self._at = Estimate(at_s, x, y, heading, speed, 0.0, rate, *sigmas, matched, doubts, track)
        self.service.estimate(self._at)
