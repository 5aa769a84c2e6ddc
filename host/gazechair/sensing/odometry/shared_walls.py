"""Compares two lidars by a straight wall that both see: it has one direction.

The angle between them shows while the chair stands, too, and in a bare corridor. The lines that
they see meet where the turned one is. In a wall that has a bend they meet at the bend, which stays
behind when the chair drives on. Rough walls, as a robot's map has them, show each lidar another
direction in each comparison: there only what exceeds that scatter counts. If one lidar sees a wall
turn at once, it may just have been bumped: that it agreed with others before tells nothing then.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from gazechair.base.angles import half_turn_rad
from gazechair.base.arrays import FloatArray
from gazechair.base.poses import compose
from gazechair.sensing.inbox.pieces import Piece

# One turn of every lidar is looked at in each interval: it costs a twentieth of a match.
_LOOK_S, _EVERY_S = 0.11, 0.5
_NEAR_M = 4.0  # of the lidar
_BINS, _NORMAL_RAD = 90, math.radians(14.0)  # of all directions; noise of a point's normal
_OFFSET_M = 0.08
_WITHIN_M = 0.12, 0.05, 0.035  # of the line, in the rounds of its fit
_FEWEST, _LONG_M, _ROUGH_M = 20, 1.2, 0.02
_SAME_RAD = math.radians(25.0)  # walls that differ by more are different ones
_SAME_M = 0.05  # from its line, measured by the lidar that is not turned
_SHARE, _COUNTS = 0.3, 3  # of the newest comparison in the average; so many tell something
# Of the newest in the scatter: a rough room is remembered longer; so many deviations count.
_SCATTER_SHARE, _SCATTERS = 0.1, 1.5
_APART_RAD = math.radians(1.5)  # more than what may be left between two of an accurate mounting
_MATCHED, _FITS = 0.4, 3  # share of a piece's points; pieces
_BESIDE = 0.7  # the cosine: a wall that the chair drives along
_STEADY_RAD = math.radians(0.6)  # noise; at a bend it changes
_KEPT_M = 4.0  # away without a comparison: they are not compared any more
_RECENT_S = 1.0  # until a lidar sees the same wall again: the chair has not gone far
# So far on, the lines still meet at the same place of the chair, but for a share of that.
_ONWARD_M, _STAYS = 0.6, 0.2


@dataclass(frozen=True)
class Compared:
    """What walls have shown lately."""

    agree: bool = False
    """No lidar is turned against another by more than may be left of an accurate mounting."""
    turned: int | None = None
    """The one that most likely is turned against another; None: none seems to be."""
    by_rad: float = 0.0
    """How far."""
    sure: bool = False
    """It is turned: no wall has a bend."""


NOT_COMPARED = Compared()


@dataclass(frozen=True)
class _Wall:
    """A straight surface that a lidar has seen, in odometry's frame."""

    time_s: float
    from_m: FloatArray
    """(2,), the lidar's place."""
    angle_rad: float
    normal: FloatArray
    """(2,), towards the lidar."""
    middle_m: FloatArray
    """(2,)."""

    def distance_m(self, place_m: FloatArray) -> float:
        """Of a place from its line."""
        return float((place_m - self.middle_m) @ self.normal)

    def differs_m(self, other: _Wall) -> float:
        """Distance of this lidar from this wall and from the other: of one line 0, if turned."""
        return abs(self.distance_m(self.from_m) - other.distance_m(self.from_m))

    def has_turned(self, before: _Wall) -> bool:
        """Whether it is what the same lidar saw before, at another angle."""
        turned_rad = abs(half_turn_rad(self.angle_rad - before.angle_rad))
        return _APART_RAD < turned_rad < _SAME_RAD and self.differs_m(before) < _SAME_M


@dataclass(frozen=True)
class _Since:
    """Two lidars begin to differ."""

    at_m: FloatArray
    """(2,), the chair's place."""
    meets_m: float
    """See _Pair."""
    normal: FloatArray
    """(2,), of the wall."""
    apart_rad: float


@dataclass
class _Pair:
    """Averages of the comparisons of two lidars, and since when they differ."""

    count: int = 0
    count_since: int = 0
    """Since one of them may have been bumped."""
    apart_rad: float = 0.0
    variance_rad2: float = 0.0
    """Of single comparisons, about the average before each."""
    differs_m: FloatArray = field(default_factory=lambda: np.zeros(2))
    """By lidar; see _Wall.differs_m."""
    at_m: FloatArray | None = None
    """(2,), the chair's place at the newest comparison; None: unrelated to places now."""
    meets_m: float = 0.0
    """Where the lines meet, ahead of the axle."""
    since: _Since | None = None
    """When they began to differ."""
    by_several: bool = False
    """Whether walls of different directions have shown the same since then."""
    fits: int = 0
    """Pieces of the turned one that fitted what the others have seen, turned back."""
    is_bend: bool = False
    """Whether one did not: it fits as it is."""

    @property
    def is_compared(self) -> bool:
        return self.count >= _COUNTS

    @property
    def agrees(self) -> bool:
        agrees = self.count_since >= _COUNTS and abs(self.apart_rad) <= _APART_RAD
        return agrees or (self.is_compared and self.is_bend)

    @property
    def is_apart(self) -> bool:
        beyond_rad = abs(self.apart_rad) - _APART_RAD
        return (
            self.is_compared
            and not self.is_bend
            and beyond_rad > _SCATTERS * math.sqrt(self.variance_rad2)
        )

    @property
    def is_sure(self) -> bool:
        """Whether a lidar is turned, and no wall has a bend where the chair is."""
        if self.by_several or self.fits >= _FITS:
            return True
        if self.since is None or self.at_m is None:
            return False
        onward_m = math.hypot(*(self.at_m - self.since.at_m))
        return onward_m >= _ONWARD_M and abs(self.meets_m - self.since.meets_m) < _STAYS * onward_m

    def take(self, first: _Wall, second: _Wall, pose: FloatArray) -> None:
        """Compare what both have seen, if it is one wall."""
        apart_rad = float(half_turn_rad(second.angle_rad - first.angle_rad))
        differs_m = np.array((first.differs_m(second), second.differs_m(first)))
        if abs(apart_rad) > _SAME_RAD or differs_m.min() > _SAME_M:
            return
        share = max(_SHARE, 1.0 / (self.count + 1))
        if self.count:
            of_newest = max(_SCATTER_SHARE, 1.0 / self.count)
            self.variance_rad2 += of_newest * (
                (apart_rad - self.apart_rad) ** 2 - self.variance_rad2
            )
        self.count, self.count_since, self.at_m = self.count + 1, self.count_since + 1, pose[:2]
        self.apart_rad += share * (apart_rad - self.apart_rad)
        self.differs_m += share * (differs_m - self.differs_m)
        hardly = abs(apart_rad) < 0.5 * _APART_RAD
        if hardly or (self.since and abs(apart_rad - self.since.apart_rad) > _STEADY_RAD):
            self.since, self.by_several, self.fits, self.is_bend = None, False, 0, False
        ahead = np.array((math.cos(pose[2]), math.sin(pose[2])))
        if not hardly and abs(first.normal @ ahead) < _BESIDE:
            # Along the first line, to where the second one's distance is 0.
            along = np.array((-first.normal[1], first.normal[0]))
            to_m = -second.distance_m(first.middle_m) / float(along @ second.normal)
            off_m = float((first.middle_m + to_m * along - pose[:2]) @ ahead) - self.meets_m
            self.meets_m += off_m * (1.0 if self.since is None else share)
            if self.since is None:
                self.since = _Since(pose[:2], self.meets_m, first.normal, apart_rad)
        if self.since is not None:
            self.by_several |= bool(abs(first.normal @ self.since.normal) < _BESIDE)


class SharedWalls:
    """Feed it the pieces of all lidars."""

    def __init__(self) -> None:
        self._look_s = -math.inf  # began
        self._walls: dict[int, list[_Wall]] = {}  # by lidar
        self._pairs: dict[tuple[int, int], _Pair] = {}
        self.compared = NOT_COMPARED
        """The result until now."""

    def forget(self) -> None:
        """Places before are unrelated to those that follow."""
        self._walls.clear()
        for pair in self._pairs.values():
            pair.at_m = pair.since = None

    def _result(self) -> Compared:
        pairs = [one for one in self._pairs.items() if one[1].is_compared]
        apart = [one for one in pairs if one[1].is_apart]
        if not apart:
            return Compared(agree=bool(pairs) and all(one.agrees for _, one in pairs))
        lidars, pair = max(apart, key=lambda one: abs(one[1].apart_rad))
        which = int(np.argmin(pair.differs_m))
        by_rad = pair.apart_rad if which else -pair.apart_rad
        return Compared(False, lidars[which], by_rad, any(one.is_sure for _, one in apart))

    def is_due(self, at_s: float) -> bool:
        """Whether a piece of that time is looked at."""
        if not 0.0 <= at_s - self._look_s < _EVERY_S:
            self._look_s = at_s
        return at_s - self._look_s < _LOOK_S

    def turned_back(self, off_rad: float, matched: float) -> None:
        """A piece of the turned one, turned back, was fitted to what the others have seen.

        `off_rad`: by the fit it is to be turned by as much more; `matched`: share of its points.
        """
        if matched < _MATCHED:
            return
        for pair in self._pairs.values():
            if pair.is_apart:
                fits = abs(off_rad) < 0.5 * abs(pair.apart_rad)
                pair.fits += fits
                pair.is_bend = not fits and not pair.is_sure
        self.compared = self._result()

    def take(self, piece: Piece, points: FloatArray, normals: FloatArray, pose: FloatArray) -> None:
        """Compare a piece; its points and normals are in the chair's frame, `pose` is that."""
        if self.is_due(piece.at_s):
            self._take(piece, points, normals, pose)
            self.compared = self._result()

    def _take(
        self, piece: Piece, points: FloatArray, normals: FloatArray, pose: FloatArray
    ) -> None:
        at_s, lidar, origin_m = piece.at_s, piece.lidar, piece.origin_m
        for lidars, pair in list(self._pairs.items()):
            if pair.at_m is None:
                pair.at_m = pose[:2]
            if math.hypot(*(pose[:2] - pair.at_m)) > _KEPT_M:
                del self._pairs[lidars]
        found = straight_wall(points, normals, origin_m)
        if found is None:
            return
        angle_rad = found[0] + float(pose[2])
        seen = _Wall(
            at_s,
            compose(pose, np.array((*origin_m, 0.0)))[:2],
            angle_rad,
            np.array((math.cos(angle_rad), math.sin(angle_rad))),
            compose(pose, np.array((*found[1], 0.0)))[:2],
        )
        recent = [one for one in self._walls.get(lidar, ()) if at_s - one.time_s < _RECENT_S]
        if any(seen.has_turned(before) for before in recent):
            self._bumped(lidar)
        for other, walls in self._walls.items():
            for wall in walls:
                if other != lidar and at_s - wall.time_s < _LOOK_S:
                    pair = self._pairs.setdefault((min(lidar, other), max(lidar, other)), _Pair())
                    pair.take(*((wall, seen) if other < lidar else (seen, wall)), pose)
        self._walls[lidar] = [*recent, seen]

    def _bumped(self, lidar: int) -> None:
        """Forget that it agrees with others."""
        for lidars, pair in self._pairs.items():
            if lidar in lidars:
                pair.count_since = 0


def straight_wall(
    points: FloatArray, normals: FloatArray, origin_m: tuple[float, float]
) -> tuple[float, FloatArray] | None:
    """(direction of the normal in radians, middle) of the longest straight wall; None: none.

    `points`, `normals`: of a piece, (N, 2) each; `origin_m`: of its lidar.
    """
    near = np.hypot(points[:, 0] - origin_m[0], points[:, 1] - origin_m[1]) < _NEAR_M
    points, normals = points[near], normals[near]
    if len(points) < _FEWEST:
        return None
    angles = np.arctan2(normals[:, 1], normals[:, 0])
    bins = ((angles + math.pi) * (_BINS / (2.0 * math.pi))).astype(np.int64) % _BINS
    counts = np.bincount(bins, minlength=_BINS)
    fullest = int(np.argmax(counts + np.roll(counts, -1)))
    angle = (fullest + 1.0) * (2.0 * math.pi / _BINS) - math.pi
    off = half_turn_rad(angles - angle)
    kept = np.abs(off) < _NORMAL_RAD
    points, angle = points[kept], angle + float(off[kept].mean())
    along = points @ (math.cos(angle), math.sin(angle))
    least_m = float(along.min())
    counts = np.bincount(((along - least_m) * (1.0 / _OFFSET_M)).astype(np.int64))
    counts = counts + np.append(counts[1:], 0)
    away = np.abs(along - least_m - (int(np.argmax(counts)) + 1.0) * _OFFSET_M)
    for within_m in _WITHIN_M:
        line = points[away < within_m]
        if len(line) < _FEWEST:
            return None
        middle = line.mean(axis=0)
        (xx, xy), (_, yy) = (line - middle).T @ (line - middle) / len(line)
        # The direction of least variance, on the lidar's side.
        least = 0.5 * math.atan2(2.0 * xy, xx - yy) + 0.5 * math.pi
        angle = least if math.cos(least - angle) > 0.0 else least + math.pi
        normal = np.array((math.cos(angle), math.sin(angle)))
        away = np.abs((points - middle) @ normal)
    ends = (line - middle) @ (-normal[1], normal[0])
    half, root = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
    if ends.max() - ends.min() < _LONG_M or half - root > _ROUGH_M**2:
        return None
    return half_turn_rad(angle), middle
