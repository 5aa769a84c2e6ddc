"""The board's core as a mission's rig steps it, and a fast lidar.

Real: safety, motion, turn controller, profile check, obstacles. Missing: frames, wipers, sensors.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gazeboard.core.motion import Motion
from gazeboard.core.obstacles import Obstacles
from gazeboard.core.profile_check import ProfileCheck
from gazeboard.core.tick import Tick
from gazeboard.turning.turn import turn_controller
from gazemeasure.obstacles.eyes import TURN_S, Eye, Where
from gazesim.core_rig import Core


class BoardCore(Core):
    """The firmware's core with its real motion, turn controller, profile check and obstacles."""

    def __init__(self, settings: Any) -> None:
        super().__init__(simulated=True)  # type: ignore[no-untyped-call]
        self.settings = settings
        turn: Any = turn_controller(settings)
        self.turn = turn
        self.motion: Any = Motion(settings, turn)
        self.obstacles: Any = Obstacles(settings)
        check: Any = ProfileCheck(turn.model)
        self._check = check
        parts = (self.obstacles, self.watch, check, self.clock)
        self._tick = Tick(self.safety, self.motion, *parts)

    @property
    def profile_agrees(self) -> bool:
        """True if the chair's measured turns agree with the selected profile."""
        return bool(self._check.agreed)


class HalfTurnEye(Eye):
    """Measures half a turn at once."""

    def step(self, dt_s: float, chair: Where) -> None:
        self._waited_s += dt_s
        if self._waited_s < 0.5 * TURN_S - 1e-9:
            return
        self._waited_s = 0.0
        at = (self._next + np.arange(self._rays // 2)) % self._rays
        self._next = (self._next + self._rays // 2) % self._rays
        self.turns += 1
        at = at[~self._masked[at]]
        if len(at):
            self._distances_m[at] = self._measure(self._angles_deg[at], chair)
