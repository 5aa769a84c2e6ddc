"""Odometry's core in virtual time: drives through a home, judged by the simulator's truth."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.odometry import Odometry
from gazesim import home_plans
from gazesim.home_drive import FRONT, REAR, Drive, Mounted, Truth


@dataclass
class Driven:
    """Odometry's estimates of a drive, and the truth."""

    said: list[Estimate]
    true: list[Truth]
    way_m: float

    def off_m(self) -> np.ndarray:
        """Position error of each estimate, with a correct first one."""
        first, began = self.said[0], self.true[0]
        turn = math.radians(began.heading_deg - first.heading_deg)
        c, s = math.cos(turn), math.sin(turn)
        places = np.array([(one.x_m - first.x_m, one.y_m - first.y_m) for one in self.said])
        moved = np.array([(one.x_m - began.x_m, one.y_m - began.y_m) for one in self.true])
        return np.hypot(*(places @ np.array(((c, s), (-s, c))) - moved).T)


def drive(seed: int, seconds: float, lidars: tuple[Mounted, ...]) -> Driven:
    driven = Drive(home_plans.home(seed), seed, lidars, per_turn=800)
    odometry = Odometry()
    said, true = [], []
    for event in driven.events(seconds):
        if isinstance(event, Motion):
            odometry.motion(event)
        elif (found := odometry.piece(event)) is not None:
            said.append(found)
            true.append(driven.truth(found.time_s))
    return Driven(said, true, driven.way_m)


@pytest.mark.parametrize("lidars", [(FRONT, REAR), (FRONT,)], ids=["two lidars", "one"])
def test_a_drive_through_a_home_is_followed(lidars: tuple[Mounted, ...]) -> None:
    driven = drive(4, 16.0, lidars)
    assert driven.way_m > 2.0
    assert driven.off_m().max() < 0.05
    speeds = [abs(a.speed_m_s - b.speed_m_s) for a, b in zip(driven.said, driven.true, strict=True)]
    assert np.percentile(speeds, 95) < 0.05
    yaw = [
        a.yaw_rate_deg_s - b.yaw_rate_deg_s for a, b in zip(driven.said, driven.true, strict=True)
    ]
    assert np.percentile(np.abs(yaw), 95) < 5.0


def test_headings_that_came_together_say_no_turn() -> None:
    odometry, rates = Odometry(), []
    for event in Drive(home_plans.home(4), 4, (FRONT,), per_turn=200).events(2.0):
        if isinstance(event, Motion):
            odometry.motion(replace(event, time_s=math.floor(5.0 * event.time_s) / 5.0))
        elif (found := odometry.piece(event)) is not None:
            rates.append(found.yaw_rate_deg_s)
    assert len(rates) > 10
    assert rates == [0.0] * len(rates)
