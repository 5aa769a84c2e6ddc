"""The board's newest reports: headings, outputs, and whether the chair stood for sure."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from itertools import takewhile

import numpy as np

from gazechair.base.angles import half_turn_deg
from gazechair.base.arrays import FloatArray
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.odometry.heading_steps import HeadingSteps
from gazechair.sensing.odometry.seen import Outputs
from gazechair.sensing.odometry.speed_by_command import CHANGED_S, DEAD_S

OLD_S = 0.3  # a heading, and one report without another
_KEPT_S = 3.0  # of motion
_STARTS_S = 0.6  # time that the chair takes to start
_ACTS = 50  # permille: with less, as of a heading that is kept, no chair moves that way
_STOOD_S = 10.0  # for longer nobody vouches: it may have been pushed
_TURNED_RAD = math.radians(1.0)  # who pushes it hardly pushes it so straight


class Reports:
    """Feed it `motion` in the order of time."""

    def __init__(self) -> None:
        self._motions: deque[Motion] = deque()
        self._turned_deg = 0.0
        self._steps = HeadingSteps()
        self._taken_out_deg = 0.0  # steps of the sensor
        self._ran_s = -math.inf  # newest output, or end of a time without reports

    def motion(self, motion: Motion) -> None:
        """Take in the board's report."""
        if motion.heading_deg is None:
            self._steps.lost()
        else:  # full turns are counted
            off = motion.heading_deg - self._turned_deg
            self._turned_deg += half_turn_deg(off)
            self._steps.take(motion.time_s, self._turned_deg)
            motion = replace(motion, heading_deg=self._turned_deg - self._taken_out_deg)
        rests = motion.linear_permille == 0 and motion.turn_permille == 0
        rests = rests and motion.heading_deg is not None  # else nobody knows if it is turned
        if not rests or motion.time_s - self.newest_s(-math.inf) > OLD_S:
            self._ran_s = motion.time_s
        self._motions.append(motion)
        while self._motions[0].time_s < motion.time_s - _KEPT_S:
            self._motions.popleft()

    def newest_s(self, at_s: float) -> float:
        """The newest time known, at least `at_s`: scans may come late."""
        return max(at_s, self._motions[-1].time_s) if self._motions else at_s

    @property
    def steps(self) -> list[tuple[float, float]]:
        """Steps of the sensor that nobody has judged yet: times, degrees."""
        return self._steps.open

    def keep_steps(self) -> None:
        """The chair has turned with the sensor."""
        self._steps.open.clear()

    def take_out_steps(self) -> None:
        """The chair has not turned: its headings go on as before the steps."""
        for step_s, deg in self._steps.open:
            self._taken_out_deg += deg
            for number, one in enumerate(self._motions):
                if one.time_s >= step_s and one.heading_deg is not None:
                    self._motions[number] = replace(one, heading_deg=one.heading_deg - deg)
        self._steps.open.clear()

    def headings(self, stepped: bool = False) -> tuple[FloatArray, FloatArray]:
        """Times, and the headings then in radians, full turns counted.

        Only those since the newest report without one: the sensor may have begun at another zero.
        `stepped`: with the steps that nobody has judged yet.
        """
        known = [
            (m.time_s, m.heading_deg)
            for m in takewhile(lambda m: m.heading_deg is not None, reversed(self._motions))
        ]
        rows = np.array(known[::-1], dtype=np.float64).reshape(-1, 2)
        if not stepped:
            for step_s, deg in self._steps.open:
                rows[rows[:, 0] >= step_s, 1] -= deg
        return rows[:, 0], np.radians(rows[:, 1])

    def stood(self, since_s: float, at_s: float, turned_rad: float) -> bool:
        """Whether a chair that stood at `since_s` has stood until `at_s`, for some seconds at most.

        Nothing was put out and, by the sensor, it has not turned (`turned_rad`) as when pushed.
        """
        rests = self._ran_s < since_s - _STARTS_S and self.newest_s(-math.inf) > at_s - OLD_S
        return rests and at_s - since_s < _STOOD_S and abs(turned_rad) < _TURNED_RAD

    def linear(self, since_s: float, at_s: float) -> list[int | None]:
        """The linear outputs between two times, permille."""
        return [m.linear_permille for m in self._motions if since_s < m.time_s <= at_s]

    def outputs(self, at_s: float) -> Outputs | None:
        """What it has put out; None: not known."""
        recent = [m for m in self._motions if m.time_s <= at_s]
        found = [
            (m.time_s, m.linear_permille, m.turn_permille)
            for m in recent
            if m.linear_permille is not None and m.turn_permille is not None
        ]
        if not found or len(found) < len(recent) or found[0][0] > at_s - _STARTS_S:
            return None
        newest = [row for row in found if row[0] >= at_s - _STARTS_S] or [(at_s, 0, 0)]
        drive, turn = [row[1] for row in newest], [row[2] for row in newest]
        any_s, forward_s, backward_s, left_s, right_s = found[0][0], *(-math.inf,) * 4
        for row_s, linear, turned in found:
            any_s = row_s if linear or turned else any_s
            forward_s = row_s if linear > _ACTS else forward_s
            backward_s = row_s if linear < -_ACTS else backward_s
            left_s = row_s if turned > _ACTS else left_s
            right_s = row_s if turned < -_ACTS else right_s
        return Outputs(
            _least(drive),
            _least(turn),
            max(abs(row[2]) for row in found),
            *(at_s - last_s for last_s in (any_s, forward_s, backward_s, left_s, right_s)),
        )

    def command(self, at_s: float) -> tuple[float | None, bool]:
        """The command that the motors follow at that time, -1..1, and whether it changed lately."""
        recent = [m for m in self._motions if m.time_s >= at_s - DEAD_S - CHANGED_S]
        acts = [m.linear_permille for m in recent if m.time_s <= at_s - DEAD_S]
        if not acts or acts[-1] is None:
            return None, True
        outputs = [m.linear_permille or 0 for m in recent]
        return acts[-1] / 1000.0, max(outputs) - min(outputs) > 50


def _least(outputs: list[int]) -> int:
    """The least of them if all have the same sign, with it; else 0."""
    return max(min(outputs), 0) + min(max(outputs), 0)
