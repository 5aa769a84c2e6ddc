"""The chair's outline on the floor, with margins: a polygon in the chair's frame."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray

Corner = tuple[float, float]

# The chair of the simulator, 0.75 m wide as fitted; drive axle at the origin, x forward, y left.
DEFAULT_CORNERS: tuple[Corner, ...] = (
    (0.65, 0.375),
    (-0.45, 0.375),
    (-0.45, -0.375),
    (0.65, -0.375),
)
MAX_CORNERS = 24
_MAX_M = 3.0
_LEAST_AREA_M2 = 0.05
_TOUCH_M = 1e-9


def why_not(corners: Sequence[Corner]) -> str:
    """Why `corners` cannot be an outline, as the text after "must"; "" if they can."""
    if not 3 <= len(corners) <= MAX_CORNERS:
        return f"have 3..{MAX_CORNERS} corners, not {len(corners)}"
    for x, y in corners:
        if not (math.isfinite(x) and math.isfinite(y) and max(abs(x), abs(y)) <= _MAX_M):
            return f"have corners within {_MAX_M:g} m of the drive axle, not [{x:g}, {y:g}]"
    polygon = np.array(corners, dtype=np.float64)
    if _crosses_itself(polygon):
        return "not cross or touch itself"
    if abs(_area_m2(polygon)) < _LEAST_AREA_M2:
        return f"cover at least {_LEAST_AREA_M2:g} m2"
    if not inside(polygon, np.zeros((1, 2)))[0]:
        return "enclose the drive axle at [0, 0]"
    return ""


@dataclass(frozen=True)
class Margins:
    """Distances added to the outline, in metres, each 0 or more."""

    front_m: float = 0.05
    side_m: float = 0.02
    rear_m: float = 0.05

    @property
    def widths_m(self) -> tuple[float, float, float]:
        """All three, in the order of the fields."""
        return (self.front_m, self.side_m, self.rear_m)


class Footprint:
    """Outline and margins. `body` is the bare polygon; the union of `parts` is the grown polygon.

    Grown = Minkowski sum with the box of the margins: a point in it is within the margin of the
    body, ahead, behind or at a side. A convex outline grows to one convex part; any other one to
    itself and one convex part for each side. Raises ValueError for a bad outline (see `why_not`).
    """

    def __init__(
        self, corners: Sequence[Corner] = DEFAULT_CORNERS, margins: Margins | None = None
    ) -> None:
        reason = why_not(corners)
        if reason:
            raise ValueError(f"the outline must {reason}")
        margins = margins or Margins()
        self.margins = margins
        polygon = np.array(corners, dtype=np.float64)
        if _area_m2(polygon) < 0.0:
            polygon = polygon[::-1].copy()
        self.body: FloatArray = polygon
        box = np.array(
            [
                (x, y)
                for x in (margins.front_m, -margins.rear_m)
                for y in (margins.side_m, -margins.side_m)
            ]
        )
        if _is_convex(polygon):
            self.parts: list[FloatArray] = [_hull(_sums(polygon, box))]
        else:
            ends = np.roll(polygon, -1, axis=0)
            sides = [np.array(side) for side in zip(polygon, ends, strict=True)]
            self.parts = [polygon, *(_hull(_sums(side, box)) for side in sides)]
        every = np.concatenate(self.parts)
        self.reach_m = float(np.hypot(every[:, 0], every[:, 1]).max())
        """The farthest that anything of the grown footprint is from the drive axle."""
        self.half_width_m = float(np.abs(every[:, 1]).max())

    def contains(self, points_m: FloatArray) -> BoolArray:
        """Which of the (N, 2) points are within the grown footprint."""
        found = inside(self.parts[0], points_m)
        for part in self.parts[1:]:
            found |= inside(part, points_m)
        return found


def inside(polygon: FloatArray, points_m: FloatArray) -> BoolArray:
    """Which of the (N, 2) points are within a simple polygon: even-odd rule."""
    x, y = points_m[:, 0], points_m[:, 1]
    found = np.zeros(len(points_m), dtype=np.bool_)
    for ax, ay, bx, by in _sides(polygon) if len(points_m) else ():
        if ay == by:
            continue
        between = (ay > y) != (by > y)
        found ^= between & (x < (bx - ax) * ((y - ay) / (by - ay)) + ax)
    return found


def distance_m(polygon: FloatArray, points_m: FloatArray) -> FloatArray:
    """Distance of each of the (N, 2) points to the polygon's outline, never negative."""
    nearest = np.full(len(points_m), np.inf)
    for ax, ay, bx, by in _sides(polygon):
        side_x, side_y = bx - ax, by - ay
        x, y = points_m[:, 0] - ax, points_m[:, 1] - ay
        share = (x * side_x + y * side_y) * (1.0 / (side_x * side_x + side_y * side_y))
        share = np.minimum(np.maximum(share, 0.0), 1.0)
        nearest = np.minimum(nearest, np.hypot(x - share * side_x, y - share * side_y))
    return nearest


def _sides(polygon: FloatArray) -> Iterator[tuple[float, float, float, float]]:
    # Plain numbers: numpy takes longer to roll an array than to test a point.
    corners = polygon.tolist()
    for (ax, ay), (bx, by) in zip(corners, [*corners[1:], corners[0]], strict=True):
        yield ax, ay, bx, by


def _area_m2(polygon: FloatArray) -> float:
    after = np.roll(polygon, -1, axis=0)
    return 0.5 * float((polygon[:, 0] * after[:, 1] - polygon[:, 1] * after[:, 0]).sum())


def _turns(polygon: FloatArray) -> FloatArray:
    side = np.roll(polygon, -1, axis=0) - polygon
    after = np.roll(side, -1, axis=0)
    return np.asarray(side[:, 0] * after[:, 1] - side[:, 1] * after[:, 0])


def _is_convex(polygon: FloatArray) -> bool:
    return bool((_turns(polygon) >= -_TOUCH_M).all())


def _sums(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray((a[:, None, :] + b[None, :, :]).reshape(-1, 2))


def _hull(points: FloatArray) -> FloatArray:
    # Andrew's monotone chain, counter-clockwise.
    ordered = sorted({(float(x), float(y)) for x, y in points})

    def chain(of: Sequence[Corner]) -> list[Corner]:
        found: list[Corner] = []
        for p in of:
            while len(found) >= 2 and _left(found[-2], found[-1], p) <= 1e-12:
                found.pop()
            found.append(p)
        return found[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1]))


def _left(a: Corner, b: Corner, c: Corner) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _crosses_itself(polygon: FloatArray) -> bool:
    corners = [(float(x), float(y)) for x, y in polygon]
    count = len(corners)
    sides = [(corners[i], corners[(i + 1) % count]) for i in range(count)]
    for i, (a, b) in enumerate(sides):
        if math.dist(a, b) < 1e-6:
            return True
        for j in range(i + 1, count):
            c, d = sides[j]
            if j == i + 1 or (i == 0 and j == count - 1):
                # Neighbours share a corner; folded back upon each other they have no inside.
                shared, p, q = (b, a, d) if j == i + 1 else (a, b, c)
                along = (p[0] - shared[0]) * (q[0] - shared[0])
                along += (p[1] - shared[1]) * (q[1] - shared[1])
                if abs(_left(shared, p, q)) < 1e-12 and along > 0.0:
                    return True
            elif _meet(a, b, c, d):
                return True
    return False


def _meet(a: Corner, b: Corner, c: Corner, d: Corner) -> bool:
    for ends, others in (((a, b), (c, d)), ((c, d), (a, b))):
        for p in others:
            box = all(
                min(e[k] for e in ends) - _TOUCH_M <= p[k] <= max(e[k] for e in ends) + _TOUCH_M
                for k in (0, 1)
            )
            if box and abs(_left(*ends, p)) < 1e-12:
                return True
    return _left(a, b, c) * _left(a, b, d) < 0.0 and _left(c, d, a) * _left(c, d, b) < 0.0
