"""The motion that a follower requests."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Request:
    """Requested forward speed and turn rate, left positive."""

    linear_m_s: float = 0.0
    yaw_rad_s: float = 0.0


STOP = Request()
