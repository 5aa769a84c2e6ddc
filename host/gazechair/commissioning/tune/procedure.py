"""The sequence of tuning pulses: takes samples, gives the pulse wanted now. Pure: no clock, no I/O.

A probe in each direction, then pulses of several strengths in sweeps over some 30 degrees, so that
the casters swing to both sides and the chair returns to its start. Each waits for standstill.
"""

from __future__ import annotations

import numpy as np

from gazechair.board.state import BoardLimits
from gazechair.commissioning.tune import TuneError
from gazechair.commissioning.tune.model import angle_deg
from gazechair.commissioning.tune.numbers import TurnNumbers, scaled
from gazechair.commissioning.tune.recording import Pulse, Recording, Sample
from gazelink import codes

CUT_DEG = 22.0  # a pulse is cut short when the chair would coast further from the start than this
FAR_DEG = 45.0  # further away, tuning is given up
MOST_MS = 10_000  # all pulses together
PULSE_MS = (150, 1500)
# (deflection permille, left positive; target heading, degrees from the start)
_PROBES = ((600, 4), (-600, 0))
_SWEEPS = (
    *((1000, 16), (-1000, -16), (1000, 16), (-500, 0)),
    *((300, 8), (-300, -8), (-600, -16), (500, 0)),
)
PULSES = _PROBES + _SWEEPS
_QUIET_MS = 400
_QUIET_DEG = 0.2
_NOISE_DEG = 0.5
_STARTS_MS = 500
_RESTS_MS = (900, 4000)  # after a pulse, at least and at most
_SAMPLE_MS = 10
_TICKS_MS = 2  # tolerance of the board's clock in a pulse
_COUNTS = 2  # tolerance of the wiper
_GAP_MS = 40  # samples further apart leave it open when the wiper moved
_RATE_SAMPLES = 8
_REPEATS = 3
_ANSWERS = 5  # after this many pulses a chair must have turned
_MOVED_DEG = 2.0
_REVERSED = 0.5  # share of the expected turn, in the opposite direction
_LOOSE = 1.4  # factor above the expected speed, to break a standing chair loose
_REST, _PUSH, _RUN, _OUT = range(4)


class Procedure:
    """`sample()` receives the board's data, every 10 ms or so; `wanted` is then the pulse to keep
    active (None: stop), `pulses` its number; `done` when everything is recorded."""

    def __init__(self, believed: TurnNumbers, neutral_count: int, limits: BoardLimits) -> None:
        """`neutral_count`: the turn channel's, as stored on the board with these `limits`."""
        self.wanted: Pulse | None = None
        self.done = False
        self.recordings: list[Recording] = []
        self._neutral = neutral_count
        self._limits = limits
        self._believed = believed
        self._factor = {1: 1.0, -1: 1.0}
        self._plan = list(PULSES)
        self._left_ms = MOST_MS
        self._repeats = 0
        self._state = _REST
        self._since_ms: int | None = None
        self._past: list[Sample] = []
        self._pulse = Pulse(0, 0)
        self._began = 0
        self._start_deg = 0.0
        self._noise_deg = 0.0
        self._believed_deg = 0.0  # sum over all pulses

    def sample(self, s: Sample) -> None:
        """Take a sample. TuneError when the chair does not answer as it should."""
        if self.done:
            return
        if self._since_ms is None:
            self._since_ms = s.ms
            self._start_deg = s.heading_deg
        self._past.append(s)
        moves = s.turn_permille != 0
        if self._state == _REST:
            self._rest(s)
        elif self._state == _PUSH:
            self._push(s, moves)
        elif self._state == _RUN:
            self._run(s, moves)
        else:
            self._run_out(s)

    def _enter(self, state: int, s: Sample) -> None:
        self._state = state
        self._since_ms = s.ms

    def _for_ms(self, s: Sample) -> int:
        assert self._since_ms is not None
        return s.ms - self._since_ms

    def _quiet(self, s: Sample) -> bool:
        recent = [p.heading_deg for p in self._past if p.ms > s.ms - _QUIET_MS]
        return max(recent) - min(recent) <= _QUIET_DEG

    def _rest(self, s: Sample) -> None:
        if self._for_ms(s) < _QUIET_MS:
            return
        if not self._quiet(s):
            if self._for_ms(s) > _RESTS_MS[1]:
                raise TuneError(
                    "the heading does not come to rest; is the chair on a slope, pushed, or the"
                    " heading sensor loose?",
                    "tune_restless",
                )
            return
        if not self._plan:
            self.done = True
            return
        self._past = [p for p in self._past if p.ms > s.ms - _QUIET_MS]
        self._noise_deg = float(np.std([p.heading_deg for p in self._past]))
        self._pulse = self._next(s.heading_deg - self._start_deg)
        self.wanted = self._pulse
        self._enter(_PUSH, s)

    def _next(self, heading_deg: float) -> Pulse:
        permille, to_deg = self._plan[0]
        sign = 1 if permille > 0 else -1
        angle = max(3.0, (to_deg - heading_deg) * sign)
        numbers = scaled(self._believed, self._factor[sign])
        permille = sign * max(abs(permille), self._least_permille(numbers, sign))
        low, high = PULSE_MS
        high = min(high, self._left_ms // max(1, len(self._plan) - 2))
        high = max(low, high - _SAMPLE_MS // 2)
        while high - low > 5:
            middle = (low + high) // 2
            if angle_deg(numbers, permille / 1000, middle / 1000) < angle:
                low = middle
            else:
                high = middle
        # A pulse that ends midway between two samples shows in which half it began.
        return Pulse(permille, low - low % _SAMPLE_MS + _SAMPLE_MS // 2)

    def _least_permille(self, numbers: TurnNumbers, sign: int) -> int:
        """The smallest output that is sure to set the chair in motion."""
        full = numbers.left_dps if sign > 0 else numbers.right_dps
        share = min(1.0, _LOOSE * numbers.breakaway_dps / full)
        return round(1000 * (numbers.deadband + (1.0 - numbers.deadband) * share))

    def _push(self, s: Sample, moves: bool) -> None:
        if s.override:
            raise _overruled(s.override)
        if moves:
            self._began = len(self._past) - 1
            self._enter(_RUN, s)
        elif self._for_ms(s) > _STARTS_MS:
            text = "the board does not move the wiper; repeat, and report it if it stays"
            raise TuneError(text, "tune_wiper")

    def _run(self, s: Sample, moves: bool) -> None:
        heading = s.heading_deg - self._start_deg
        if s.override and s.override != codes.TUNING_ANGLE:
            raise _overruled(s.override)
        if abs(heading) > FAR_DEG:
            text = "the chair turned {deg} degrees: far more than asked for"
            raise TuneError(text, "tune_far", deg=round(abs(heading)))
        coast = self._coast_deg()
        if coast * heading > 0 and abs(heading + coast) > CUT_DEG:
            self.wanted = None
        if not moves:
            self.wanted = None
            self._ended = len(self._past) - 1
            self._enter(_OUT, s)

    def _coast_deg(self) -> float:
        """How far it would still turn after a stop, with the expected numbers."""
        first, last = self._past[-_RATE_SAMPLES], self._past[-1]
        rate = (last.heading_deg - first.heading_deg) * 1000 / max(1, last.ms - first.ms)
        b = self._believed
        return rate * (b.dead_time_s + b.lag_s) + rate * abs(rate) / (2 * b.brake_dps2)

    def _run_out(self, s: Sample) -> None:
        for_ms = self._for_ms(s)
        if for_ms < _RESTS_MS[0] or (for_ms < _RESTS_MS[1] and not self._quiet(s)):
            return
        self._left_ms -= self._pulse.pulse_ms
        recording = self._recorded()
        if recording is None:
            self._repeats += 1
            if self._repeats > _REPEATS:
                raise TuneError(
                    "this computer stalls; end other programs and repeat", "tune_stalls"
                )
        else:
            self.recordings.append(recording)
            self._learn(recording)
            self._plan.pop(0)
        self._past = []
        self._enter(_REST, s)

    def _recorded(self) -> Recording | None:
        """The samples in `_past`; None when some are missing where the wiper moved."""
        past, began, ended = self._past, self._began, self._ended
        gaps = [past[at].ms - past[at - 1].ms for at in (began, ended)]
        if max(gaps) > _GAP_MS:
            return None
        pulse_ms = float(self._pulse.pulse_ms)
        earliest_ms = max(past[began - 1].ms, past[ended - 1].ms - pulse_ms)
        latest_ms = min(past[began].ms, past[ended].ms - pulse_ms)
        on_ms = 0.5 * (earliest_ms + latest_ms)
        if earliest_ms > latest_ms + _TICKS_MS:  # it was cut short
            on_ms = past[began].ms - gaps[0] / 2
            pulse_ms = past[ended].ms - gaps[1] / 2 - on_ms
        count = round(self._count(past[(began + ended) // 2].turn_permille))
        if abs(count - self._count(self._pulse.turn_permille)) > _COUNTS:
            raise TuneError(
                "the board turns slower than asked for: something is near the chair, or its"
                " settings limit the turn; give it free space all round",
                "tune_slower",
            )
        before = np.mean([p.heading_deg for p in past[:began]])
        full = self._count(1000 if count > self._neutral else -1000)
        return Recording(
            self._deflection(count),
            pulse_ms / 1000,
            np.array([(p.ms - on_ms) / 1000 for p in past]),
            np.array([p.heading_deg - before for p in past]),
            self._noise_deg,
            abs(self._deflection(full)),
        )

    def _count(self, permille: int) -> float:
        """The wiper's count on the board for that deflection, within the chair's window."""
        count = self._neutral + permille / 1000 * self._limits.wiper_span
        return max(self._limits.wiper_min, min(self._limits.wiper_max, count))

    def _deflection(self, count: float) -> float:
        """Of the joystick at that count, -1..1, left positive."""
        highest = self._limits.wiper_max
        middle = 0.5 * (self._limits.wiper_min + highest)
        # A stored neutral is a whole count: the one nearest to the middle stands for the middle.
        centre = middle if abs(self._neutral - middle) <= 0.5 else float(self._neutral)
        return max(-1.0, min(1.0, (count - centre) / (highest - middle)))

    def _learn(self, recording: Recording) -> None:
        """Learn how much further than expected it turned; check that it responds at all."""
        if recording.noise_deg > _NOISE_DEG:
            text = "the heading is noisy though the chair stands; is the sensor loose?"
            raise TuneError(text, "tune_noisy")
        sign = 1 if recording.deflection > 0 else -1
        believed = angle_deg(self._believed, recording.deflection, recording.pulse_s)
        self._believed_deg += believed
        if believed > _MOVED_DEG:
            ratio = max(0.3, min(3.0, recording.turned_deg * sign / believed))
            self._factor[sign] = 0.5 * (self._factor[sign] + ratio)
        if len(self.recordings) < _ANSWERS:
            return
        turned = [r.turned_deg for r in self.recordings]
        along = [r.turned_deg * np.sign(r.deflection) for r in self.recordings]
        if max(map(abs, turned)) < _MOVED_DEG:
            raise TuneError(
                "the chair did not turn; is it switched on, its brakes engaged (not in"
                " free-wheel), the DB9 plugged in, the relay closed?",
                "tune_no_turn",
            )
        # Casters alone may do that in a few pulses, and cancel most of a slow chair's turn.
        if len(along) == len(PULSES) and sum(along) < -_REVERSED * self._believed_deg:
            raise TuneError(
                "the chair turned the other way; the turn channel is reversed: see docs/wiring.md",
                "tune_reversed",
            )


def _overruled(override: int) -> TuneError:
    text = "the board stopped the pulse: {reason}; clear that and repeat"
    return TuneError(text, "pulse_stopped", reason=str(codes.reason_name(override)))
