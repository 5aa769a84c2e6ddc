"""Where the chair is in a map, as localization found it."""

from __future__ import annotations

from dataclasses import dataclass

from gazechair.base.arrays import FloatArray
from gazechair.sensing.mapping.locating.map_match import Evidence


@dataclass(frozen=True)
class Location:
    """Where the chair is in the map, and the evidence for it."""

    pose: FloatArray
    """(3,): x, y in metres, heading in radians."""
    evidence: Evidence
    sigma_m: float
    """Standard deviation of the position, in the worst direction."""
    sigma_rad: float
    is_open: bool = False
    """Whether odometry alone tells the position in a direction, since the map does not."""
    mounting_m: float = 0.0
    """The part of `sigma_m` that comes from the lidars' directions on the chair."""
    mounting_rad: float = 0.0
    """The same of `sigma_rad`."""
