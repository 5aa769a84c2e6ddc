"""Dead reckoning by the chair's measured speeds."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gazechair.going.plan import Pose

POSE_OLD_S = 0.35
"""With an older pose the chair must stand within 0.5 s (promise P20)."""
_STANDS_M_S, _STANDS_DEG_S = 0.03, 1.0  # slower is noise


def along(pose: Pose, metres: float, turned_rad: float) -> Pose:
    """The pose at the end of an arc of that length, turning steadily."""
    middle = pose[2] + 0.5 * turned_rad
    return (
        pose[0] + metres * math.cos(middle),
        pose[1] + metres * math.sin(middle),
        pose[2] + turned_rad,
    )


def moved(pose: Pose, speed_m_s: float, rate_deg_s: float, seconds: float) -> Pose:
    """The pose after `seconds` at constant speeds."""
    return along(pose, speed_m_s * seconds, math.radians(rate_deg_s) * seconds)


@dataclass(frozen=True)
class Located:
    """The chair's pose and speeds at a time."""

    pose: Pose
    speed_m_s: float
    rate_deg_s: float
    time_s: float

    def pose_at(self, time_s: float) -> Pose:
        """Its pose at another time, if it moves on as it did."""
        return moved(self.pose, self.speed_m_s, self.rate_deg_s, time_s - self.time_s)


class Rolled:
    """A pose in a frame of its own; constant at standstill, unlike the pose in the map."""

    def __init__(self) -> None:
        self.pose: Pose = (0.0, 0.0, 0.0)

    def on(self, speed_m_s: float, rate_deg_s: float, seconds: float) -> None:
        """Integrate speeds over `seconds`; noise at standstill is ignored."""
        if abs(speed_m_s) > _STANDS_M_S or abs(rate_deg_s) > _STANDS_DEG_S:
            self.pose = moved(self.pose, speed_m_s, rate_deg_s, seconds)
