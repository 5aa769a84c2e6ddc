"""Dead reckoning by the chair's measured speeds."""

from __future__ import annotations

import math

from gazechair.going.plan import Pose

_STANDS_M_S, _STANDS_DEG_S = 0.03, 1.0  # slower is noise


def moved(pose: Pose, speed_m_s: float, rate_deg_s: float, seconds: float) -> Pose:
    """The pose after `seconds` at constant speeds."""
    turned = math.radians(rate_deg_s) * seconds
    middle = pose[2] + 0.5 * turned
    way = speed_m_s * seconds
    return (
        pose[0] + way * math.cos(middle),
        pose[1] + way * math.sin(middle),
        pose[2] + turned,
    )


class Rolled:
    """A pose in a frame of its own; constant at standstill, unlike the pose in the map."""

    def __init__(self) -> None:
        self.pose: Pose = (0.0, 0.0, 0.0)

    def on(self, speed_m_s: float, rate_deg_s: float, seconds: float) -> None:
        """Integrate speeds over `seconds`; noise at standstill is ignored."""
        if abs(speed_m_s) > _STANDS_M_S or abs(rate_deg_s) > _STANDS_DEG_S:
            self.pose = moved(self.pose, speed_m_s, rate_deg_s, seconds)
