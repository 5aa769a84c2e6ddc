"""Chooses a free way about where the driver points: turn, drive, turn, drive straight on."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from gazechair.assist.corridors import FARTHEST_M, Corridors
from gazechair.base.arrays import BoolArray, FloatArray
from gazechair.base.footprint import Footprint

_MOST_DEG = 40  # to each side of the present heading
FROM_POINTED_RAD = math.radians(35.0)
"""The largest angle between a way and where the driver pointed."""
_ASIDE_M = 0.6
_SHIFTS_DEG = (3, 6, 12, 20, 30)  # of the first leg, to a corridor beside the present line
_HORIZON_M = 2.5
# Gaps beside the footprint, and the score of a metre with each.
_GAPS_M = (0.012, 0.024, 0.04, 0.08)
_TIGHT_GAPS_M = (0.004, 0.012, 0.024, 0.06)  # for a chair without side margin
_WORTH = (0.35, 0.3, 0.2, 0.15)
_WORTH_ALL = sum(_WORTH)
_SAFE = 1  # index of the gap with which a corridor needs no correction
_TURN, _OFF_POINTED = 0.5, 0.7  # cost of a radian, metres
# A turn after a leg of these lengths costs so much less; a nearer one is not put off for that.
_LATER_M, _LATER = (0.3, 1.0), (0.0, 0.25)
_ENDS_M, _ENDS = 0.7, 1.0  # cost of each metre less than this free in the last direction
# For a chair without side margin: both lead it off the line into narrow doors.
_TIGHT_LATER_M, _TIGHT_ENDS = (-1.0, 0.0), 0.0
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


class _Scored(NamedTuple):
    """Ways whose first leg is `shift_deg` aside of the second."""

    shift_deg: int
    score: FloatArray
    """(directions of the second leg, first legs), m; -inf: not possible."""
    first_m: FloatArray
    """(first legs,): their lengths."""


@dataclass(frozen=True)
class _Scores:
    """Scores ways, m: free floor, less the cost of turning and of leaving the driver's direction.

    Arrays are over _DIRECTIONS.
    """

    free_m: list[FloatArray]
    """For each gap: in each direction, at each of _OFFSETS_M aside."""
    off_pointed: FloatArray
    may: BoolArray
    """Whether it is near enough to where the driver points."""
    may_first: BoolArray
    """Whether the chair may also turn there first."""
    before: Way | None
    later_m: tuple[float, float]
    """See _LATER_M."""
    ends: float
    """See _ENDS."""

    def straight_on(self) -> float:
        """Of the present direction."""
        return float(self._alone()[_AHEAD])

    def one_leg(self) -> _Scored:
        """Ways that turn once."""
        score = np.where(self.may_first, self._alone(), -np.inf)
        if self.before is not None:
            score = score + _SAME_M * (self._as_before() & (self.before.first_m < _LEAST_LEG_M))
        return _Scored(0, score[:, None], np.zeros(1))

    def two_legs(self, shift_deg: int) -> _Scored:
        """Ways that turn by `shift_deg` more than the second leg's direction, drive, turn back."""
        columns = slice(_OWN + 1, None) if shift_deg > 0 else slice(0, _OWN)
        aside_m = np.abs(_OFFSETS_M[columns])
        shift = math.radians(abs(shift_deg))
        first_m = aside_m / math.sin(shift)
        gone_m = first_m * math.cos(shift)  # along the second leg
        first = np.arange(len(_DIRECTIONS)) + shift_deg
        there = (first >= 0) & (first < len(_DIRECTIONS))
        first = np.clip(first, 0, len(_DIRECTIONS) - 1)
        towards = np.cos(self.off_pointed)
        score = self._worth([one[:, columns] for one in self.free_m], gone_m)
        score += _WORTH_ALL * first_m * towards[first][:, None]
        score -= self._ends(self.free_m[0][:, columns] - gone_m)
        score -= (
            _TURN * np.abs(_DIRECTIONS[first]) + _TURN * shift + _OFF_POINTED * self.off_pointed
        )[:, None] + _SHIFT * aside_m
        score += shift * np.interp(first_m, self.later_m, _LATER)
        possible = (there & self.may_first[first] & self.may)[:, None]
        possible = possible & (first_m + 0.05 <= self.free_m[0][first, _OWN][:, None])
        possible &= (first_m >= _SHORTEST_M) & (first_m <= _LEG_M)
        possible &= self.free_m[0][:, columns] > gone_m + _LEAST_LEG_M
        if self.before is not None:
            off_first = np.abs(_DIRECTIONS[first] - self.before.first_rad)
            score = score + _SAME_M * (self._as_before() & (off_first < _SAME_FIRST_RAD))[:, None]
        return _Scored(shift_deg, np.where(possible, score, -np.inf), first_m)

    def _alone(self) -> FloatArray:
        score = self._worth([one[:, [_OWN]] for one in self.free_m], np.zeros(()))[:, 0]
        score -= self._ends(self.free_m[0][:, _OWN])
        return score - (_TURN * np.abs(_DIRECTIONS) + _OFF_POINTED * self.off_pointed)

    def _ends(self, free_m: FloatArray) -> FloatArray:
        # Cost of a way that ends soon.
        return np.asarray(self.ends * np.clip(_ENDS_M - free_m, 0.0, _ENDS_M))

    def _as_before(self) -> BoolArray:
        assert self.before is not None
        return np.abs(_DIRECTIONS - self.before.then_rad) < _SAME_THEN_RAD

    def _worth(self, free_m: list[FloatArray], gone_m: FloatArray) -> FloatArray:
        towards, total = np.cos(self.off_pointed)[:, None], np.zeros(())
        for one, weight in zip(free_m, _WORTH, strict=True):
            total = total + weight * np.clip(one - gone_m, 0.0, _HORIZON_M - gone_m) * towards
        return np.asarray(total)


class Ways:
    """Chooses ways for one footprint."""

    def __init__(self, footprint: Footprint) -> None:
        every = np.concatenate(footprint.parts)
        self._footprint = footprint
        tight = footprint.margins.side_m < _GAPS_M[0]
        self._gaps_m = _TIGHT_GAPS_M if tight else _GAPS_M
        self._later_m = _TIGHT_LATER_M if tight else _LATER_M
        self._ends = _TIGHT_ENDS if tight else _ENDS
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
        pointed_rad: float,
        before: Way | None,
        spot_deg: tuple[float, ...],
        shut: bool,
        share: float = 1.0,
    ) -> Way | None:
        """The best way; None: straight on is as good.

        `pointed_rad`: where the driver points, relative to the present heading. `before`: the
        previous way, relative to the same. `spot_deg`: how far the chair may turn on the spot, left
        and right. `shut`: the board lets nothing begin straight ahead. `share` of the help, 0..1:
        scales FROM_POINTED_RAD.
        """
        widest = self._half_m + self._gaps_m[-1]
        near = points_m[points_m[:, 0] > -0.3]
        corridors = Corridors(near, _DIRECTIONS, _ASIDE_M + widest + 0.02)
        free = [
            corridors.free_m(_OFFSETS_M, self._half_m + gap_m) - self._front_m
            for gap_m in self._gaps_m
        ]
        straight_m = float(free[0][_AHEAD, _OWN])
        surely_m = min(free[_SAFE][_AHEAD, _OWN], straight_m)
        if not shut and surely_m > _SURE_M and abs(pointed_rad) < _OFF_RAD:
            return None
        off_pointed = np.abs(_DIRECTIONS - pointed_rad)
        may = off_pointed <= share * FROM_POINTED_RAD
        left, right = (math.radians(max(4.0, deg - 8.0)) for deg in spot_deg)
        may_first = may & (left > _DIRECTIONS) & (-right < _DIRECTIONS)
        if shut:
            may_first &= np.abs(_DIRECTIONS) >= _ELSEWHERE_RAD
        costs = self._later_m, self._ends
        scores = _Scores(free, off_pointed, may, may_first, before, *costs)
        ways = [scores.one_leg()]
        ways += [scores.two_legs(sign * deg) for deg in _SHIFTS_DEG for sign in (1, -1)]
        straight = -1.0 if shut else scores.straight_on()
        best = self._best(near, ways, straight + _BETTER_M, straight_m)
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

    def _best(
        self,
        near: FloatArray,
        ways: list[_Scored],
        least: float,
        straight_m: float,
    ) -> Way | None:
        close = near[np.hypot(near[:, 0], near[:, 1]) < _HORIZON_M]
        best = [(float(some.score.max()), k) for k, some in enumerate(ways)]
        for _ in range(_TRIES):
            top, k = max(best)
            if top < least:
                return None
            shift_deg, score, first_m = ways[k]
            row, column = np.unravel_index(int(score.argmax()), score.shape)
            then = float(_DIRECTIONS[row])
            first = then + math.radians(shift_deg)
            go_m = float(first_m[column])
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
