"""Detects a chair that slowly leaves the place where it came to rest."""

from __future__ import annotations

import math
from collections import deque

from gazechair.sensing.odometry.seen import DIFFERS_DEG, Seen

_SAMPLE_S = 0.25
_WINDOW_S = 20.0  # the heading sensor's drift within it is a tenth of a degree
_AWAY_M, _AWAY_DEG = 0.10, 5.0
# Still under way, in each of the last two spans: it has not been given a push, and no step of the
# sensor is a turn.
_SPAN_S, _SPAN_M, _SPAN_DEG = 0.5, 0.01, 0.75
_TURNS_DEG = 1.0  # in one span

_Place = tuple[float, ...]


class Resting:
    """Feed it all that is seen."""

    def __init__(self) -> None:
        self._places: deque[_Place] = deque()  # s; x, y in m
        self._headings: deque[_Place] = deque()  # s; deg, by the sensor
        self._lately: deque[tuple[float, float]] = deque()  # the same, always
        self.creeps = False
        """It has moved away from where it was at rest, and still does."""
        self.creeps_round = False
        """It has turned away, by the heading sensor, and still does."""
        self.turns = True
        """It has turned in the last moments, however slowly; or that is not known."""

    def take(self, seen: Seen, sure: bool, rests: bool) -> None:
        """`sure`: its position is known; `rests`: all chairs have stopped since the last output."""
        known = seen.heading_known and abs(seen.heading_off_deg) <= DIFFERS_DEG
        self.creeps = self.creeps_round = False
        if not rests or not sure:
            self._places.clear()
        if not rests or not known:
            self._headings.clear()
        if rests and sure:
            self.creeps = _away(self._places, (seen.time_s, seen.x_m, seen.y_m), _AWAY_M, _SPAN_M)
        if rests and known:
            now = seen.time_s, seen.sensor_deg
            self.creeps_round = _away(self._headings, now, _AWAY_DEG, _SPAN_DEG)
        self._lately.append((seen.time_s, seen.sensor_deg))
        while self._lately[0][0] < seen.time_s - _SPAN_S:
            first = self._lately.popleft()
            self.turns = not known or abs(seen.sensor_deg - first[1]) > _TURNS_DEG

    def forget(self) -> None:
        """Positions have nothing to do with those before."""
        self._places.clear()
        self.creeps = False


def _away(places: deque[_Place], now: _Place, away: float, span: float) -> bool:
    """Whether it is that far from an earlier place, and has gone on in each of the last spans."""
    while places and places[0][0] < now[0] - _WINDOW_S:
        places.popleft()
    if not places or now[0] - places[-1][0] >= _SAMPLE_S:
        places.append(now)

    def off(one: _Place, other: _Place) -> float:
        return math.dist(one[1:], other[1:])

    if max(off(one, now) for one in places) <= away:
        return False
    before = [
        next((one for one in reversed(places) if one[0] <= now[0] - back_s), places[0])
        for back_s in (_SPAN_S, 2.0 * _SPAN_S)
    ]
    return off(before[0], now) > span and off(before[1], before[0]) > span
