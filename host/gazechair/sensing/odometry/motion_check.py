"""Compares the measured motion with the board's outputs: moves without a command, stands on one.

Turning is judged by the heading sensor alone, unless the lidars contradict it: it needs no view.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from gazechair.sensing.odometry.resting import Resting
from gazechair.sensing.odometry.seen import DIFFERS_DEG, MOVES_DEG_S, MOVES_M_S, Outputs, Seen

_STANDS_M_S, _MOVED_M_S = 0.03, 0.075
_HEARD_S = 0.1  # longest age of the board's report
_STOPS_S, _STOPPED_S = 1.2, 2.5  # after these times most chairs, all chairs have stopped
# While something else is put out: against the drive output (on a ramp it rolls back a little as
# it starts), beside a turn on the spot (few chairs turn about the axle's very middle), and beside
# or against the turn output: the casters swing a chair by 15 degrees.
_AGAINST_M_S, _BESIDE_M_S, _SPINS_DEG_S = 0.1, 0.15, 20.0
_BEGINS = 0.6  # of these speeds, which it has had for a while when it reaches them
# A command that moves any chair in its slowest profile: its deadband and its stiction are less.
_DRIVE, _TURN = 600, 800
_SOME = 400  # moves most chairs, and is worth a word where it does not
_DEADBAND = 150
_EXPECTED_M_S = 0.08

_ROLLS, _TURNS, _TURNS_UNSEEN, _AGAINST, _SPINS, _CREEPS, _CREEPS_ROUND = range(7)
_STANDS, _STANDS_ON_SOME, _TURN_STANDS, _TURN_STANDS_ON_SOME, _BEGINS_AGAINST = range(7, 12)
_LASTS_S = {
    _ROLLS: 0.1,
    _TURNS: 0.1,
    _TURNS_UNSEEN: 0.25,  # a step of the sensor is over by then
    _BEGINS_AGAINST: 0.15,
    _AGAINST: 0.0,  # after that
    _SPINS: 0.45,  # casters are quicker
    _CREEPS: 0.1,
    _CREEPS_ROUND: 0.1,
    _STANDS: 0.1,
    _TURN_STANDS: 0.3,
    _STANDS_ON_SOME: 0.9,  # and it has been put out for 0.6 s
    _TURN_STANDS_ON_SOME: 0.9,
}
_PUSHED = frozenset((_ROLLS, _TURNS, _TURNS_UNSEEN, _SPINS, _CREEPS, _CREEPS_ROUND))
_STUCK = frozenset((_STANDS, _STANDS_ON_SOME, _TURN_STANDS, _TURN_STANDS_ON_SOME))
_BY_HEADING = frozenset(
    (_TURNS, _TURNS_UNSEEN, _SPINS, _CREEPS_ROUND, _TURN_STANDS, _TURN_STANDS_ON_SOME)
)


@dataclass(frozen=True)
class Checked:
    """What has lasted long enough."""

    pushed: bool
    """It moves or turns without a command, or against it."""
    stuck: bool
    """It stands on a command."""
    by_heading: bool
    """One of them is so by the heading sensor alone."""


class MotionCheck:
    """Feed it all that is seen."""

    def __init__(self) -> None:
        self._since_s: dict[int, float] = {}
        # Slowest since nothing is commanded, see _motion; and to each side, see _to_sides.
        self._least: tuple[float, ...] = (math.inf,) * 3
        self._least_to: tuple[float, ...] = (math.inf,) * 4
        self._resting = Resting()
        self._turned_at = _TURN  # the least turn output that has turned this chair

    def judge(self, seen: Seen, placed: bool, matched: bool) -> Checked:
        """Take in the newest; `placed`: the surfaces determine the position; `matched`: known."""
        outputs = seen.outputs
        if outputs is None:
            self.forget()
            self._least, self._least_to = (math.inf,) * 3, (math.inf,) * 4
            return Checked(False, False, False)
        self._note(seen, outputs)
        self._resting.take(seen, placed and matched, outputs.idle_s >= _STOPPED_S)
        now = set(self._moves(seen, outputs, matched))
        now.update(self._stands(seen, outputs, matched))
        self._since_s = {key: self._since_s.get(key, seen.time_s) for key in now}
        lasted = {key for key in now if seen.time_s - self._since_s[key] >= _LASTS_S[key]}
        pushed = bool(lasted & _PUSHED) or {_BEGINS_AGAINST, _AGAINST} <= lasted
        return Checked(pushed, bool(lasted & _STUCK), bool(lasted & _BY_HEADING))

    def forget(self) -> None:
        """Positions have nothing to do with those before."""
        self._since_s.clear()
        self._resting.forget()

    def _note(self, seen: Seen, outputs: Outputs) -> None:
        before = (math.inf,) * 3 if outputs.idle_s < _HEARD_S else self._least
        self._least = _least(before, _motion(seen))
        to = (
            math.inf if idle_s < _HEARD_S else least
            for idle_s, least in zip(_idle_to(outputs), self._least_to, strict=True)
        )
        self._least_to = _least(to, _to_sides(seen))
        drives = min(outputs.forward_s, outputs.backward_s) < _STOPS_S
        turns = abs(seen.yaw_rate_deg_s) > MOVES_DEG_S and outputs.turn * seen.yaw_rate_deg_s > 0.0
        if turns and not drives and _sure(seen):
            self._turned_at = min(self._turned_at, outputs.most_turn)

    def _moves(self, seen: Seen, outputs: Outputs, matched: bool) -> Iterator[int]:
        """The ways in which it moves without a command."""
        if outputs.idle_s >= _STOPS_S:  # after it should rest; or earlier, if it speeds up
            least = self._least if outputs.idle_s < _STOPPED_S else (0.0,) * 3
            speed, got_on, yaw = _motion(seen)
            faster = speed > least[0] + MOVES_M_S + seen.speed_sigma_m_s
            if matched and (faster or got_on > least[1] + _MOVED_M_S):
                yield _ROLLS
            if _sure(seen) and yaw > least[2] + MOVES_DEG_S:
                yield _TURNS_UNSEEN
                if matched:
                    yield _TURNS
        else:
            drives = min(outputs.forward_s, outputs.backward_s) < _STOPS_S
            most_m_s = _AGAINST_M_S if drives else _BESIDE_M_S
            forward, backward, left, right = (
                (speed - (least if idle_s < _STOPPED_S else 0.0)) / most
                if idle_s >= _STOPS_S
                else 0.0
                for idle_s, speed, least, most in zip(
                    _idle_to(outputs),
                    _to_sides(seen),
                    self._least_to,
                    (most_m_s, most_m_s, _SPINS_DEG_S, _SPINS_DEG_S),
                    strict=True,
                )
            )
            rolls, spins = max(forward, backward), max(left, right)
            if matched and rolls > _BEGINS:
                yield _BEGINS_AGAINST
            if matched and rolls > 1.0:
                yield _AGAINST
            if _sure(seen) and spins > 1.0:
                yield _SPINS
        if self._resting.creeps:
            yield _CREEPS
        if _sure(seen) and self._resting.creeps_round:
            yield _CREEPS_ROUND

    def _stands(self, seen: Seen, outputs: Outputs, matched: bool) -> Iterator[int]:
        """The ways in which it does not move on a command."""
        speed = min(abs(seen.speed_m_s), seen.got_on_m_s)
        if speed >= _STANDS_M_S:
            return
        turns = abs(seen.yaw_rate_deg_s) > MOVES_DEG_S  # of one moment, noise is enough for that
        forward_s, backward_s = outputs.forward_s, outputs.backward_s
        drive, turn = abs(outputs.drive), abs(outputs.turn)
        expected_m_s = seen.full_m_s * (drive - _DEADBAND) / (1000 - _DEADBAND)
        # A chair that reverses passes through standing.
        if matched and (backward_s if outputs.drive > 0 else forward_s) >= _STOPPED_S:
            if not turns and (drive >= _DRIVE or expected_m_s > _EXPECTED_M_S):
                yield _STANDS
            if drive >= _SOME and not self._resting.turns:
                yield _STANDS_ON_SOME
        if min(forward_s, backward_s) < _STOPS_S or not seen.heading_known or not _sure(seen):
            return
        if self._resting.turns:
            return  # slowly, but it does
        if turn >= self._turned_at and not turns:
            yield _TURN_STANDS
        if turn >= _SOME:
            yield _TURN_STANDS_ON_SOME


def _sure(seen: Seen) -> bool:
    """Whether the heading sensor is not contradicted by the lidars."""
    return abs(seen.heading_off_deg) <= DIFFERS_DEG


def _motion(seen: Seen) -> tuple[float, ...]:
    """Speeds: m/s as filtered, m/s by positions alone, degrees/s."""
    return abs(seen.speed_m_s), seen.got_on_m_s, abs(seen.yaw_rate_deg_s)


def _to_sides(seen: Seen) -> tuple[float, ...]:
    """Speeds forward, backward, left and right; 0 for the opposite."""
    speed, yaw = seen.ahead_m_s, seen.yaw_rate_deg_s
    return max(0.0, speed), max(0.0, -speed), max(0.0, yaw), max(0.0, -yaw)


def _idle_to(outputs: Outputs) -> tuple[float, ...]:
    return outputs.forward_s, outputs.backward_s, outputs.left_s, outputs.right_s


def _least(before: Iterable[float], now: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(map(min, before, now))
