"""Tracks of persons: each a Kalman filter of position and velocity, fed by one or two legs.

A leg belongs to one track only, the nearest. A track is contested in a scan if its leg might belong
to another track that has walked and has no leg in that scan.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from gazechair.following.legs import LEGS_APART_M, Cluster

_GATE_M = 0.34
_SECOND_GATE_M = 0.55
_ADOPTED_M, _ADOPTED_PAIR_M = 0.42, 0.22
_PAIR_M = 0.26  # from the middle of both legs to where the person is expected
_SURE_PAIR_M = 0.12  # the same, beside a leg that is certainly its own
_CONTEST_M = 0.12
_ACCELERATION_M_S2 = 1.3
_PAIR_SIGMA_M, _ONE_SIGMA_M, _WIDE_SIGMA_M = 0.06, 0.20, 0.09
_FIRST_SIGMA_M_S = 0.6
_FORGET_S, _FORGET_SHORT_S = 1.0, 0.3
_KNOWN_LOOKS = 5
_WALKED_M, _WALKED_AGAIN_M, _WALKED_SHAPES = 0.45, 0.30, 4
_STILL_LOOKS, _STILL_M_S = 8, 0.15
_SAME_M = 0.18
_LEFT_M, _LEFT_S = 0.7, 3.0
_MOST_TRACKS = 40
_FASTEST_M_S = 2.0


@dataclass(eq=False)
class Track:
    """A possible person, at the time of the last scan."""

    number: int
    x_m: float
    y_m: float
    born_s: float
    vx_m_s: float = 0.0
    vy_m_s: float = 0.0
    seen_s: float = 0.0
    looks: int = 1
    shapes: int = 0
    """Scans that showed two legs, or one wide object."""
    walked: bool = False
    contested: bool = False
    legs: list[Cluster] = field(default_factory=list)
    """Its legs in the last scan."""
    first_m: tuple[float, float] = (0.0, 0.0)
    """Where it appeared."""
    may_have_walked: bool = False
    """It appeared soon where one that had walked was last seen."""
    sure: bool = False
    """The first of its legs in the last scan is certainly one of its own."""
    off_m: float = 0.0
    """Distance between where its legs were last seen and where they were expected."""
    _from: tuple[float, float] = (0.0, 0.0)
    _at_s: float = 0.0
    _pp: float = _ONE_SIGMA_M**2
    _pv: float = 0.0
    _vv: float = _FIRST_SIGMA_M_S**2

    @property
    def speed_m_s(self) -> float:
        """Its speed."""
        return math.hypot(self.vx_m_s, self.vy_m_s)

    @property
    def person_like(self) -> bool:
        """True if it has looked like a person often enough, also by share."""
        return self.shapes >= _WALKED_SHAPES and 3 * self.shapes >= self.looks

    @property
    def perhaps_person(self) -> bool:
        """True if it ever looked like a person: since then one leg may hide the other."""
        return self.walked or self.shapes >= _WALKED_SHAPES

    @property
    def still(self) -> bool:
        """True for a thing that has stood for a while, or a person who has not walked yet."""
        return not self.walked and self.looks >= _STILL_LOOKS and self.speed_m_s < _STILL_M_S

    @property
    def at_m(self) -> tuple[float, float]:
        """The middle of its legs in the last scan, which showed some."""
        x = sum(leg.x_m for leg in self.legs) / len(self.legs)
        y = sum(leg.y_m for leg in self.legs) / len(self.legs)
        return x, y

    def to(self, x_m: float, y_m: float) -> float:
        """Distance to a point, m."""
        return math.hypot(self.x_m - x_m, self.y_m - y_m)

    def predict(self, at_s: float) -> None:
        """Predict its state at `at_s`; clears its legs."""
        dt = max(0.0, at_s - self._at_s)
        self._at_s = at_s
        self.x_m += self.vx_m_s * dt
        self.y_m += self.vy_m_s * dt
        q = _ACCELERATION_M_S2**2 * dt
        self._pp += 2.0 * dt * self._pv + dt * dt * self._vv + q * dt * dt / 3.0
        self._pv += dt * self._vv + 0.5 * q * dt
        self._vv += q
        self.legs, self.contested, self.sure = [], False, False

    def takes(self, leg: Cluster) -> bool:
        """Take `leg` if it may be one of its legs; True if taken."""
        if not self.legs:
            if self.to(leg.x_m, leg.y_m) > _GATE_M:
                return False
        elif not self._second(leg):
            return False
        self._add(leg)
        return True

    def _add(self, leg: Cluster) -> None:
        """Use `leg`; beside one that is certainly its own, only if it is as certain."""
        if self.sure:
            one = self.legs[0]
            middle_m = self.to(0.5 * (one.x_m + leg.x_m), 0.5 * (one.y_m + leg.y_m))
            if not (one.alone and leg.alone and middle_m < _SURE_PAIR_M):
                return
        self.legs.append(leg)

    def _second(self, leg: Cluster) -> bool:
        if len(self.legs) > 1 or leg.wide or self.legs[0].wide:
            return False
        one = self.legs[0]
        if math.hypot(one.x_m - leg.x_m, one.y_m - leg.y_m) > LEGS_APART_M:
            return False
        return self.to(0.5 * (one.x_m + leg.x_m), 0.5 * (one.y_m + leg.y_m)) < _PAIR_M

    def adopts(self, leg: Cluster) -> bool:
        """Take the leg of another track if it may be its second one; True if taken."""
        one = self.legs[0]
        if one.wide or leg.wide:
            return False
        if math.hypot(one.x_m - leg.x_m, one.y_m - leg.y_m) > _ADOPTED_M:
            return False
        if self.to(0.5 * (one.x_m + leg.x_m), 0.5 * (one.y_m + leg.y_m)) > _ADOPTED_PAIR_M:
            return False
        self._add(leg)
        return True

    def correct(self, at_s: float) -> None:
        """Correct its state by its legs in this scan."""
        x, y = self.at_m
        shape = _shape(self.legs)
        sigma = _ONE_SIGMA_M
        if shape:
            sigma = _WIDE_SIGMA_M if self.legs[0].wide else _PAIR_SIGMA_M
        total = self._pp + sigma**2
        gain, gain_v = self._pp / total, self._pv / total
        dx, dy = x - self.x_m, y - self.y_m
        self.off_m = math.hypot(dx, dy)
        self.x_m, self.y_m = self.x_m + gain * dx, self.y_m + gain * dy
        self.vx_m_s, self.vy_m_s = self.vx_m_s + gain_v * dx, self.vy_m_s + gain_v * dy
        if self.speed_m_s > _FASTEST_M_S:
            share = _FASTEST_M_S / self.speed_m_s
            self.vx_m_s, self.vy_m_s = self.vx_m_s * share, self.vy_m_s * share
        self._vv -= gain_v * self._pv
        self._pv *= 1.0 - gain
        self._pp *= 1.0 - gain
        self.seen_s = at_s
        self.looks += 1
        self.shapes += shape
        if self.looks == _KNOWN_LOOKS:
            self._from = (self.x_m, self.y_m)
        least_m = _WALKED_AGAIN_M if self.may_have_walked else _WALKED_M
        if self.looks > _KNOWN_LOOKS and self.person_like and self.to(*self._from) > least_m:
            self.walked = True


class Tracks:
    """All tracks. Legs and tracks are in one frame that does not move."""

    def __init__(self) -> None:
        self.all: list[Track] = []
        self.ended: list[Track] = []
        """Tracks that ended with the last scan."""
        self._left: list[Track] = []
        """Tracks that had walked and ended lately."""
        self._number = 0

    def look(
        self,
        legs: Sequence[Cluster],
        at_s: float,
        mine: Track | None = None,
        own: Sequence[Cluster] = (),
    ) -> None:
        """Process the legs of one scan. `own`: those that are certainly of the track `mine`."""
        for track in self.all:
            track.predict(at_s)
        free = self._assign(legs, mine, own)
        for track in self.all:
            if track.legs:
                track.correct(at_s)
        self._begin(free, at_s)
        self._end(at_s)

    def forget(self, track: Track) -> None:
        """End a track."""
        self.all = [one for one in self.all if one is not track]
        self._left.append(track)

    def _assign(
        self, legs: Sequence[Cluster], mine: Track | None, own: Sequence[Cluster]
    ) -> list[Cluster]:
        """Assign legs to tracks, the nearest first; returns the legs left over."""
        pairs = sorted(
            (track.to(leg.x_m, leg.y_m), number, k)
            for number, track in enumerate(self.all)
            for k, leg in enumerate(legs)
            if abs(track.x_m - leg.x_m) < _SECOND_GATE_M
            and abs(track.y_m - leg.y_m) < _SECOND_GATE_M
        )
        owner: dict[int, Track] = {}
        if mine:
            mine.legs = sorted(own, key=lambda leg: mine.to(leg.x_m, leg.y_m))[:2]
            mine.sure = bool(own)
            owner = {k: mine for k, leg in enumerate(legs) if leg in mine.legs}
        for _ in range(2):  # a second leg may lie nearer than the first one found
            for _, number, k in pairs:
                if k not in owner and self.all[number].takes(legs[k]):
                    owner[k] = self.all[number]
        for far_m, number, k in pairs:
            other = self.all[number]
            one = owner.get(k)
            if one is None or other.legs or not other.walked or far_m > _GATE_M:
                continue
            if far_m < one.to(legs[k].x_m, legs[k].y_m) + _CONTEST_M:
                one.contested = True
        self._join()
        return [leg for k, leg in enumerate(legs) if k not in owner]

    def _join(self) -> None:
        """Join a track that never was more than one leg to another with one leg beside it."""
        gone: list[Track] = []
        for track in self.all:
            for other in self.all:
                if other is track or other in gone or track in gone or other.shapes:
                    continue
                if len(track.legs) == len(other.legs) == 1 and track.adopts(other.legs[0]):
                    gone.append(other)
        self.all = [track for track in self.all if track not in gone]

    def _begin(self, free: list[Cluster], at_s: float) -> None:
        """Begin tracks for the legs left over, in pairs where possible."""
        while free and len(self.all) < _MOST_TRACKS:
            leg = free.pop(0)
            mine = [leg]
            near = [
                one
                for one in free
                if not (leg.wide or one.wide)
                and math.hypot(one.x_m - leg.x_m, one.y_m - leg.y_m) < LEGS_APART_M
            ]
            if near:
                mine.append(min(near, key=lambda o: math.hypot(o.x_m - leg.x_m, o.y_m - leg.y_m)))
                free.remove(mine[1])
            x = sum(one.x_m for one in mine) / len(mine)
            y = sum(one.y_m for one in mine) / len(mine)
            self._number += 1
            made = Track(self._number, x, y, at_s, seen_s=at_s, legs=mine)
            made.first_m, made._at_s = (x, y), at_s
            made.shapes = int(_shape(mine))
            made.may_have_walked = any(left.to(x, y) < _LEFT_M for left in self._left)
            self.all.append(made)

    def _end(self, at_s: float) -> None:
        """End tracks that were not seen for a while, and duplicates of older ones."""
        kept: list[Track] = []
        self.ended = []
        for track in self.all:
            for_s = _FORGET_S if track.walked else _FORGET_SHORT_S
            double = not track.walked and any(t.to(track.x_m, track.y_m) < _SAME_M for t in kept)
            if at_s - track.seen_s > for_s:
                self.ended.append(track)
            elif not double:
                kept.append(track)
        self.all = kept
        self._left += [track for track in self.ended if track.walked]
        self._left = [track for track in self._left if at_s - track.seen_s < _LEFT_S]


def _shape(legs: Sequence[Cluster]) -> bool:
    """True if they look like a person: two legs, or one wide object."""
    return legs[0].wide or (len(legs) > 1 and any(leg.whole for leg in legs))
