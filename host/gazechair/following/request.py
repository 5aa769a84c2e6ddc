"""The motion that a follower requests."""

from __future__ import annotations

from dataclasses import dataclass

from gazelink.settings_table import TABLE, index_of

CAP_M_S = TABLE[index_of("auto_mm_s")][3] / 1000.0
"""Highest speed of a request, the most that the board's setting can allow."""


@dataclass(frozen=True)
class Request:
    """Requested forward speed and turn rate, left positive."""

    linear_m_s: float = 0.0
    yaw_rad_s: float = 0.0


STOP = Request()
