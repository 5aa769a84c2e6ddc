"""The chair's present pose in a map: mapping's newest fix, moved on by odometry.

Also as a datagram, for other processes.
"""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field

import numpy as np

from gazechair.base import json_text
from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between, compose
from gazechair.sensing.odometry.estimate import Estimate

CONFIRMED_S = 1.0  # a fix counts for this long; mapping looks ten times a second
_DRIFT = 0.02  # error of odometry alone: m per m, and degrees per degree


@dataclass(frozen=True)
class Whereabouts:
    """The chair's pose in a map; uncertainties are standard deviations."""

    time_s: float
    """Monotonic: of the measurements."""
    map: str
    """Its id in the store."""
    x_m: float
    y_m: float
    heading_deg: float
    """Counter-clockwise, 0..360; x and y are the drive axle's."""
    sigma_m: float
    sigma_deg: float
    explained: float
    """Share of the look that the map explains, 0..1; low in a crowd, or where much was moved."""
    mounting_m: float = field(default=0.0, kw_only=True)
    """The part of `sigma_m` that comes from the lidars' directions on the chair."""
    mounting_deg: float = field(default=0.0, kw_only=True)
    """The same of `sigma_deg`."""


@dataclass(frozen=True)
class Fix(Whereabouts):
    """A pose found by mapping, and odometry's pose at that time in metres and degrees."""

    odometry: tuple[float, float, float]
    track: int


def onward(fix: Fix, estimate: Estimate) -> Whereabouts | None:
    """The pose at the estimate; None: odometry has started again, or the fix is too old."""
    age_s = estimate.time_s - fix.time_s
    if estimate.track != fix.track or abs(age_s) > CONFIRMED_S:
        return None
    here = estimate.pose()
    moved = between(_pose(*fix.odometry), here)
    x_m, y_m, heading_rad = compose(_pose(fix.x_m, fix.y_m, fix.heading_deg), moved).tolist()
    way_m, turned_deg = math.hypot(moved[0], moved[1]), abs(math.degrees(moved[2]))
    return Whereabouts(
        estimate.time_s,
        fix.map,
        x_m,
        y_m,
        math.degrees(heading_rad) % 360.0,
        math.hypot(fix.sigma_m, _DRIFT * way_m),
        math.hypot(fix.sigma_deg, _DRIFT * turned_deg),
        fix.explained,
        mounting_m=fix.mounting_m,
        mounting_deg=fix.mounting_deg,
    )


def pack(where: Whereabouts) -> bytes:
    """As one datagram."""
    return b"W" + json.dumps(asdict(where)).encode()


def unpack(datagram: bytes) -> Whereabouts | None:
    """The content of a datagram; None: it is malformed."""
    if datagram[:1] != b"W":
        return None
    try:
        return Whereabouts(**json_text.parse(datagram[1:]))
    except (ValueError, TypeError):
        return None


def _pose(x_m: float, y_m: float, heading_deg: float) -> FloatArray:
    return np.array((x_m, y_m, math.radians(heading_deg)))
