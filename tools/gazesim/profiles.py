"""The chair's speed profiles: speeds observed on the chair, and the twin's parameters for each."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, replace

from gazesim.chair_axis import Axis
from gazesim.disturbances import Disturbances

KM_H = 1.0 / 3.6
HALF_TRACK_M = 0.28
USUAL_FLOOR = Disturbances(veer=0.02)


@dataclass(frozen=True)
class Parameters:
    """All numbers of one chair in one profile."""

    linear: Axis
    turn: Axis
    lost_brake_m_s2: float = 1.5  # ramp when the joystick is lost
    lost_brake_deg_s2: float = 300.0
    lost_dead_time_s: float = 0.05
    disturbances: Disturbances = USUAL_FLOOR


# Speeds seen on the chair in km/h: forward, backward, left, right. Left and right are wheel speeds.
SPEEDS_KM_H = {
    "1.2": (0.7, 0.9, 0.4, 0.3),
    "2.1": (1.0, 1.0, 0.7, 0.7),
    "3.1": (1.3, 1.4, 0.8, 0.8),
    "4.1": (1.6, 1.7, 1.0, 1.0),
    "5.1": (2.0, 1.4, 1.0, 1.0),
}


def _parameters(forward: float, backward: float, left: float, right: float) -> Parameters:
    # Driving: estimates, the same for every profile. Turning: as identified.
    per_km_h = math.degrees(KM_H / HALF_TRACK_M)
    linear = Axis(forward * KM_H, backward * KM_H, 0.15, 0.08, 0.6, 1.0, 0.30, 0.01)
    turn = Axis(left * per_km_h, right * per_km_h, 0.125, 0.056, 36.0, 150.0, 0.35, 0.5, 0.4, 9.7)
    return Parameters(linear, turn)


PROFILES = {name: _parameters(*speeds) for name, speeds in SPEEDS_KM_H.items()}


# Two chairs that meet every clue of the first prototype's published turns, found by a search (see
# docs/turning-lab.md).
_LEAST_STICKY = {
    "dead_time_s": 0.2016,
    "deadband": 0.1149,
    "lag_s": 0.4476,
    "accelerate": 42.67,
    "brake": 51.04,
    "friction": 1.265,
    "stiction": 4.08,
}
_IDENTIFIED = {
    "dead_time_s": 0.125,
    "deadband": 0.056,
    "lag_s": 0.35,
    "accelerate": 36.0,
    "brake": 150.0,
    "friction": 0.4,
    "stiction": 9.7,
}


def identified(profile: str) -> Parameters:
    """That profile of the chair that turns as published, undisturbed.

    One of many that would do, in round numbers. KeyError without such a profile.
    """
    return _turning(profile, _IDENTIFIED)


def least_sticky(profile: str) -> Parameters:
    """Likewise, the chair found with the least stiction; its match hangs on the last digit."""
    return _turning(profile, _LEAST_STICKY)


def _turning(profile: str, numbers: dict[str, float]) -> Parameters:
    chair = undisturbed(profile)
    return replace(chair, turn=replace(chair.turn, **numbers))


def undisturbed(profile: str) -> Parameters:
    """That profile on an even floor, with every disturbance zero. KeyError without such a one."""
    return replace(PROFILES[profile], disturbances=Disturbances())


def random_chair(profile: str, seed: int) -> Parameters:
    """Some other chair in that profile, on some other floor: the same one for the same seed.

    Dead time 0.08..0.25 s, lag 0.15..0.45 s, deadband 5..15 %, and random disturbances (gain
    +/- 30 %): the spread expected of chairs that were never measured.
    """
    source = random.Random(seed)
    chair = PROFILES[profile]
    turn = replace(
        chair.turn,
        dead_time_s=source.uniform(0.08, 0.25),
        lag_s=source.uniform(0.15, 0.45),
        deadband=source.uniform(0.05, 0.15),
    )
    linear = replace(chair.linear, dead_time_s=turn.dead_time_s, deadband=turn.deadband)
    return replace(chair, linear=linear, turn=turn, disturbances=Disturbances.drawn(source))
