"""The board's speed bounds beside the chair's twin: never below the truth, and nothing at rest."""

from __future__ import annotations

import random
from dataclasses import replace
from typing import Any

import pytest

from gazeboard.core.obstacles import Obstacles
from gazeboard.core.shared import Inputs
from gazeboard.io.settings import Settings
from gazelink import codes
from gazelink.messages import CLEAR_FAR
from gazelink.settings_table import PROFILES
from gazesim.chair import Chair

RUN_MS = 5_000
REST_WITHIN_MS = 6_000
TOLERANCE = 1.0  # mm/s or 1/16 degree/s: the bound's own grain


class Beside:
    """A chair and the board's bounds, told the same outputs; the heading sensor says nothing."""

    def __init__(self, profile: str, trusted: bool, seed: int) -> None:
        settings: Any = Settings()
        settings.profile = PROFILES.index(profile)
        self.obstacles: Any = Obstacles(settings)
        self.inputs: Any = Inputs()
        for name in ("forward_mm", "backward_mm", "left_q4", "right_q4"):
            setattr(self.inputs, f"clearance_{name}", CLEAR_FAR)
        self.chair = Chair(profile, seed)
        numbers = self.chair.parameters
        # The floor is level: what it adds is not the chair's own.
        self.chair.parameters = replace(
            numbers, disturbances=replace(numbers.disturbances, veer=0.0)
        )
        self.trusted = trusted
        self.chair.step(0.001, (0.0, 0.0))

    def step(self, linear: int, turn: int) -> None:
        """One millisecond of these outputs, then the board's tick that knows of them."""
        self.chair.step(0.001, (linear / 1000, turn / 1000))
        self.obstacles.step(self.inputs, linear, turn, True, self.trusted)

    def truth(self) -> tuple[float, float, float, float]:
        """Speeds per direction in the board's units."""
        drive = self.chair.speed_m_s * 1000
        turn = self.chair.yaw_rate_deg_s * 16
        return (drive, -drive, turn, -turn)

    def bounds(self) -> list[int]:
        """What the board thinks at most."""
        return [way.speed for way in self.obstacles._ways]


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("trusted", [False, True])
def test_the_bound_is_never_below_the_truth(profile: str, trusted: bool) -> None:
    """Random outputs in both axes, from pulses to long motions and reversals."""
    dice = random.Random(f"{profile} {trusted}")
    both = Beside(profile, trusted, seed=1)
    linear = turn = left_ms = 0
    for ms in range(RUN_MS):
        if left_ms == 0:
            left_ms = dice.choice((1, 3, 20, 100, 400, 1500))
            linear = dice.choice((0, 0, 1000, -1000, dice.randrange(-1000, 1001)))
            turn = dice.choice((0, 0, 1000, -1000, dice.randrange(-1000, 1001)))
        left_ms -= 1
        both.step(linear, turn)
        for direction, true, bound in zip(range(4), both.truth(), both.bounds(), strict=True):
            assert true <= bound + TOLERANCE, (ms, codes.DIRECTIONS[direction])
    rest_ms = 0
    while any(both.bounds()):
        both.step(0, 0)
        rest_ms += 1
        assert rest_ms < REST_WITHIN_MS
    assert both.truth() == (0.0, 0.0, 0.0, 0.0)
