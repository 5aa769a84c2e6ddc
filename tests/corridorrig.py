"""A corridor, bare or with doors, and a driver who drives straight along it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from gazesim.home_drive import STEP_S
from gazesim.home_routes import Pose
from gazesim.homes import Home
from gazesim.rooms import Solid, box

HALF_M = 0.65  # of the corridor's width
BEGINS_S = 1.5
DOOR_M, DEEP_M = 0.9, 0.10  # doors, and how far they lie back
BED_M = 1.5  # from the drive axle


@dataclass
class Straight:
    """Replaces the driver: along the corridor, while a bed moves in it."""

    home: Home
    pose: Pose
    speed_m_s: float
    permille: tuple[int, int]
    bed_m_s: float | None
    route: tuple[Pose, ...] = ()
    speeds: tuple[float, float] = (0.0, 0.0)
    now_s: float = 0.0

    def look(self) -> None:
        if self.bed_m_s is not None:
            gone_m = self.bed_m_s * max(0.0, self.now_s - BEGINS_S)
            self.home.put("bed", box(BED_M + 1.0 + gone_m, 0.0, 2.0, 1.1, 0.0, 0.8, "bed"))

    def step(self) -> None:
        self.now_s += STEP_S
        speed = min(abs(self.speed_m_s), 0.6 * max(0.0, self.now_s - BEGINS_S))
        speed = math.copysign(speed, self.speed_m_s)
        self.speeds = speed, 0.0
        self.pose = replace(self.pose, x_m=self.pose.x_m + speed * STEP_S)


def corridor(*more: Solid) -> Home:
    walls = tuple((-30.0, side, 30.0, side) for side in (-HALF_M, HALF_M))
    ends = tuple((x, -HALF_M, x, HALF_M) for x in (-30.0, 30.0))
    return Home("corridor", (*walls, *ends), more)


def with_doors(first_m: float, every_m: float) -> Home:
    """Doors on both sides, those on the left half of the distance farther on."""
    walls = []
    for side, begins_m in ((-1.0, first_m), (1.0, first_m + 0.5 * every_m)):
        near, deep, x = side * HALF_M, side * (HALF_M + DEEP_M), -30.0
        while begins_m < 28.0:
            ends_m = begins_m + DOOR_M
            walls += [(x, near, begins_m, near), (begins_m, near, begins_m, deep)]
            walls += [(begins_m, deep, ends_m, deep), (ends_m, deep, ends_m, near)]
            x, begins_m = ends_m, begins_m + every_m
        walls.append((x, near, 30.0, near))
    ends = tuple((x, -HALF_M, x, HALF_M) for x in (-30.0, 30.0))
    return Home("corridor", (*walls, *ends))
