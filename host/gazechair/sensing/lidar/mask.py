"""Learns which arcs of a lidar's view the chair itself covers, from scans in empty surroundings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray
from gazechair.base.footprint import distance_m, inside
from gazechair.base.user_error import UserError
from gazechair.sensing.lidar.blind import BINS, FAR_M, runs
from gazechair.sensing.lidar.scan import Arc, Pose, Scan

LEAST_SCANS = 20
MOST_DEG = 300
_CHAIR_M = 0.10  # a return this near to the outline, or within it, is the chair
_ROOM_M = 0.50  # nothing else may be nearer
_STEADY_M = 0.05
_OFTEN, _HARDLY = 0.5, 0.05  # shares of the turns
_GROW_DEG, _MERGE_DEG = 1, 3
_HALF = BINS // 2


class MaskError(UserError):
    """No mask can be learned here; the text is one plain line: why, what to do."""


@dataclass(frozen=True)
class Learned:
    """`mask`: the arcs for the configuration. The others are its two causes, in degrees of
    the lidar's own frame: where it sees the chair, and where it never sees anything."""

    mask: tuple[Arc, ...]
    chair: tuple[Arc, ...]
    nothing: tuple[Arc, ...]


def learn(scans: Sequence[Scan], pose: Pose, outline_m: FloatArray) -> Learned:
    """The mask of a lidar at `pose` on a chair with `outline_m` (n, 2), from scans of whole turns.

    The surroundings must be empty for 0.5 m round the chair, with walls nearer than 8 m. Raises
    MaskError when they are not, when something moves, or when next to nothing would be left.
    """
    if len(scans) < LEAST_SCANS:
        text = "only {seen} turns were seen, {needed} are needed: try again"
        raise MaskError(text, "mask_few", seen=len(scans), needed=LEAST_SCANS)
    nearest = np.array([_nearest(scan) for scan in scans])
    share = np.isfinite(nearest).mean(axis=0)
    often = share >= _OFTEN
    middle = np.full(BINS, np.inf)
    middle[often] = np.nanmedian(np.where(np.isinf(nearest), np.nan, nearest)[:, often], axis=0)
    to_chair_m = _distance_to_chair(middle, pose, outline_m)
    chair = often & (to_chair_m <= _CHAIR_M)
    near = often & ~chair & (to_chair_m < _ROOM_M)
    # A beam at a part's edge measures between it and its background: that is no obstacle.
    near &= ~_grown(chair, _GROW_DEG)
    if near.any():
        at = int(np.argmin(np.where(near, to_chair_m, np.inf)))
        raise MaskError(
            "something stands {metres} m from the chair at {deg} degrees of this lidar; make room"
            " for {room} m all round, or correct pose and footprint",
            "mask_near",
            metres=round(float(to_chair_m[at]), 2),
            deg=at - _HALF,
            room=_ROOM_M,
        )
    spread = np.zeros(BINS)
    spread[chair] = np.ptp(np.percentile(_finite(nearest[:, chair]), (10, 90), axis=0), axis=0)
    if (spread > _STEADY_M).any():
        at = int(np.argmax(spread))
        text = "something moves at {deg} degrees of this lidar; keep all still"
        raise MaskError(text, "mask_moves", deg=at - _HALF)
    nothing = share < _HARDLY
    _refuse_open(nothing, often, middle)
    masked = _merged(_grown(chair | nothing, _GROW_DEG))
    total = int(np.count_nonzero(masked))
    if total > MOST_DEG:
        raise MaskError(
            "{masked} of {all} degrees would be masked; is it covered, or its pose wrong?",
            "mask_covered",
            masked=total,
            all=BINS,
        )
    return Learned(_arcs(masked), _arcs(chair), _arcs(nothing))


def _nearest(scan: Scan) -> FloatArray:
    found = np.full(BINS, np.inf)
    returned = scan.distances_m > 0.0
    bins = np.minimum((scan.angles_deg[returned] + _HALF).astype(np.int64), BINS - 1)
    np.minimum.at(found, bins, scan.distances_m[returned])
    return found


def _finite(nearest: FloatArray) -> FloatArray:
    """`nearest` with missing values replaced by the degree's median."""
    missing = np.isinf(nearest)
    usual = np.nanmedian(np.where(missing, np.nan, nearest), axis=0)
    return np.where(missing, usual, nearest)


def _distance_to_chair(middle: FloatArray, pose: Pose, outline_m: FloatArray) -> FloatArray:
    """Distance of each degree's return to the outline, m; 0 within it, inf without a return."""
    seen = np.isfinite(middle)
    middles_deg = np.arange(BINS, dtype=np.float64) - _HALF + 0.5
    radians = np.radians(pose.directions_deg(middles_deg))[seen]
    points = np.empty((len(radians), 2))
    points[:, 0] = pose.x_m + middle[seen] * np.cos(radians)
    points[:, 1] = pose.y_m + middle[seen] * np.sin(radians)
    found = np.full(BINS, np.inf)
    found[seen] = np.where(inside(outline_m, points), 0.0, distance_m(outline_m, points))
    return found


def _refuse_open(nothing: BoolArray, often: BoolArray, middle: FloatArray) -> None:
    """Raise MaskError if a gap may be open space, which has no near border."""
    for first, count in runs(nothing):
        borders = [at % BINS for at in (first - 1, first + count) if often[at % BINS]]
        if borders and count < BINS and min(middle[at] for at in borders) >= FAR_M:
            raise MaskError(
                "no end is seen at {deg} degrees of this lidar; do this in a room whose walls are"
                " nearer than {far} m",
                "mask_open",
                deg=first - _HALF,
                far=FAR_M,
            )


def _grown(flags: BoolArray, by: int) -> BoolArray:
    grown = flags.copy()
    for shift in range(1, by + 1):
        grown |= np.roll(flags, shift) | np.roll(flags, -shift)
    return grown


def _merged(flags: BoolArray) -> BoolArray:
    merged = flags.copy()
    for first, count in runs(~flags):
        if count <= _MERGE_DEG:
            merged[(first + np.arange(count)) % BINS] = True
    return merged


def _arcs(flags: BoolArray) -> tuple[Arc, ...]:
    found = []
    for first, count in runs(flags):
        last = (first + count) % BINS or BINS
        found.append((float(first - _HALF), float(last - _HALF)))
    return tuple(found)
