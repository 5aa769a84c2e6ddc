"""Who is followed: chosen by a look or by standing in front; in doubt, nobody.

It never switches silently to another person. A track that was seen at the same time as the person
cannot be the person. A track that appears while the person is hidden is accepted as the person only
if it appears soon, where and moving as expected, and nobody else could have come there; otherwise
the driver must choose again.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from gazechair.base.angles import half_turn_rad
from gazechair.base.arrays import FloatArray
from gazechair.following.legs import Cluster, continued
from gazechair.following.tracks import Track

HIDDEN_S = 0.25
"""After this long without legs that may be the person's, they count as hidden."""
LOST_S = 1.0
"""After this long without any that certainly are, the person must be chosen again."""
_FRONT_M = (0.8, 1.6)
_FRONT_RAD = math.radians(25.0)
_STANDS_M_S, _STANDS_S = 0.25, 2.0
_CHOOSING_S = 15.0
_LOOK_RAD, _LOOK_ALONE_RAD = math.radians(8.0), math.radians(16.0)
_LOOK_S, _LOOKED_S = 1.5, 0.6  # look; time in it: who only walks through is not meant
_LOOK_FAR_M = 4.5
_ALONE_M = 0.7
_TOUCH_M, _TOUCHES = 0.42, 2
_JUMP_M = 0.30
_STAYS_M, _PARTLY_M = 0.30, 0.15
_NEXT_M, _NEXT_S = 0.20, 0.15
_JOINS = 3  # scans
_BACK_M, _BACK_M_PER_S = 0.18, 0.25
_BACK_M_S = 0.5
_BACK_LOOKS, _BACK_S = 4, 0.5
_BACK_ALONE_M = 0.8
_REACH_M, _REACH_M_S = 0.4, 1.4
_REMEMBERED_S = 3.0


class State(Enum):
    """The state of following; `LOST` and `UNSURE` last until somebody is chosen."""

    NOBODY = "nobody"
    CHOOSING = "choosing"
    FOLLOWS = "follows"
    HIDDEN = "hidden"
    LOST = "person_lost"
    UNSURE = "person_unsure"


@dataclass(frozen=True)
class _Left:
    """Where and how somebody was last seen."""

    x_m: float
    y_m: float
    vx_m_s: float
    vy_m_s: float
    at_s: float

    @classmethod
    def of(cls, track: Track) -> _Left:
        return cls(track.x_m, track.y_m, track.vx_m_s, track.vy_m_s, track.seen_s)

    def to(self, x_m: float, y_m: float) -> float:
        return math.hypot(self.x_m - x_m, self.y_m - y_m)


class Person:
    """Chooses and keeps the person. `front_m`: from the drive axle to the chair's front."""

    def __init__(self, front_m: float, needs_steps: bool) -> None:
        self.state = State.NOBODY
        self.track: Track | None = None
        self._front_m = front_m
        self._needs_steps = needs_steps
        """Without a map, only a track that has walked is certainly a person."""
        self._bearing_rad: float | None = None
        self._until_s = 0.0
        self._since_s: dict[int, float] = {}
        """By track number: since when it has been where the chosen person should be, s."""
        self._last = _Left(0.0, 0.0, 0.0, 0.0, 0.0)
        self._touches = 0
        self._others: list[_Left] = []
        self._before: Sequence[Cluster] = ()
        self._own: list[Cluster] = []
        """Clusters of the last scan that are certainly the person's."""
        self._joining: list[Cluster] = []
        """A leg of the last scan that is perhaps their second one."""
        self._joined = 0
        """Scans that showed it beside the first one."""

    def continued(self, seen: Sequence[Cluster]) -> Sequence[Cluster]:
        """What of a scan is certainly the person's, because it was in the scan before."""
        mine = self._own if self.state is State.FOLLOWS else []
        self._own = continued(mine, self._before, seen)
        self._joining = continued(self._joining, self._before, seen)
        self._before = seen
        return self._own

    def choose(self, at_s: float, bearing_rad: float | None = None) -> None:
        """Choose who is at `bearing_rad` (chair's frame); None: who stands in front for 2 s."""
        self.stop()
        self.state, self._bearing_rad = State.CHOOSING, bearing_rad
        self._until_s = at_s + (_CHOOSING_S if bearing_rad is None else _LOOK_S)

    def stop(self) -> None:
        """Stop following."""
        self.state, self.track, self._since_s, self._touches = State.NOBODY, None, {}, 0

    def look(
        self, tracks: Sequence[Track], ended: Sequence[Track], pose: FloatArray, at_s: float
    ) -> Track | None:
        """Process a scan's tracks; returns a track to forget: the person's, once hidden."""
        self._others += [_Left.of(one) for one in ended if one is not self.track]
        self._others = [one for one in self._others if at_s - one.at_s < _REMEMBERED_S]
        if self.state is State.CHOOSING:
            self._choose(tracks, pose, at_s)
        elif self.state is State.FOLLOWS:
            return self._keep(tracks, at_s)
        elif self.state is State.HIDDEN:
            self._find(tracks, at_s)
        return None

    # -- choosing ----------------------------------------------------------------------------------

    def _choose(self, tracks: Sequence[Track], pose: FloatArray, at_s: float) -> None:
        people = [
            one
            for one in tracks
            if one.legs and (one.walked or (one.person_like and not self._needs_steps))
        ]
        if self._bearing_rad is None:
            self._in_front(tracks, people, pose, at_s)
        else:
            self._looked_at(tracks, people, pose, self._bearing_rad, at_s)
        if self.state is State.CHOOSING and at_s > self._until_s:
            self.stop()

    def _in_front(
        self,
        tracks: Sequence[Track],
        people: Sequence[Track],
        pose: FloatArray,
        at_s: float,
    ) -> None:
        def stands(one: Track) -> bool:
            ahead_m, bearing = _seen_from(pose, one)
            low, high = (self._front_m + limit for limit in _FRONT_M)
            here = low <= ahead_m <= high and abs(bearing) < _FRONT_RAD
            return here and one.speed_m_s < _STANDS_M_S

        self._hold([one for one in people if stands(one)], at_s)
        long = [one for one in people if self._held_s(one, at_s) >= _STANDS_S]
        if len(long) == 1 and _alone(long[0], tracks, _ALONE_M):
            self._take(long[0])
        elif long:
            self.state = State.UNSURE

    def _hold(self, there: Sequence[Track], at_s: float) -> None:
        self._since_s = {one.number: self._since_s.get(one.number, at_s) for one in there}

    def _held_s(self, one: Track, at_s: float) -> float:
        return at_s - self._since_s.get(one.number, at_s)

    def _looked_at(
        self,
        tracks: Sequence[Track],
        people: Sequence[Track],
        pose: FloatArray,
        bearing_rad: float,
        at_s: float,
    ) -> None:
        def meant(one: Track, within_rad: float) -> bool:
            far_m, bearing = _seen_from(pose, one)
            return far_m < _LOOK_FAR_M and abs(half_turn_rad(bearing - bearing_rad)) < within_rad

        found = [one for one in people if meant(one, _LOOK_RAD)]
        self._hold(found, at_s)
        if not found:
            return
        nearest = min(found, key=lambda one: _seen_from(pose, one)[0])
        # The person meant may be hardly visible now: standing with one leg behind the other, or
        # hidden, while somebody else walks past.
        others = [
            one
            for one in tracks
            if one is not nearest
            and (one.legs or one.walked or one.still)
            and meant(one, _LOOK_ALONE_RAD if one.walked else _LOOK_RAD)
        ]
        if others:
            self.state = State.UNSURE
        elif self._held_s(nearest, at_s) >= _LOOKED_S - 1e-6:
            self._take(nearest)

    def _take(self, track: Track) -> None:
        self.state, self.track, self._touches = State.FOLLOWS, track, 0
        self._last = _Left.of(track)
        self._own = track.legs
        self._joining, self._joined = [], 0

    # -- keeping -----------------------------------------------------------------------------------

    def _keep(self, tracks: Sequence[Track], at_s: float) -> Track | None:
        mine = self.track
        assert mine is not None
        if any(one is not mine and _touches(one, mine) for one in tracks):
            self._touches += 1
        else:
            self._touches = 0
        gone = mine not in tracks  # ended as a double, with the legs of its last scan
        self._own = [] if gone or mine.contested else self._certain_legs(mine, at_s)
        jumped = self.seen and mine.off_m > _JUMP_M
        if self._touches >= _TOUCHES or jumped:
            self.state, self.track = State.UNSURE, None
            return None
        if self.seen:
            self._last = _Left.of(mine)
        elif gone or at_s - self._last.at_s > (LOST_S if self._partly(mine, at_s) else HIDDEN_S):
            self.state, self.track = State.HIDDEN, None
            return mine
        return None

    def _certain_legs(self, mine: Track, at_s: float) -> list[Cluster]:
        """Its legs that are certainly the person's: by the scan before, or both together."""
        own = [leg for leg in mine.legs if leg in self._own]
        if not own:
            return mine.legs if self._again(mine, at_s) else []
        new = [leg for leg in mine.legs if leg not in own]
        again = any(leg in self._joining for leg in new)
        self._joining, self._joined = new, self._joined + 1 if again else 1
        return mine.legs if new and self._joined >= _JOINS else own

    def _again(self, mine: Track, at_s: float) -> bool:
        """True if it shows both legs where the person should be, though none was there before.

        One alone does not do: an edge or another's leg is easily taken for theirs.
        """
        both = len(mine.legs) > 1 or any(leg.wide for leg in mine.legs)
        alone = any(leg.alone for leg in mine.legs)
        within_m = _NEXT_M if at_s - self._last.at_s < _NEXT_S else _PARTLY_M
        return both and alone and self._off_m(*mine.at_m, at_s) < within_m

    def _partly(self, mine: Track, at_s: float) -> bool:
        """True if its legs, though not certainly the person's, are where the person should be."""
        if not mine.legs or mine.contested:
            return False
        stands = self._last.to(*mine.at_m) < _STAYS_M
        return stands or self._off_m(*mine.at_m, at_s) < _PARTLY_M

    @property
    def seen(self) -> bool:
        """True if the last scan showed the person with certainty: else the chair stands."""
        return bool(self._own)

    def _find(self, tracks: Sequence[Track], at_s: float) -> None:
        """Look for the hidden person where and as expected."""
        young = [one for one in tracks if one.born_s > self._last.at_s and self._expected(one)]
        ready = [one for one in young if one.looks >= _BACK_LOOKS and one.legs]
        for one in ready:
            if not one.person_like:
                continue
            slower = math.hypot(one.vx_m_s - self._last.vx_m_s, one.vy_m_s - self._last.vy_m_s)
            if slower > _BACK_M_S or not self._nobody_else(one, tracks):
                self.state = State.UNSURE
            else:
                self._take(one)
            return
        waits_s = LOST_S + (_BACK_S if young else 0.0)
        if at_s - self._last.at_s > waits_s:
            self.state = State.LOST

    def _expected(self, one: Track) -> bool:
        """True if it appeared soon enough where the person was expected."""
        return one.born_s - self._last.at_s <= LOST_S and self._there(*one.first_m, one.born_s)

    def _there(self, x_m: float, y_m: float, at_s: float) -> bool:
        """True if the person may be there at that time."""
        return self._off_m(x_m, y_m, at_s) < _BACK_M + _BACK_M_PER_S * (at_s - self._last.at_s)

    def _off_m(self, x_m: float, y_m: float, at_s: float) -> float:
        """Distance from where the person should be, by their last certain sight."""
        later_s = at_s - self._last.at_s
        x = self._last.x_m + self._last.vx_m_s * later_s
        y = self._last.y_m + self._last.vy_m_s * later_s
        return math.hypot(x_m - x, y_m - y)

    def _nobody_else(self, one: Track, tracks: Sequence[Track]) -> bool:
        """True if no other person is near or could have come there unseen."""
        if not _alone(one, tracks, _BACK_ALONE_M):
            return False
        unseen = [_Left.of(t) for t in tracks if t is not one and t.walked and not t.legs]
        return all(
            left.to(*one.first_m) > _REACH_M + _REACH_M_S * max(0.0, one.born_s - left.at_s)
            for left in (*self._others, *unseen)
        )


def _touches(one: Track, mine: Track) -> bool:
    """True if legs of `one` might belong to `mine`."""
    if one.walked and _near(one, mine, _TOUCH_M):
        return True
    near = any(mine.to(leg.x_m, leg.y_m) < _TOUCH_M for leg in one.legs)
    return near and not one.still


def _alone(one: Track, tracks: Sequence[Track], within_m: float) -> bool:
    return not any(t is not one and t.perhaps_person and _near(t, one, within_m) for t in tracks)


def _near(one: Track, other: Track, within_m: float) -> bool:
    return one.to(other.x_m, other.y_m) < within_m


def _seen_from(pose: FloatArray, one: Track) -> tuple[float, float]:
    """Distance from the drive axle, m, and bearing, radians."""
    dx, dy = one.x_m - pose[0], one.y_m - pose[1]
    return math.hypot(dx, dy), half_turn_rad(math.atan2(dy, dx) - pose[2])
