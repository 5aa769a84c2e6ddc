"""Fast ray casting: only pairs of beam and segment that can meet; exact, for moving origins too."""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import FloatArray, IntArray

NOTHING = -1


def cast(
    x_m: FloatArray,
    y_m: FloatArray,
    angles_rad: FloatArray,
    segments: FloatArray,
    farthest_m: float = math.inf,
) -> tuple[FloatArray, IntArray]:
    """Each beam's distance in m to the nearest segment, inf for none, and that segment's index.

    `x_m`, `y_m`: where each beam begins, close together. `angles_rad`: ascending, within one turn.
    `segments`: rows x1, y1, x2, y2.
    """
    count = len(angles_rad)
    nearest, which = np.full(count, np.inf), np.full(count, NOTHING, dtype=np.int64)
    if not count or not len(segments):
        return nearest, which
    beam, segment = _pairs(x_m, y_m, angles_rad, segments, farthest_m)
    dx, dy = np.cos(angles_rad)[beam], np.sin(angles_rad)[beam]
    x1, y1, x2, y2 = segments[segment].T
    ax, ay = x1 - x_m[beam], y1 - y_m[beam]
    ex, ey = x2 - x1, y2 - y1
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        inverse = 1.0 / (dx * ey - dy * ex)
        along = (ax * ey - ay * ex) * inverse
        share = (ax * dy - ay * dx) * inverse
        hit = (along > 0.0) & (along <= farthest_m) & (share >= 0.0) & (share <= 1.0)
    beam, segment, along = beam[hit], segment[hit], along[hit]
    np.minimum.at(nearest, beam, along)
    first = along == nearest[beam]
    which[beam[first]] = segment[first]
    return nearest, which


def _pairs(
    x_m: FloatArray,
    y_m: FloatArray,
    angles_rad: FloatArray,
    segments: FloatArray,
    farthest_m: float,
) -> tuple[IntArray, IntArray]:
    """Every (beam, segment) that can meet, seen from the middle of all origins."""
    middle = np.array((x_m.mean(), y_m.mean()))
    apart_m = float(np.hypot(x_m - middle[0], y_m - middle[1]).max()) + 1e-9
    ends = segments.reshape(-1, 2, 2) - middle
    along = ends[:, 1] - ends[:, 0]
    squared = np.maximum((along**2).sum(axis=1), 1e-18)
    share = np.clip(-(ends[:, 0] * along).sum(axis=1) / squared, 0.0, 1.0)
    distance = np.hypot(*(ends[:, 0] + share[:, None] * along).T)
    chosen = np.flatnonzero(distance <= farthest_m + apart_m)
    distance, ends = distance[chosen], ends[chosen]
    bearing = np.arctan2(ends[:, :, 1], ends[:, :, 0])
    width = (bearing[:, 1] - bearing[:, 0] + math.pi) % (2.0 * math.pi) - math.pi
    low = np.where(width >= 0.0, bearing[:, 0], bearing[:, 1])
    # The origins are not quite in the middle: the nearer the segment, the wider it may look.
    spare = np.where(
        distance > 1.5 * apart_m,
        np.arcsin(np.minimum(apart_m / np.maximum(distance, 1e-12), 1.0)),
        math.pi,
    )
    spare = np.minimum(2.0 * spare + 1e-9, math.pi)
    width = np.minimum(np.abs(width) + 2.0 * spare, 2.0 * math.pi)
    first_rad = angles_rad[0]
    low = (low - spare - first_rad) % (2.0 * math.pi) + first_rad
    twice = np.concatenate((angles_rad, angles_rad + 2.0 * math.pi))
    begin = np.searchsorted(twice, low)
    length = np.searchsorted(twice, low + width, side="right") - begin
    total = int(length.sum())
    segment = np.repeat(chosen, length)
    skipped = np.cumsum(length) - length
    beam = np.arange(total) - np.repeat(skipped - begin, length)
    return beam % len(angles_rad), segment


def cast_discs(
    x_m: FloatArray, y_m: FloatArray, angles_rad: FloatArray, discs: FloatArray
) -> FloatArray:
    """Each beam's distance to the nearest of `discs`, rows x, y, radius; inf for none."""
    dx, dy = np.cos(angles_rad), np.sin(angles_rad)
    nearest = np.full(len(angles_rad), np.inf)
    for cx, cy, radius in discs:
        middle = dx * (cx - x_m) + dy * (cy - y_m)
        inside = radius**2 - ((cx - x_m) ** 2 + (cy - y_m) ** 2 - middle**2)
        near = middle - np.sqrt(np.maximum(inside, 0.0))
        hit = (inside >= 0.0) & (middle > 0.0)
        nearest = np.where(hit, np.minimum(nearest, np.maximum(near, 0.0)), nearest)
    return nearest
