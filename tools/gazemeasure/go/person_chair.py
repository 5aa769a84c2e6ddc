"""The chair of the walks: how it moves."""

from __future__ import annotations

import math
import random

from gazechair.following.request import Request
from gazemeasure.go.person_walk import STEP_S
from gazesim.home_drive import STEP_S as AXIS_S
from gazesim.home_drive import Axis
from gazesim.home_routes import Pose
from gazesim.homes import Home

ROOM_M = 0.03
"""It stops this far from anything, as the board does."""
_RAMP_M_S2, _RAMP_DEG_S2 = 0.6, 80.0


class Chair:
    """Kinematic: dead time, ramps, lag; stops before what it would touch, as the board does."""

    def __init__(self, pose: Pose, chance: random.Random) -> None:
        self.pose = pose
        self._linear = Axis(_RAMP_M_S2, chance)
        self._turn = Axis(_RAMP_DEG_S2, chance)
        self.blocked = False

    def place(self, pose: Pose) -> None:
        """Put the chair at `pose`, standing."""
        self.pose = pose
        self._linear.halt()
        self._turn.halt()

    @property
    def moves(self) -> bool:
        return abs(self._linear.speed) > 0.02 or abs(self._turn.speed) > 1.0

    def step(self, home: Home, request: Request) -> float:
        """Drive for 50 ms; returns the distance travelled."""
        way = turn = 0.0
        for _ in range(round(STEP_S / AXIS_S)):
            way += self._linear.step(request.linear_m_s)
            turn += self._turn.step(math.degrees(request.yaw_rad_s))
        self.blocked = False
        if self._moves_to(home, way, turn):
            return way
        self.blocked = True
        if self._moves_to(home, 0.0, turn):
            self._linear.halt()
            return 0.0
        self._turn.halt()
        if self._moves_to(home, way, 0.0):
            return way
        self._linear.halt()
        return 0.0

    def _moves_to(self, home: Home, way: float, turn: float) -> bool:
        here = self.pose
        heading = math.radians(here.heading_deg + 0.5 * turn)
        x, y = here.x_m + way * math.cos(heading), here.y_m + way * math.sin(heading)
        room_m = home.clearance_m(x, y, here.heading_deg + turn)
        if room_m < min(ROOM_M, home.clearance_m(here.x_m, here.y_m, here.heading_deg)):
            return False
        self.pose = Pose(x, y, here.heading_deg + turn)
        return True
