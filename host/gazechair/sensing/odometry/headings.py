"""The board's headings over time: rate of change, breaks, and an extrapolation beyond the newest.

A lidar's measurements are often newer than the newest heading: without extrapolation, its last
beams in a turn would be off by some tenths of a degree.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.odometry.reports import OLD_S, Reports

_SLOPE_S = 0.08
_FEWEST = 3
_LEAST_SPREAD_S2 = 1e-5  # two headings 5 ms apart
_BEYOND_S = 0.1  # how long it is assumed to continue its turn
_APART_S = 0.12  # headings further apart do not tell the turn between them
_NEAR_S = 0.05  # a turn that just begins is off by a sixth of a degree after it
_ERROR_S, _FOLLOWED_S = 0.3, 1.0
_STEP_RAD = math.radians(2.0)  # a larger step is not remembered longer
_STEADY_S = 0.25  # after a break headings are interpolated across it at first


@dataclass(frozen=True)
class Heading:
    """The heading of the board's sensor at the time of a piece."""

    rad: float
    turned: FloatArray  # radians from there, at each beam of the piece
    known: bool
    exact: bool  # enough to judge the lidars by
    yaw_deg_s: float


class Breaks:
    """Times without a heading, after which it says nothing of the turn meanwhile."""

    def __init__(self) -> None:
        self._since_s: float | None = -math.inf  # known since then

    def judge(self, at_s: float, known: bool) -> tuple[bool, bool]:
        """(whether it has just come back, whether the lidars can be judged by it)."""
        is_back = known and self._since_s is None
        if is_back or not known:
            self._since_s = at_s if known else None
        return is_back, self._since_s is not None and at_s - self._since_s >= _STEADY_S


class HeadingCheck:
    """Recent difference between the lidars' heading and the sensor's."""

    def __init__(self) -> None:
        self._error_rad = self._followed_rad = self._step_rad = 0.0

    def judge(self, seen_rad: float, followed_rad: float, dt_s: float) -> None:
        """`seen_rad`: by the newest piece; `followed_rad`: by which the lidars have moved it."""
        self._error_rad += (seen_rad - self._error_rad) * (1.0 - math.exp(-dt_s / _ERROR_S))
        self._followed_rad *= math.exp(-dt_s / _FOLLOWED_S)
        self._followed_rad += followed_rad
        self._step_rad *= math.exp(-dt_s / _FOLLOWED_S)

    def stepped(self, steps_deg: Iterable[float]) -> None:
        """The lidars have not seen steps of the sensor."""
        self._step_rad = min(sum(abs(math.radians(deg)) for deg in steps_deg), _STEP_RAD)

    def forget(self, dt_s: float) -> None:
        """The lidars cannot be judged by the sensor."""
        self._error_rad = self._followed_rad = 0.0
        self._step_rad *= math.exp(-dt_s / _FOLLOWED_S)

    @property
    def lidars_deg(self) -> float:
        """A difference for which a lidar may be to blame."""
        return math.degrees(self._error_rad + self._followed_rad)

    @property
    def off_deg(self) -> float:
        """The whole difference."""
        off = self._error_rad + self._followed_rad
        return math.degrees(off + math.copysign(self._step_rad, off))


def heading_at(piece: Piece, reports: Reports, before_rad: float, stepped: bool = False) -> Heading:
    """What the board's sensor says of the time of the piece; without a report: `before_rad`.

    `stepped`: see Reports.headings.
    """
    at_s = piece.at_s
    times, headings = reports.headings(stepped)
    rad, turned = before_rad, np.zeros(len(piece.times_s))
    if len(times):
        onward = beyond(times, headings)
        rad = float(np.interp(at_s, *onward))
        turned = np.interp(piece.times_s, *onward) - rad
    known, exact = len(times) > 0 and at_s - times[-1] < OLD_S, is_exact(at_s, times)
    return Heading(rad, turned, known, exact, math.degrees(rate_rad_s(at_s, times, headings)))


def is_exact(at_s: float, times_s: FloatArray) -> bool:
    """Whether headings at `at_s` are near enough, and to each other, to judge the lidars by."""
    after = int(np.searchsorted(times_s, at_s))
    before_s = float(times_s[after - 1]) if after else -math.inf
    after_s = float(times_s[after]) if after < len(times_s) else math.inf
    if math.isfinite(before_s) and math.isfinite(after_s):
        return after_s - before_s <= _APART_S
    return min(at_s - before_s, after_s - at_s) <= _NEAR_S


def rate_rad_s(at_s: float, times_s: FloatArray, headings_rad: FloatArray) -> float:
    """Slope of the headings around `at_s`; 0 where it is undetermined."""
    near = np.abs(times_s - at_s) <= _SLOPE_S
    if np.count_nonzero(near) < _FEWEST:
        return 0.0
    apart, turned = times_s[near] - times_s[near].mean(), headings_rad[near]
    spread = float((apart**2).sum())
    if spread < _LEAST_SPREAD_S2:  # they arrived together, as after a stall
        return 0.0
    return float((apart * turned).sum()) / spread


def beyond(times_s: FloatArray, headings_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Times and headings with one more appended: the heading if the turn continues."""
    if not len(times_s):
        return times_s, headings_rad
    newest_s = float(times_s[-1])
    turns_rad = _BEYOND_S * rate_rad_s(newest_s, times_s, headings_rad)
    return (
        np.append(times_s, newest_s + _BEYOND_S),
        np.append(headings_rad, headings_rad[-1] + turns_rad),
    )
