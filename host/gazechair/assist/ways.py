"""Chooses a free way about where the driver points: turn, drive, turn, drive straight on."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gazechair.assist.corridors import FARTHEST_M, Corridors
from gazechair.base.footprint import FloatArray, Footprint

_MOST_DEG = 40  # to each side of the present heading
FROM_WISH_RAD = math.radians(35.0)
"""The largest angle between a way and where the driver pointed."""
_ASIDE_M = 0.6
_SHIFTS_DEG = (3, 6, 12, 20, 30)  # of the first leg, to a corridor beside the present line
_HORIZON_M = 2.5
# Gaps beside the footprint, and the score of a metre with each.
_GAPS_M = (0.012, 0.024, 0.04, 0.08)
_TIGHT_GAPS_M = (0.004, 0.012, 0.024, 0.06)  # for a chair without side margin
_WORTH = (0.35, 0.3, 0.2, 0.15)
_SAFE = 1  # index of the gap with which a corridor needs no correction
_TURN, _TURN_BACK, _OFF_WISH = 0.5, 0.25, 0.7  # cost of a radian, metres
_SHIFT = 0.25  # cost of a metre aside, metres
_ELSEWHERE_RAD = math.radians(4.0)  # with straight on shut, a way begins at least this far off
_BETTER_M = 0.12  # a way must beat straight on by this much
_SAME_M = 0.2  # another way must beat the present one by this much
_SAME_FIRST_RAD, _SAME_THEN_RAD = math.radians(5.0), math.radians(5.0)
_TRIES = 12
_SURE_M = 2.0  # straight on free this far with a safe gap: nothing to correct
_OFF_RAD = math.radians(3.0)  # unless the driver points farther aside than this
_SHORTEST_M, _LEG_M, _LEAST_LEG_M = 0.15, 1.8, 0.3  # first leg: least, most; second: least
_STOPS_RAD = math.radians(6.0)  # overshoot of a turn on the spot, at most

_DIRECTIONS = np.radians(np.arange(-_MOST_DEG, _MOST_DEG + 1))
_OFFSETS_M = np.round(np.arange(-_ASIDE_M, _ASIDE_M + 0.005, 0.01), 2)
_FINE_RAD = np.radians(np.arange(-8, 9) * 0.25)
_FINE_GAPS_M = (0.002, 0.007, 0.012, 0.017, 0.022, 0.027, 0.04, 0.06)
_FINE_WORTH = (0.3, 0.3, 0.3, 0.3, 0.2, 0.2, 0.1, 0.1)
_FINE_COST = 1.0
_OWN = len(_OFFSETS_M) // 2
_AHEAD = _MOST_DEG


@dataclass(frozen=True)
class Way:
    """Turn to `first_rad`, drive `first_m`, turn to `then_rad`, drive on.

    Angles are relative to the present heading, left positive.
    """

    first_rad: float
    first_m: float
    then_rad: float
    straight_m: float
    """Free distance straight ahead."""


class Ways:
    """Chooses ways for one footprint."""

    def __init__(self, footprint: Footprint) -> None:
        every = np.concatenate(footprint.parts)
        self._footprint = footprint
        self._gaps_m = _GAPS_M if footprint.margins.side_m >= _GAPS_M[0] else _TIGHT_GAPS_M
        self._half_m = float(np.abs(every[:, 1]).max())
        self._front_m = float(every[:, 0].max())

    def straight_m(self, points_m: FloatArray) -> float:
        """Free distance straight ahead of the front, by the narrowest gap."""
        beside = np.abs(points_m[:, 1]) < self._half_m + self._gaps_m[0]
        ahead = points_m[beside & (points_m[:, 0] > 0.0), 0]
        return float(ahead.min(initial=FARTHEST_M)) - self._front_m

    def choose(
        self,
        points_m: FloatArray,
        wish_rad: float,
        before: Way | None,
        spot_deg: tuple[float, ...],
        shut: bool,
        share: float = 1.0,
    ) -> Way | None:
        """The best way; None: straight on is as good.

        `wish_rad`: where the driver points, relative to the present heading. `before`: the previous
        way, relative to the same. `spot_deg`: how far the chair may turn on the spot, left and
        right. `shut`: the board lets nothing begin straight ahead. `share` of the help, 0..1:
        scales FROM_WISH_RAD.
        """
        widest = self._half_m + self._gaps_m[-1]
        near = points_m[points_m[:, 0] > -0.3]
        corridors = Corridors(near, _DIRECTIONS, _ASIDE_M + widest + 0.02)
        free = [
            corridors.free_m(_OFFSETS_M, self._half_m + gap_m) - self._front_m
            for gap_m in self._gaps_m
        ]
        off_wish = np.abs(_DIRECTIONS - wish_rad)
        towards = np.cos(off_wish)
        from_wish_rad = share * FROM_WISH_RAD
        may_first = off_wish <= from_wish_rad
        straight_m = float(free[0][_AHEAD, _OWN])
        if shut:
            may_first &= np.abs(_DIRECTIONS) >= _ELSEWHERE_RAD
        elif min(free[_SAFE][_AHEAD, _OWN], straight_m) > _SURE_M and abs(wish_rad) < _OFF_RAD:
            return None
        left, right = (math.radians(max(4.0, deg - 8.0)) for deg in spot_deg)
        may_first &= (left > _DIRECTIONS) & (-right < _DIRECTIONS)
        worth = []
        alone = self._worth(free, np.zeros(()), towards[:, None])[:, _OWN]
        alone = alone - (_TURN * np.abs(_DIRECTIONS) + _OFF_WISH * off_wish)
        straight = float(alone[_AHEAD])
        straight = -1.0 if shut else straight
        alone = np.where(may_first, alone, -np.inf)
        if before is not None:
            same = np.abs(_DIRECTIONS - before.then_rad) < _SAME_THEN_RAD
            alone = alone + _SAME_M * (same & (before.first_m < _LEAST_LEG_M))
        worth.append((0, alone[:, None], np.zeros((len(_DIRECTIONS), 1))))
        count = len(_DIRECTIONS)
        for shift in _SHIFTS_DEG:
            sine, cosine = math.sin(math.radians(shift)), math.cos(math.radians(shift))
            for sign in (1, -1):
                offsets = _OFFSETS_M[_OWN + 1 :] if sign > 0 else _OFFSETS_M[:_OWN]
                columns = slice(_OWN + 1, None) if sign > 0 else slice(0, _OWN)
                first_m = np.abs(offsets) / sine
                at = np.arange(count) + sign * shift
                fits = (at >= 0) & (at < count)
                at = np.clip(at, 0, count - 1)
                gone = first_m * cosine
                score = self._worth([one[:, columns] for one in free], gone, towards[:, None])
                score += _WORTH_ALL * first_m * towards[at][:, None]
                score -= (
                    _TURN * np.abs(_DIRECTIONS[at])
                    + _TURN_BACK * math.radians(shift)
                    + _OFF_WISH * off_wish
                )[:, None] + _SHIFT * np.abs(offsets)
                possible = fits & may_first[at] & (off_wish <= from_wish_rad)
                possible = possible[:, None] & (first_m + 0.05 <= free[0][at, _OWN][:, None])
                possible &= (
                    (first_m >= _SHORTEST_M)
                    & (first_m <= _LEG_M)
                    & (free[0][:, columns] > gone + _LEAST_LEG_M)
                )
                if before is not None:
                    kept = same & (np.abs(_DIRECTIONS[at] - before.first_rad) < _SAME_FIRST_RAD)
                    score = score + _SAME_M * kept[:, None]
                score = np.where(possible, score, -np.inf)
                worth.append((sign * shift, score, np.broadcast_to(first_m, score.shape)))
        best = self._best(near, worth, straight + _BETTER_M, straight_m)
        if best is None or best.first_m > 0.0:
            return best
        return replace(best, **dict.fromkeys(("first_rad", "then_rad"), self._finer(near, best)))

    def _finer(self, near: FloatArray, way: Way) -> float:
        """The direction with the most room near that of a way with one leg."""
        directions = way.then_rad + _FINE_RAD
        corridors = Corridors(near, directions, self._half_m + _FINE_GAPS_M[-1] + 0.02)
        score = -_FINE_COST * np.abs(_FINE_RAD)
        for gap_m, weight in zip(_FINE_GAPS_M, _FINE_WORTH, strict=True):
            free = corridors.free_m(np.zeros(1), self._half_m + gap_m)[:, 0] - self._front_m
            score += weight * np.clip(free, 0.0, _HORIZON_M)
        return float(directions[int(score.argmax())])

    def _worth(self, free: list[FloatArray], gone: FloatArray, towards: FloatArray) -> FloatArray:
        total = np.zeros(())
        for one, weight in zip(free, _WORTH, strict=True):
            total = total + weight * np.clip(one - gone, 0.0, _HORIZON_M - gone) * towards
        return np.asarray(total)

    def _best(
        self,
        near: FloatArray,
        worth: list[tuple[int, FloatArray, FloatArray]],
        least: float,
        straight_m: float,
    ) -> Way | None:
        close = near[np.hypot(near[:, 0], near[:, 1]) < _HORIZON_M]
        best = [(float(score.max()), k) for k, (_, score, _) in enumerate(worth)]
        for _ in range(_TRIES):
            top, k = max(best)
            if top < least:
                return None
            shift, score, first_m = worth[k]
            row, column = np.unravel_index(int(score.argmax()), score.shape)
            then = float(_DIRECTIONS[row])
            first = then + math.radians(shift)
            go_m = float(first_m[row, column])
            if self._turns_there(close, first, then, go_m):
                return Way(first, go_m, then, straight_m)
            # Its neighbours fail for the same reason.
            score[max(0, row - 1) : row + 2, max(0, column - 3) : column + 4] = -np.inf
            best[k] = (float(score.max()), k)
        return None

    def _turns_there(self, points: FloatArray, first: float, then: float, go_m: float) -> bool:
        if first == then:
            return True
        x, y = points[:, 0] - go_m * math.cos(first), points[:, 1] - go_m * math.sin(first)
        beyond = then + math.copysign(_STOPS_RAD, then - first)
        for angle in np.linspace(first, beyond, 4):
            c, s = math.cos(angle), math.sin(angle)
            turned = np.stack((c * x + s * y, c * y - s * x), axis=1)
            if self._footprint.contains(turned).any():
                return False
        return True


_WORTH_ALL = sum(_WORTH)
