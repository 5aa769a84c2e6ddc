"""De-skews one piece of a lidar's turn and thins it to few points in the chair's frame."""

from __future__ import annotations

from collections.abc import MutableSequence

import numpy as np

from gazechair.base.angles import half_turn_deg
from gazechair.base.arrays import BoolArray, FloatArray
from gazechair.sensing.inbox.pieces import Piece

_PER_TURN = 720  # points a turn, at most: neighbours are averaged to about as many
_NEAREST_M = 0.15
_FARTHEST_M = 17.5  # of the drive axle
_SPREAD_M = 0.06  # ranges to one surface differ less
_NEIGHBOUR_M = 0.35  # points farther apart are not on one surface
_THIN_M = 0.05
_FLAT_M = 0.025  # beside the line through both neighbours: no corner
_LINE_M, _BEYOND = 0.05, 3.0  # off a line through neighbours; past its end, in its lengths

OLDER_S = 0.03
"""By this much a piece may be older than another lidar's; the chair's speed tells the motion."""
_SAME_S = 1e-4


def taken_for(pieces: MutableSequence[Piece], time_s: float) -> Piece | None:
    """The piece to which odometry's estimate at that time belongs, taken out of `pieces`."""
    older_s = [time_s - piece.middle_s for piece in pieces]
    near = [at for at, one_s in enumerate(older_s) if -_SAME_S < one_s < OLDER_S + _SAME_S]
    if not near:
        return None
    at = min(near, key=lambda at: older_s[at])
    found = pieces[at]
    del pieces[at]
    return found


def seen_points(
    piece: Piece, headings_rad: FloatArray, speed_m_s: float, sideways_m_s: float
) -> tuple[FloatArray, FloatArray]:
    """(points, normals towards the lidar), (N, 2) each, in the chair's frame at `piece.at_s`.

    `headings_rad`: the chair's heading at each measurement, relative to then.
    """
    usable = np.flatnonzero(piece.distances_m >= _NEAREST_M)
    group = max(1, piece.per_turn // _PER_TURN)
    usable = usable[: len(usable) // group * group]
    if not len(usable):
        return np.zeros((0, 2)), np.zeros((0, 2))
    ranges = piece.distances_m[usable].reshape(-1, group)
    middle = ranges[:, group // 2]
    near = np.abs(ranges - middle[:, None]) < _SPREAD_M
    distance = (ranges * near).sum(axis=1) / near.sum(axis=1)
    groups = usable.reshape(-1, group)
    at = groups[:, group // 2]
    aside = half_turn_deg(piece.directions_deg[groups] - piece.directions_deg[at][:, None])
    direction = piece.directions_deg[at] + (aside * near).sum(axis=1) / near.sum(axis=1)
    angle, turned = np.radians(direction), headings_rad[at]
    after_s = piece.times_s[at] - piece.at_s
    x = piece.origin_m[0] + distance * np.cos(angle)
    y = piece.origin_m[1] + distance * np.sin(angle)
    c, s = np.cos(turned), np.sin(turned)
    points = np.stack(
        (c * x - s * y + speed_m_s * after_s, s * x + c * y + sideways_m_s * after_s), 1
    )
    beams = np.stack((-np.cos(angle + turned), -np.sin(angle + turned)), axis=1)
    kept = np.hypot(points[:, 0], points[:, 1]) < _FARTHEST_M
    points, beams = _thinned(points[kept], beams[kept])
    return points, _normals(points, beams)


def _thinned(points: FloatArray, beams: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Consecutive points in the same small square become their mean."""
    if not len(points):
        return points, beams
    cells = np.floor(points * (1.0 / _THIN_M)).astype(np.int64)
    starts = np.flatnonzero(np.any(np.diff(cells, axis=0, prepend=cells[:1] - 1) != 0, axis=1))
    count = np.diff(starts, append=len(points))[:, None]
    return np.add.reduceat(points, starts) / count, np.add.reduceat(beams, starts) / count


def _normals(points: FloatArray, beams: FloatArray) -> FloatArray:
    """Normals of the surfaces, from neighbouring points; towards the lidar for single points."""
    normals = beams.copy()
    if len(points) < 3:
        return normals
    both = np.flatnonzero(between(points))
    along = points[both + 1] - points[both - 1]
    length = np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-9)
    normal = np.stack((-along[:, 1], along[:, 0]), axis=1) / length[:, None]
    away = (normal * beams[both]).sum(axis=1) < 0.0
    normal[away] = -normal[away]
    normals[both] = normal
    return normals


def on_flat(points: FloatArray) -> BoolArray:
    """(N,): which consecutive points are in line with both neighbours: their normals are exact."""
    flat = between(points)
    at = np.flatnonzero(flat)
    base, off = points[at + 1] - points[at - 1], points[at] - points[at - 1]
    length = np.maximum(np.hypot(*base.T), 1e-9)
    flat[at] = np.abs(base[:, 0] * off[:, 1] - base[:, 1] * off[:, 0]) < _FLAT_M * length
    return flat


def between(points: FloatArray) -> BoolArray:
    """(N,): which consecutive points have both neighbours nearby."""
    near = np.zeros(len(points) + 1, dtype=np.bool_)
    near[1:-1] = np.hypot(*np.diff(points, axis=0).T) < _NEIGHBOUR_M
    return near[1:] & near[:-1]


def stand_alone(points: FloatArray) -> BoolArray:
    """(N,): which consecutive points have no neighbour nearby, and are in no line with two others.

    Far along a corridor, few beams meet the wall: these points are apart, but in line.
    """
    alone = np.zeros(len(points), dtype=np.bool_)
    if len(points) < 5:
        return alone
    apart = np.hypot(*np.diff(points, axis=0).T) > _NEIGHBOUR_M
    at = np.flatnonzero((apart[:-1] & apart[1:])[1:-1]) + 2
    here, in_line = points[at], np.zeros(len(at), dtype=np.bool_)
    for first, second in ((-1, 1), (-2, -1), (2, 1)):
        start, base = points[at + first], points[at + second] - points[at + first]
        length = np.maximum(np.hypot(*base.T), 1e-9)
        off = here - start
        aside = np.abs(base[:, 0] * off[:, 1] - base[:, 1] * off[:, 0]) / length
        along = (base * off).sum(axis=1) / length**2
        in_line |= (aside < _LINE_M) & (along > 0.0) & (along < 1.0 + _BEYOND)
    alone[at[~in_line]] = True
    return alone
