"""Assist: decides at 20 Hz how to drive, from the lidars' view and where the driver points."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from gazechair.assist.narrow import Narrow, narrow
from gazechair.assist.near_returns import NearReturns
from gazechair.assist.own_steering import OwnSteering
from gazechair.assist.permits import Permits
from gazechair.assist.ways import FROM_POINTED_RAD, Way, Ways
from gazechair.base.footprint import Footprint
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece

FULL = 1000
MOST_TURN = 600
"""The largest turn output that assist requests, permille."""
_COAST_S = 0.42  # dead time and lag: the chair keeps turning for this long
_DONE_DEG, _FINE_DEG = 0.4, 0.2
_SPOT_DEG, _LEAST_SPOT_DEG = 8.0, 2.0  # above: turn on the spot; below: drive on straight
_RESTS_DEG = 1.5  # at rest, a smaller error stays: the chair would swing to and fro
_SPOT_S = 5.0  # after this time, a turn on the spot of a chair that does not turn is given up
_EASIER_S, _EASIER_DEG_S = 1.5, 0.5  # after this time its tolerance grows at this rate
_RESTS_DEG_S = 1.0
_DEADBAND = 60  # permille; a little above an untuned chair's (deadband_permille)
_CURVE_PERMILLE_DEG, _CURVE_PERMILLE = 25.0, 300
_SPOT_PERMILLE_DEG, _SPOT_PERMILLE = 20.0, 400
_LEAST_CURVE, _LEAST_SPOT = 95, 180
_SLOW = 250
_FASTER = 100  # above the present output, in a curve: the board slows both axes alike
_STICKS_DEG_S = 2.0
_STILL_PERMILLE = 30  # not neutral, but moves no chair
_MORE_PERMILLE_S = 300.0  # added to a turn on the spot while the chair does not turn
_SHORTEST_LEG_M, _LONG_LEG_M = 0.1, 2.0
_SHORT_M, _ROLLS_M = 0.03, 0.13
_LEG_STOPS_M = 0.24  # a leg also ends this near an obstacle: the board would soon end the press
_FORGETS_S = 4.0  # time constant from where the driver pointed to the present heading
# What is not permitted for this long is given up for a while. A driver lets go after a second.
_STUCK_S, _GIVES_UP_S = 0.8, 3.0
_ANOTHER_S = 10.0  # not advised for so long, it is another press: their numbers return after 255
_GAP_S = 0.3  # not advised for so long, the chair is elsewhere: what was chosen before is void
# After a turn that the board refused, forward points aside: by how much, how soon, how long.
_REFUSED_DEG, _REFUSED_S, _REFUSED_FORGETS_S = 25.0, 5.0, 15.0
_OPENS_S = 0.5  # after a block ahead, until the board lets a standing chair begin
_PERSON_M = 0.45  # blocked although this much is free: because of a possible person
_MORE_M = 0.15  # so much more is free than reported: nearer, too, because of a possible person
_FREE_M, _BESIDE_DEG = 0.8, 20.0  # between posts: more than this ahead, less than this to turn
_ENTERS_M = 0.3  # between posts with a small aim error: no turn helps if more than this is free
_SHUT_M, _SHUT_S = 0.175, 0.8  # nearer, the board lets nothing begin; assumed for this long
_SWINGS = 2  # there it turns to and fro so often at most
# Narrow place: how far off its middle it stops to aim, how much farther on again, where last.
_MIDDLE_M, _AIMS_AGAIN_M, _LAST_AIM_M = 0.025, 0.15, 0.2
_NOISE_M, _LIDAR_M = 0.01, 0.022  # room beside the outline, and beside a lidar in front
_NEEDED_M = 1.2  # less than this free ahead: worth stopping to turn on the spot


@dataclass(frozen=True)
class Advice:
    """The output to request, permille; `linear_permille` never exceeds that of plain forward."""

    linear_permille: int
    turn_permille: int
    steers: bool
    """True if assist chose this motion; False for plain straight on, and while it `waits`."""
    waits: bool = False
    """True while it requests nothing because of a possible person."""


STRAIGHT_ON = Advice(FULL, 0, False)
NOTHING = Advice(0, 0, True)
"""Keeps the press alive."""
WAITS = Advice(0, 0, False, waits=True)
"""Keeps the press alive: a possible person may leave, or counts as furniture in time."""


@dataclass(frozen=True)
class _Leg:
    """The first leg of a way, once the chair has turned towards it."""

    ends_m: float
    """Free distance straight ahead at its end."""
    then_deg: float
    """Heading of the second leg, not wrapped."""


@dataclass
class _Spot:
    """A turn on the spot."""

    to_deg: float
    """Heading, not wrapped."""
    begun_s: float
    turned: bool = False
    """True once the chair has turned."""


@dataclass
class _Press:
    """One press of forward: where it points, what was chosen for it, what it waits for."""

    number: int
    last_s: float
    """When it was last advised."""
    pointed_deg: float = 0.0
    """Where the driver points: a heading, not wrapped."""
    forgets_s: float = _FORGETS_S
    way: Way | None = None
    chosen_deg: float = 0.0
    """The heading at which `way` was chosen."""
    spot: _Spot | None = None
    leg: _Leg | None = None
    turned_then: bool = False
    """True if the newest turn on the spot was the one after a leg."""
    aimed_m: float = math.inf
    """How far ahead a narrow place was when it was aimed at."""
    turned_s: float = -math.inf
    """When a turn on the spot last ended."""
    shut_s: float = -math.inf
    """When the board last let nothing begin straight ahead."""
    shut_side: int = 0
    swings: int = 0
    """Since then: the side to which it turned, 1 left, -1 right; how often it turned back."""
    waits_s: float = 0.0
    """For how long what it wants has not been permitted."""
    sticks_s: float = 0.0
    """For how long a chair that should turn on the spot has not turned."""


class Assist:
    """Assist of one chair. Feed it motions, lidar pieces and `permits`, then call `advise`."""

    def __init__(self, footprint: Footprint, lidars: int) -> None:
        self.permits = Permits()
        self._returns = NearReturns(lidars)
        self._ways = Ways(footprint)
        self._own = OwnSteering()
        self._press = _Press(0, 0.0)
        self._front_m = float(footprint.body[:, 0].max()) + footprint.margins.front_m
        need_m = footprint.half_width_m + _NOISE_M
        self._needs_m = need_m, need_m
        self._gave_up_s = 0.0
        self._straight_m = 0.0
        self._closed = self._person = False
        self._refused: tuple[int, float] | None = None  # turn that the board refused: side, time

    def motion(self, motion: Motion) -> None:
        """The board's newest heading and output."""
        if motion.heading_deg is None:  # the next heading may count from another zero
            self._press = _Press(0, motion.time_s)
            self._own.heading_lost()
        self._returns.motion(motion)
        self.permits.output(motion.time_s, motion.linear_permille or 0, motion.turn_permille or 0)

    def see(self, lidar: int, piece: Piece) -> None:
        """Half a turn of the lidar with that number."""
        self._returns.see(lidar, piece)
        x_m, y_m = piece.origin_m
        if x_m > 0.0:  # closer beside it than it can measure, an obstacle ends the press
            left_m, right_m = self._needs_m
            self._needs_m = max(left_m, y_m + _LIDAR_M), max(right_m, _LIDAR_M - y_m)

    def ready(self, now_s: float) -> bool:
        """True if it can advise: surroundings are known, and no lidar is blind ahead or aside."""
        return self.permits.seen and self._returns.points_m(now_s) is not None

    def driver_turns(self, side: int, now_s: float) -> None:
        """The driver holds a turn, `side` 1 left, -1 right. Call it repeatedly meanwhile."""
        heading = self._returns.heading_deg(now_s)
        if heading is None:
            self._refused = None
            return
        self._own.turns(heading, now_s)
        self._refused = None if self.permits.may_turn(side) else (side, now_s)

    def advise(self, press: int, now_s: float) -> Advice | None:
        """How to drive in this press of forward; None: surroundings unknown, drive as without."""
        advice = self._advise(press, now_s)
        if advice is None:
            return None
        if advice.steers:
            self._own.steered(now_s)
        most = self.permits.surprise_permille(self._straight_m)
        return replace(advice, linear_permille=min(most, advice.linear_permille))

    def _advise(self, press: int, now_s: float) -> Advice | None:
        points = self._returns.points_m(now_s)
        heading = self._returns.heading_deg(now_s)
        if points is None or heading is None or not self.permits.seen:
            return None
        before, gap_s = self._press, now_s - self._press.last_s
        if press != before.number or gap_s > _ANOTHER_S:
            aside_deg = self._aside_deg(now_s)
            forgets_s = _REFUSED_FORGETS_S if aside_deg else _FORGETS_S
            self._press = _Press(press, now_s, heading + aside_deg, forgets_s)
        elif gap_s > _GAP_S:
            self._press = _Press(press, now_s, before.pointed_deg, before.forgets_s)
        self._straight_m = self._ways.straight_m(points)
        dt_s, self._press.last_s = min(0.2, now_s - self._press.last_s), now_s
        self._press.pointed_deg += (
            (heading - self._press.pointed_deg) * dt_s / self._press.forgets_s
        )
        way = None if self._press.way is None else self._seen_from(heading)
        pointed_rad = math.radians(self._press.pointed_deg - heading)
        if self._press.spot is not None:
            advice = self._turn_on_the_spot(heading, now_s, dt_s)
            if advice is not None:
                return advice
            self._begin_leg()
        self._closed = now_s - self.permits.shut_s < _OPENS_S
        self._person = self._closed and self._straight_m > _PERSON_M
        shut = self.permits.forward_m < _SHUT_M and not self._person
        if not shut:
            self._press.shut_side = self._press.swings = 0
        turns_deg, share = self.permits.turns_deg, self._own.help(now_s)
        place = None if shut else narrow(points, self._front_m, self._needs_m)
        if place is not None and abs(place.aim_rad - pointed_rad) < share * FROM_POINTED_RAD:
            self._press.way = self._press.leg = None
            return self._thread(place, heading, now_s, dt_s)
        self._press.aimed_m = math.inf
        leg = self._on_leg(heading, now_s, dt_s)
        if leg is not None:
            return leg
        if shut and now_s > self._press.turned_s + _SHUT_S:
            self._press.shut_s = now_s
        shut = now_s - self._press.shut_s < _SHUT_S
        if self._person:
            way = None  # it led to that person
        self._press.way = self._ways.choose(points, pointed_rad, way, turns_deg, shut, share)
        self._press.chosen_deg = heading
        return self._drive(self._press.way, now_s, dt_s)

    def _aside_deg(self, now_s: float) -> float:
        # From the heading to where the driver points: to the side where the board refused a turn.
        if self._refused is None or now_s - self._refused[1] > _REFUSED_S:
            return 0.0
        return self._refused[0] * _REFUSED_DEG

    def _thread(self, place: Narrow, heading: float, now_s: float, dt_s: float) -> Advice:
        # Drive through its middle, and aim while rolling: no chair turns so little on the spot.
        aim_deg = math.degrees(place.aim_rad)
        error_deg = aim_deg - self._returns.rate_deg_s() * _COAST_S
        turn = _output(error_deg, _CURVE_PERMILLE_DEG, _LEAST_CURVE, _CURVE_PERMILLE)
        rolls = self._may_roll() and not self._person and self.permits.both(_SLOW, turn)
        if abs(error_deg) > _FINE_DEG and rolls:
            self._press.waits_s = self._press.sticks_s = 0.0
            return Advice(_SLOW, turn, True)
        aside_m = math.sin(place.aim_rad) * (self._front_m + place.ahead_m)
        aims = _LAST_AIM_M < place.ahead_m < self._press.aimed_m - _AIMS_AGAIN_M
        if aims and abs(aside_m) > _MIDDLE_M and self.permits.may_turn(1 if aside_m > 0.0 else -1):
            self._press.aimed_m = place.ahead_m
            self._press.spot = _Spot(heading + aim_deg, now_s)
            advice = self._turn_on_the_spot(heading, now_s, dt_s)
            if advice is not None:
                return advice
        return self._straight_on(dt_s)

    def _begin_leg(self) -> None:
        # After a turn on the spot, drive the leg it was made for, even if another looks better now.
        way, self._press.leg = self._press.way, None
        if way is not None and way.first_m > _SHORTEST_LEG_M and not self._press.turned_then:
            then_deg = self._press.chosen_deg + math.degrees(way.then_rad)
            self._press.leg = _Leg(self._straight_m - way.first_m, then_deg)

    def _on_leg(self, heading: float, now_s: float, dt_s: float) -> Advice | None:
        leg = self._press.leg
        if leg is None:
            return None
        if self._person:
            return WAITS
        left_m = self._straight_m - leg.ends_m
        if self.permits.forward_m >= _SHUT_M and _SHORT_M < left_m < _LONG_LEG_M:
            if left_m > self._short_m() and self.permits.forward_m > _LEG_STOPS_M:
                return replace(self._straight_on(dt_s), steers=True)
            self._press.turned_then = True
            self._press.spot = _Spot(leg.then_deg, now_s)
        self._press.leg = None
        turns = self._press.spot is not None
        return self._turn_on_the_spot(heading, now_s, dt_s) if turns else None

    def _seen_from(self, heading_deg: float) -> Way:
        # The previous way, relative to the present heading.
        assert self._press.way is not None
        turned = math.radians(heading_deg - self._press.chosen_deg)
        first, then = self._press.way.first_rad - turned, self._press.way.then_rad - turned
        return replace(self._press.way, first_rad=first, then_rad=then)

    def _drive(self, way: Way | None, now_s: float, dt_s: float) -> Advice:
        if way is None:
            return self._straight_on(dt_s)
        aim_deg = math.degrees(way.first_rad if way.first_m > self._short_m() else way.then_rad)
        error_deg = aim_deg - self._returns.rate_deg_s() * _COAST_S
        enters = abs(aim_deg) <= _SPOT_DEG and self.permits.forward_m > _ENTERS_M
        if (way.straight_m > _FREE_M or enters) and min(self.permits.turns_deg) < _BESIDE_DEG:
            return self._straight_on(dt_s)  # between posts
        ahead_m = min(way.straight_m, self.permits.forward_m)
        needed = ahead_m < _NEEDED_M and now_s > self._gave_up_s
        shut = now_s - self._press.shut_s < _SHUT_S
        if not shut and not (needed and abs(aim_deg) > _SPOT_DEG):
            advice = None if self._person else self._curve(error_deg)
            if advice is not None:
                return advice
            if not needed or abs(aim_deg) <= _LEAST_SPOT_DEG:
                return self._straight_on(dt_s)
        side = 1 if aim_deg > 0.0 else -1
        swings = self._press.swings + (side == -self._press.shut_side)
        if swings > _SWINGS or not self.permits.may_turn(side):
            return self._straight_on(dt_s)
        self._press.shut_side, self._press.swings = side, swings
        self._press.turned_then = False
        heading = self._press.chosen_deg
        self._press.spot = _Spot(heading + aim_deg, now_s)
        return self._turn_on_the_spot(heading, now_s, dt_s) or self._straight_on(dt_s)

    def _short_m(self) -> float:
        # A leg that the chair covers by coasting counts as done.
        return _SHORT_M + _ROLLS_M * self.permits.linear_now / FULL

    def _curve(self, error_deg: float) -> Advice | None:
        if abs(error_deg) <= _DONE_DEG or not self._may_roll():
            return None
        turn = _output(error_deg, _CURVE_PERMILLE_DEG, _LEAST_CURVE, _CURVE_PERMILLE)
        fast = min(FULL, max(_SLOW, self.permits.linear_now + _FASTER))
        least = round(math.copysign(_LEAST_CURVE, turn))
        for linear, some in ((fast, turn), (_SLOW, turn), (_SLOW, least)):
            if self.permits.both(linear, some):
                self._press.waits_s = self._press.sticks_s = 0.0
                return Advice(linear, some, True)
        return None

    def _may_roll(self) -> bool:
        # Just after a block ahead, the board does not let a standing chair begin.
        return not self._closed or self.permits.linear_permille > 0

    def _straight_on(self, dt_s: float) -> Advice:
        # Wait for a turn to end if the board might not permit it while driving.
        self._press.sticks_s = 0.0
        if self.permits.turned and not self.permits.both(FULL, 0):
            self._press.waits_s += dt_s
            if self._press.waits_s < _STUCK_S:
                return self._wait()
        elif self._person or (self._closed and self._straight_m > self.permits.forward_m + _MORE_M):
            return WAITS
        elif not self._may_roll() and self._press.waits_s < _STUCK_S:
            self._press.waits_s += dt_s
            return NOTHING
        else:
            self._press.waits_s = 0.0
        return STRAIGHT_ON

    def _wait(self) -> Advice:
        # A tiny turn instead of neutral, if permitted: where the board permits only creep, it ends
        # a press that requests nothing while the chair still rolls and turns. To the side to which
        # the chair turns, else to the one with more room.
        left_deg, right_deg = self.permits.turns_deg
        side = self.permits.turns_to or (1 if left_deg > right_deg else -1)
        for still in (side * _STILL_PERMILLE, -side * _STILL_PERMILLE):
            if self.permits.both(0, still):
                return Advice(0, still, True)
        return NOTHING

    def _turn_on_the_spot(self, heading: float, now_s: float, dt_s: float) -> Advice | None:
        """Go on with the turn that was begun; None: there, or no progress for too long."""
        spot = self._press.spot
        assert spot is not None
        rate_deg_s = self._returns.rate_deg_s()
        off_deg = spot.to_deg - heading
        error_deg = off_deg - rate_deg_s * _COAST_S
        turn = 0
        spot.turned |= abs(rate_deg_s) >= _STICKS_DEG_S
        ends = spot.turned and abs(off_deg) <= _RESTS_DEG and abs(rate_deg_s) < _RESTS_DEG_S
        long_s = max(0.0, now_s - spot.begun_s - _EASIER_S)
        over = now_s > spot.begun_s + _SPOT_S
        if over and abs(rate_deg_s) < _STICKS_DEG_S:
            self._press.spot = self._press.way = None  # nor the leg that the turn was made for
            self._press.turned_s, self._gave_up_s = now_s, now_s + _GIVES_UP_S
            return None
        if not ends and abs(error_deg) > _DONE_DEG + _EASIER_DEG_S * long_s:
            least = _LEAST_SPOT + round(_MORE_PERMILLE_S * self._press.sticks_s)
            turn = _output(error_deg, _SPOT_PERMILLE_DEG, least, max(least, _SPOT_PERMILLE))
        elif over or abs(rate_deg_s) < _RESTS_DEG_S:
            self._press.spot, self._press.turned_s = None, now_s
            return None
        if turn and not self.permits.both(0, turn):
            self._press.waits_s += 0.0 if self.permits.rolls else dt_s
            if self._press.waits_s < _STUCK_S:
                return self._wait()
            self._gave_up_s, self._press.spot = now_s + _GIVES_UP_S, None
            return None
        self._press.waits_s = 0.0
        self._press.sticks_s = (
            0.0 if abs(rate_deg_s) >= _STICKS_DEG_S else self._press.sticks_s + dt_s
        )
        return Advice(0, turn, True) if turn else self._wait()


def _output(error_deg: float, per_deg: float, least: int, most: int) -> int:
    size = min(MOST_TURN, most, max(least, _DEADBAND + round(per_deg * abs(error_deg))))
    return size if error_deg > 0.0 else -size
