"""Follower: converts the planned path and the pose into a stick position every 50 ms.

Legs are driven straight; errors are corrected where there is room on both sides, and where it is
narrow the stick points straight ahead, so that the board holds the heading. Turns on the spot end
when the model of the chair (dead time, ramps, lag) predicts that it coasts to the target.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.going.bends import RATE_RAD_S, Bend
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.pace import PERIOD_S, Pace
from gazechair.going.path import NO_AIM_M, NO_LEG_M, on_leg
from gazechair.going.plan import ARRIVED_M, Path, Pose
from gazechair.going.rolled import along
from gazechair.going.rolls_into import Rolling
from gazechair.going.spot_turn import SpotTurn
from gazechair.going.steering import MISS_M, NARROW_M, STEER_MOST_RAD, TURNS_DEG_S, Steering, miss_m

_TURNED_RAD, _ARRIVED_RAD = math.radians(0.8), math.radians(1.8)  # before a leg, and at the goal
_ROUGHLY_RAD = math.radians(3.0)  # where there is room to steer
_TURN_AGAIN_RAD = math.radians(20.0)
_SHORT_M = 0.3  # a leg may end this much early, but at most by half of it
_OFF_M = 0.30  # farther from its leg, a new plan is needed
_JAMS_M, _BETTER_M = 0.035, 0.01  # less clearance straight ahead, and more along the leg: re-aim
_AIM_LEFT_M, _AIM_AGAIN_M = 0.5, 0.5
_WIDE_M = 0.30  # clearance that permits less exact turns
_RUNS_OUT_RAD = math.radians(5.0)
_STEERS_RAD = math.radians(12.0)
_OF_LET = 0.85
_SOONER_M = 0.01  # a bend into a path begins this much sooner: its turn is requested at once
_NO_BEND_S = 0.6  # a bend requested in vain for this long is given up
_SHARP_RAD, _SHARP_M_S = math.radians(8.0), 0.22
_STANDS_M_S, _ROLLS_M_S = 0.06, 0.12  # slower: request the turn, which begins after the dead time
_ENDS_DEG_S = 5.0  # with a slower turn, it may begin a leg
_END_M, _END_WIDE_M = 0.02, 0.06


@dataclass(frozen=True)
class Stick:
    """Both axes, permille; forward and left positive."""

    linear_permille: int = 0
    turn_permille: int = 0


STOP = Stick()


class Follower:
    """Follows one path at a time; call `moved`, then `step`, in each period."""

    def __init__(self, numbers: ChairNumbers) -> None:
        self._numbers = numbers
        self._linear = numbers.linear_axis()
        self._turn = numbers.turn_axis()
        self._path: Path | None = None
        self._at = 0
        """Index of the leg that is driven, or turned to."""
        self._turning, self._turns_rolling = True, False
        self._steering = Steering(numbers, self._turn)
        self._let_deg_s = numbers.most_deg_s
        """Turn rate of the output that the board gave in the last turn on the spot."""
        self._straight_m = math.inf
        self._unbent = 0
        """Vertex at which the board refused the curve."""
        self._vain_s = 0.0
        """How long a curve has been requested without any output."""
        self.undriven_s = math.inf
        """Seconds since the board last put out any speed."""
        self._aimed_m: float | None = None
        """Distance along the leg at which the chair last aimed at a point ahead."""
        self._pace = Pace(numbers)
        self._spot = SpotTurn(self._turn, numbers.spot_permille, PERIOD_S)
        self._last_stick = STOP
        self.turns_on_spot = False
        self.lost_path = False
        """Too far from the path: a new plan is needed."""
        self.arrived = False

    @property
    def leg(self) -> int:
        """The present leg's index."""
        return self._at

    @property
    def backward(self) -> bool:
        """Whether the present leg is driven backward."""
        return self._path is not None and self._path.backward and self._at == 0

    def take(
        self, path: Path, pose: Pose, steers: bool = False, turns_rolling: bool = False
    ) -> None:
        """Follow a new path from `pose`, without stopping if it leads straight on.

        `steers`: nor if it begins some degrees aside, as there is room to steer into it.
        `turns_rolling`: there is room to turn to it while the chair still brakes.
        """
        aligned = self.leads_on(path, pose, steers)
        self._path, self._at, self._turning, self._unbent = path, 0, not aligned, 0
        self._turns_rolling = turns_rolling
        self.lost_path = self.arrived = False
        self._aimed_m = -math.inf  # at once, if need be
        self._spot.start()

    def leads_on(self, path: Path, pose: Pose, steers: bool) -> bool:
        """Whether a path begins so nearly straight on that no turn comes first; see `take`."""
        a, b = path.points_m[:2]
        off = math.remainder(math.atan2(b[1] - a[1], b[0] - a[0]) - pose[2], 2.0 * math.pi)
        aligned = abs(off) < (_STEERS_RAD if steers else _RUNS_OUT_RAD) and not path.backward
        return aligned and self._linear.speed > -_STANDS_M_S

    def rolling(self, pose: Pose) -> Rolling | None:
        """How the chair rolls; None: so slowly, or backward, that it may as well stop."""
        m_s = max(self._linear.speed, self._linear.dead_way()[1])
        if m_s < _ROLLS_M_S:
            return None
        then, later_rad = self._then(pose)
        speed = max(m_s, self._pace.m_s)
        leads_m = max(0.0, self._pace.m_s * self._lead_s - _SOONER_M)
        begin = along((*then[:2], later_rad), leads_m, 0.0)
        turns = self._turn.speed if abs(self._turn.speed) >= TURNS_DEG_S else 0.0
        return Rolling(pose, begin, speed, turns, self._bends_rad_s, self._linear.runs(0.0, 0.0))

    def press(self) -> None:
        """Another press: that the board ends the output of the one before refuses nothing."""
        self._last_stick = STOP

    def rests(self, pose: Pose) -> Pose:
        """Where the chair comes to rest if it is released now."""
        return along(pose, self._linear.runs(0.0, 0.0), math.radians(self._turn.runs(0.0, 0.0)))

    def drop(self) -> None:
        """Drop the path."""
        self._path = None

    def moved(
        self, stick: Stick, speed_m_s: float | None, rate_deg_s: float | None, old_s: float = 0.0
    ) -> None:
        """What the board put out in the last period, and how the chair moved `old_s` ago."""
        self._linear.put_out(stick.linear_permille, PERIOD_S, speed_m_s, old_s)
        self.undriven_s = 0.0 if stick.linear_permille else self.undriven_s + PERIOD_S
        asked = self._last_stick
        curved = bool(asked.linear_permille and asked.turn_permille)
        self._steering.passed(PERIOD_S, curved and stick == STOP)
        self._vain_s = self._vain_s + PERIOD_S if curved and stick == STOP else 0.0
        if not stick.linear_permille:  # go on gently
            self._pace.held(self._linear.speed)
        self._turn.put_out(stick.turn_permille, PERIOD_S, rate_deg_s, old_s)
        self._spot.let_out(0 if stick.linear_permille else stick.turn_permille)
        if _on_spot(stick) and _on_spot(asked):
            self._let_deg_s = self._numbers.turned_deg_s(stick.turn_permille)

    def left_m(self, pose: Pose) -> float:
        """Remaining length of the path."""
        if self._path is None or self.arrived:
            return 0.0
        points = self._path.points_m
        after = points[self._at + 1 :]
        if not len(after):
            return 0.0
        gap = math.hypot(after[0][0] - pose[0], after[0][1] - pose[1])
        return gap + float(np.hypot(*np.diff(after, axis=0).T).sum())

    def step(
        self, pose: Pose, most_m_s: float, room_m: float, straight_m: float = math.inf
    ) -> Stick:
        """The stick for the next period.

        `most_m_s`: speed limit (people). `room_m`: least clearance here and along the next steps
        of the path; `straight_m`: the same, straight ahead.
        """
        self._straight_m = straight_m
        stick = STOP
        self.turns_on_spot = False
        if self._path is not None and not self.arrived:
            stick = (
                self._turn_on_spot(pose, room_m)
                if self._turning
                else self._drive(pose, most_m_s, room_m)
            )
        if not stick.linear_permille:
            self._pace.rest()
        self._last_stick = stick
        return stick

    # -- turns -------------------------------------------------------------------------------------

    def _target_rad(self, pose: Pose) -> float | None:
        """Heading to turn to before the current leg; None: no turn is needed."""
        assert self._path is not None
        points = self._path.points_m
        if self._at >= len(points) - 1:
            return self._path.heading_rad
        return self._path.aim_rad(self._at, pose)

    def _turn_on_spot(self, pose: Pose, room_m: float) -> Stick:
        assert self._path is not None
        last = self._at >= len(self._path.points_m) - 1
        rolls = _ROLLS_M_S if room_m > NARROW_M else _STANDS_M_S
        if abs(self._linear.speed) > rolls and not self._turns_rolling:
            return STOP
        target = self._target_rad(pose)
        if target is None:
            return self._turned(last)
        self.turns_on_spot = True
        within = _TURNED_RAD if room_m < NARROW_M else _ROUGHLY_RAD
        if last:
            within, room_m = _ARRIVED_RAD, 0.0
        if self._runs_out_near(pose, target, room_m, within):
            return self._turned(last)  # the rest is steered while driving
        output = self._spot.step(pose[2], target, within)
        if output is None:
            return self._turned(last)
        return Stick(0, output)

    def _runs_out_near(self, pose: Pose, target: float, room_m: float, within: float) -> bool:
        """Whether the chair, released now, comes to rest near enough to the target, and soon."""
        wide = room_m > _WIDE_M
        error = math.degrees(math.remainder(target - pose[2], 2.0 * math.pi))
        if abs(self._turn.speed) > (20.0 if wide else _ENDS_DEG_S) or abs(error) > 12.0:
            return False
        if self._spot.pulses and not wide:
            return False  # from rest: predicted less well
        off = abs(error - self._turn.runs(0.0, 0.0))
        return off < math.degrees(_RUNS_OUT_RAD if wide else within)

    def _turned(self, last: bool) -> Stick:
        if last:
            self.arrived = True
        else:
            self._turning = False
            self._steering.begin()
            self._aimed_m = None
        return STOP

    # -- legs --------------------------------------------------------------------------------------

    def _drive(self, pose: Pose, most_m_s: float, room_m: float) -> Stick:
        assert self._path is not None
        points = self._path.points_m
        backward = self.backward
        then, later_rad = self._then(pose)
        bend = self._path.bend(self._at + 1) if self._at + 1 != self._unbent else None
        a, b = points[self._at], points[self._at + 1]
        along_m, across, length = on_leg(a, b, then)
        left_m = length - along_m
        if bend is not None and self._vain_s >= _NO_BEND_S:
            self._vain_s = 0.0
            if bend.place(then[0], then[1])[0] > _TURN_AGAIN_RAD:
                return self._end_leg()
            self._unbent, bend = self._at + 1, None  # to the vertex, and turn there
        if bend is not None and left_m < bend.tangent_m:
            turned, off_m = bend.place(then[0], then[1])
            if bend.is_none or turned >= abs(bend.angle_rad):
                self._at += 1
                self._aimed_m = -math.inf
                return self._drive(pose, most_m_s, room_m)
            return self._round(bend, turned, off_m, later_rad, most_m_s)
        line = math.atan2(b[1] - a[1], b[0] - a[0]) + (math.pi if backward else 0.0)
        error = math.remainder(line - later_rad, 2.0 * math.pi)
        curve = 0.0
        if bend is not None:
            to_bend_m = left_m - bend.tangent_m
            most_m_s = min(most_m_s, self._pace.slows_m_s(to_bend_m, self._bent_m_s(bend)))
            left_m = to_bend_m + self._beyond_m(self._at + 1)
            if to_bend_m < self._pace.m_s * self._lead_s:
                curve = bend.curve_per_m
        elif length < NO_LEG_M or left_m < (_END_WIDE_M if room_m > _WIDE_M else _END_M):
            return self._end_leg()
        if abs(across) > _OFF_M:
            self.lost_path = True
            return STOP
        if abs(error) > _TURN_AGAIN_RAD + STEER_MOST_RAD:
            if left_m < NO_AIM_M:
                return self._end_leg()
            self._begin_turn()
            return STOP
        misses = self._misses(along_m, across, error, left_m)
        if misses and self._straight_m < min(_JAMS_M, room_m - _BETTER_M):
            self._begin_turn()
            return STOP
        if abs(error) > _SHARP_RAD:
            most_m_s = min(most_m_s, _SHARP_M_S)
        speed = self._pace.step(left_m, most_m_s)
        if curve:
            turn = self._steering.curved(speed * curve, across, error)
        else:
            turn = self._steering.straight(across, error, left_m, room_m, self._straight_m)
        linear = self._numbers.linear_permille(-speed if backward else speed)
        return Stick(linear, turn if linear else 0)

    def _round(
        self, bend: Bend, turned: float, across: float, later_rad: float, most_m_s: float
    ) -> Stick:
        """Along the arc of a bend."""
        if abs(across) > _OFF_M:
            self.lost_path = True
            return STOP
        side = math.copysign(1.0, bend.angle_rad)
        left_m = bend.length_m - bend.radius_m * turned
        lag_rad = self._pace.m_s * self._numbers.lag_s / bend.radius_m
        line = bend.begin_rad + side * min(abs(bend.angle_rad), turned + lag_rad)
        error = math.remainder(line - later_rad, 2.0 * math.pi)
        curve = bend.curve_per_m if left_m > self._pace.m_s * self._lead_s else 0.0
        beyond_m = self._beyond_m(self._at + 1) - bend.length_m
        speed = self._pace.step(left_m + beyond_m, min(most_m_s, self._bent_m_s(bend)))
        linear = self._numbers.linear_permille(speed)
        turn = self._steering.curved(speed * curve, across, error)
        return Stick(linear, turn if linear else 0)

    def _then(self, pose: Pose) -> tuple[Pose, float]:
        """The pose after the dead time, and the heading after the lag."""
        ahead_m, _ = self._linear.dead_way()
        turned_deg, rate = self._turn.dead_way()
        then = along(pose, ahead_m, math.radians(turned_deg))
        return then, then[2] + math.radians(rate) * self._numbers.lag_s

    @property
    def _lead_s(self) -> float:
        """Time before a bend at which its turn is requested: half the ramp, and the lag."""
        rate = math.degrees(RATE_RAD_S)
        return self._numbers.lag_s + 0.5 * rate / self._numbers.accelerate_deg_s2

    def _beyond_m(self, vertex: int) -> float:
        """Metres from the begin of the bend at `vertex` to where the chair stops."""
        assert self._path is not None
        total, bend = 0.0, self._path.bend(vertex)
        while bend is not None:
            a, b = self._path.points_m[vertex : vertex + 2]
            after = self._path.bend(vertex + 1)
            total += bend.length_m + float(np.hypot(*(b - a))) - bend.tangent_m
            total -= 0.0 if after is None else after.tangent_m
            vertex, bend = vertex + 1, after
        return total

    def _bent_m_s(self, bend: Bend) -> float:
        """Highest speed in a bend at which the board still allows its turn rate."""
        return bend.radius_m * self._bends_rad_s

    @property
    def _bends_rad_s(self) -> float:
        """Highest turn rate in a bend."""
        return min(RATE_RAD_S, _OF_LET * math.radians(self._let_deg_s))

    def _misses(self, along_m: float, across: float, error: float, left_m: float) -> bool:
        """Whether the chair, driving straight on, misses its leg by so much that it must re-aim."""
        if self._aimed_m is None:
            self._aimed_m = along_m
        if left_m < _AIM_LEFT_M or along_m - self._aimed_m < _AIM_AGAIN_M:
            return False
        return miss_m(across, error, left_m) > MISS_M

    def _end_leg(self) -> Stick:
        self._at += 1
        self._begin_turn()
        return STOP

    def early_turn_rad(self, pose: Pose) -> float | None:
        """Heading to turn to if the leg ends here; None: too far from its end."""
        if self._path is None or self._turning:
            return None
        points = self._path.points_m
        gap = math.hypot(points[self._at + 1][0] - pose[0], points[self._at + 1][1] - pose[1])
        if self._at >= len(points) - 2:
            heading = self._path.heading_rad
            return (pose[2] if heading is None else heading) if gap <= ARRIVED_M else None
        driven = math.hypot(points[self._at][0] - pose[0], points[self._at][1] - pose[1])
        x, y = points[self._at + 2]
        near = gap <= min(_SHORT_M, driven)
        return math.atan2(y - pose[1], x - pose[0]) if near else None

    def end_leg_early(self, pose: Pose) -> Path:
        """End the leg, as the board lets the chair go no farther; the next one begins here."""
        assert self._path is not None
        self._end_leg()
        self._path = self._path.begun_at(self._at, pose)
        return self._path

    def _begin_turn(self) -> None:
        self._turning, self._turns_rolling = True, False
        self._spot.start()


def _on_spot(stick: Stick) -> bool:
    return bool(stick.turn_permille and not stick.linear_permille)
