"""Odometry's core: a filter with prediction by heading and command, and correction by the lidars.

The heading of the board's sensor is right but for a slowly changing offset; the command predicts
the speed; each piece of a lidar's turn is fitted to the surfaces seen before. What the surfaces do
not determine, as along a bare corridor, follows the prediction, with a growing uncertainty. No
clock, no process.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import compose
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.odometry.doubts import DIFFERS, FEW, LOST, Doubts, is_determined
from gazechair.sensing.odometry.drift import Drift
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.headings import Breaks, Heading, HeadingCheck, heading_at
from gazechair.sensing.odometry.match import (
    ERROR,
    FORWARD,
    FULL,
    OFFSET,
    SIDEWAYS,
    STATES,
    Fit,
    X,
    Y,
)
from gazechair.sensing.odometry.mounting import Mounting, Stand
from gazechair.sensing.odometry.points import OLDER_S, seen_points
from gazechair.sensing.odometry.prediction import predict
from gazechair.sensing.odometry.progress import Progress
from gazechair.sensing.odometry.repeated import repeats
from gazechair.sensing.odometry.reports import Reports
from gazechair.sensing.odometry.seen import Seen
from gazechair.sensing.odometry.shared_walls import SharedWalls
from gazechair.sensing.odometry.speed_by_command import SpeedByCommand
from gazechair.sensing.odometry.surfaces import Surfaces
from gazechair.sensing.odometry.turned_piece import TurnedPiece

_UNKNOWN_RAD_S = math.radians(60.0)  # how fast it may turn without a heading
_DIFFERS_RAD_S = math.radians(20.0)
_MATCHED = 0.5
# A step of the sensor: how long the lidars may take to judge it, by a piece that begins not much
# before it, with the heading as free; and the share of points that more must match with it.
_STEP_S, _STEP_NEAR_S, _STEP_FREE_RAD, _STEP_MATCHED = 0.3, 0.01, math.radians(5.0), 0.1
_FULL_M_S, _FULL_SIGMA_M_S = 0.5, 0.25
_FIRST_COVARIANCE = np.diag((1e-8, 1e-8, 1e-8, 0.01, 0.0025, _FULL_SIGMA_M_S**2, 1.0))
_SILENT_S = 0.2  # of a lidar, or age of its scans
_GAP_S = 0.7  # in the scans: for longer, the last speed and the command do not tell the way
_STOOD_M_S = 0.03


@dataclass(frozen=True)
class _Fitted:
    """A piece, fitted to the surfaces seen before."""

    points: FloatArray
    normals: FloatArray
    fit: Fit
    old_or_turned: bool  # it is of another time, or the lidar has been turned


class Odometry:
    """Feed it `motion` and pieces in the order of their times."""

    def __init__(self, track: int = 0) -> None:
        """`track`: number of its first track."""
        self._reports = Reports()
        self._surfaces = Surfaces()
        self._state: FloatArray = np.zeros(STATES)
        self._state[FULL] = _FULL_M_S
        self._covariance = _FIRST_COVARIANCE.copy()
        self._drift = Drift()
        self._track = track
        self._doubts = Doubts()
        self._speed_by_command = SpeedByCommand()
        self._mounting = Mounting()
        self._shared_walls = SharedWalls()
        self._left_out: int | None = None  # a lidar that is turned against another
        self._newest: Estimate | None = None
        self._turned_piece = TurnedPiece()
        self._progress = Progress()
        self._heading_check = HeadingCheck()
        self._differs = False  # the heading counts less then
        self._heard_s: dict[int, float] = {}  # by lidar
        self._time_s: float | None = None
        self._heading_rad = 0.0  # of the sensor, at the newest piece, not wrapped
        self._breaks = Breaks()
        self._inexact = Breaks()

    def motion(self, motion: Motion) -> None:
        """Take in the board's report."""
        self._reports.motion(motion)

    def piece(self, piece: Piece) -> Estimate | None:
        """The estimate at the middle of the piece; None: the piece is unusable.

        A piece a little older than another lidar's newest one corrects the estimate at that one.
        """
        at_s, heard_s = piece.middle_s, self._heard_s.get(piece.lidar, -math.inf)
        self._heard_s[piece.lidar] = at_s  # too old a piece is no silence either
        if self._time_s is not None and at_s <= self._time_s:
            if at_s <= heard_s or at_s < self._time_s - OLDER_S:
                return None
            at_s = self._time_s
            piece = replace(piece, as_of_s=at_s)
        if self._is_left_out(piece):
            return self._turn_back(piece)
        sensor = self._heading_at(piece)
        is_back, steady = self._breaks.judge(at_s, sensor.known)
        judges = self._inexact.judge(at_s, sensor.exact)[1]
        if self._time_s is None:
            self._heading_rad, self._time_s = sensor.rad, at_s
            self._state[OFFSET] = -sensor.rad
        elif is_back:  # the lidars have followed what it turned by meanwhile
            self._state[OFFSET] += self._heading_rad - sensor.rad
            self._heading_rad = sensor.rad
        self._judge_gap(at_s, sensor.rad)
        fitted = self._fit(piece, sensor, steady)
        found = fitted.fit
        self._drift.grow(found, self._state, self._covariance)
        self._turn_drift(piece, found, sensor)
        dt_s = at_s - self._time_s
        faster_m_s = float(found.state[FORWARD] - self._state[FORWARD])
        self._speed_by_command.judge(faster_m_s if found.sees_speed else None, dt_s)
        self._cross_check(found, dt_s, judges)
        self._state, self._covariance = found.state, found.covariance
        self._time_s, self._heading_rad = at_s, sensor.rad
        self._compare(piece, sensor, (fitted.points, fitted.normals))
        self._remember(piece, fitted)
        doubts = self._doubts.judge(self._seen(piece, sensor, fitted, judges))
        self._differs = DIFFERS in doubts
        self._newest = self._estimate(sensor.yaw_deg_s, found, doubts)
        if LOST in doubts:
            self._begin_afresh()
        return self._newest

    def _is_left_out(self, piece: Piece) -> bool:
        """Whether another lidar is used instead: two that contradict each other mislead."""
        before, known = self._left_out, self._mounting.known
        self._left_out = None if known else self._shared_walls.compared.turned
        if self._left_out not in (None, before):  # what it has seen is turned, too
            self._surfaces.forget()
        others = [at_s for lidar, at_s in self._heard_s.items() if lidar != piece.lidar]
        return piece.lidar == self._left_out and piece.at_s - max(others) <= _SILENT_S

    def _turn_back(self, piece: Piece) -> Estimate | None:
        """Compare what a lidar sees that is left out with what the others have seen."""
        sensor, state = heading_at(piece, self._reports, self._heading_rad), self._state
        turned_deg = math.degrees(sensor.rad - self._heading_rad)
        moved = self._newest and self._newest.left_out_at(piece.at_s, turned_deg, sensor.yaw_deg_s)
        if not self._shared_walls.is_due(piece.at_s):
            return moved
        seen = seen_points(piece, sensor.turned, state[FORWARD], state[SIDEWAYS])
        self._compare(piece, sensor, seen)
        back_deg = math.degrees(self._shared_walls.compared.by_rad)
        piece = replace(piece, directions_deg=piece.directions_deg - back_deg)
        found = self._match(piece, sensor, True, _STEP_FREE_RAD)[3]
        off_rad = float(found.state[OFFSET] + found.state[ERROR] - state[OFFSET])
        self._shared_walls.turned_back(off_rad, found.matched)
        return moved

    def _compare(self, piece: Piece, sensor: Heading, seen: tuple[FloatArray, FloatArray]) -> None:
        """Compare lidars by walls; `seen`: the piece's points and normals."""
        if len(self._heard_s) > 1 and sensor.exact and not self._reports.steps:
            turned = np.array((0.0, 0.0, sensor.rad))
            self._shared_walls.take(piece, *seen, self._state[:3] + turned)

    def _heading_at(self, piece: Piece) -> Heading:
        """What the board's sensor says of the time of the piece; its own steps are taken out."""
        steps = self._reports.steps
        if self._time_s is None or (steps and piece.at_s > steps[-1][0] + _STEP_S):
            self._reports.keep_steps()
        elif steps and piece.times_s[0] > steps[-1][0] - _STEP_NEAR_S:
            self._judge_steps(piece)
        return heading_at(piece, self._reports, self._heading_rad)

    def _judge_steps(self, piece: Piece) -> None:
        """Decide by the lidars whether the chair has turned with the sensor, if they see enough."""
        steps_deg = [deg for _, deg in self._reports.steps]
        step_rad = math.radians(sum(steps_deg))
        matched, turned_rad = [], []
        for stepped in (False, True):
            sensor = heading_at(piece, self._reports, self._heading_rad, stepped)
            if not stepped:
                before_rad = sensor.rad + self._state[OFFSET]
            free_rad = min(abs(step_rad), _STEP_FREE_RAD)
            points, _, _, found = self._match(piece, sensor, sensor.known, free_rad)
            if len(points) < FEW:
                return
            matched.append(found.matched)
            turned_rad.append(sensor.rad + found.state[OFFSET] + found.state[ERROR] - before_rad)
        if max(matched) < _MATCHED:
            return
        turned = turned_rad[matched[1] > matched[0] + _STEP_MATCHED]
        if abs(turned - step_rad) < abs(turned):
            self._reports.keep_steps()
            return
        self._reports.take_out_steps()
        self._heading_check.stepped(steps_deg)

    def _fit(self, piece: Piece, sensor: Heading, steady: bool) -> _Fitted:
        """Predict the motion until the piece, and correct it by the surfaces seen before."""
        points, normals, state, found = self._match(piece, sensor, steady)
        self._surfaces.note(piece.at_s, found)
        expected = float(state[X]), float(state[Y]), float(sensor.rad + state[OFFSET])
        old_or_turned = self._turned_piece.judge(
            self._surfaces.fine, points, normals, piece.origin_m, expected, found.matched
        ) or self._repeats(piece.at_s, found)
        return _Fitted(points, normals, found, old_or_turned)

    def _match(
        self, piece: Piece, sensor: Heading, steady: bool, free_rad: float = 0.0
    ) -> tuple[FloatArray, FloatArray, FloatArray, Fit]:
        """Points, normals, predicted state and fit; the heading is free by `free_rad` more."""
        state, covariance, learns = self._predict(piece.at_s, sensor.rad, steady)
        covariance[OFFSET, OFFSET] += free_rad**2
        points, normals = seen_points(piece, sensor.turned, state[FORWARD], state[SIDEWAYS])
        where = state, covariance, sensor.rad, learns
        found = self._surfaces.fit(piece.at_s, points, normals, *where)
        return points, normals, state, found

    def _seen(self, piece: Piece, sensor: Heading, fitted: _Fitted, judges: bool) -> Seen:
        """What the doubts are judged by, after the state has taken the piece in."""
        at_s, yaw, found = piece.at_s, sensor.yaw_deg_s, fitted.fit
        x, y, _ = self._pose()
        return Seen(
            at_s,
            sensor.known,
            len(fitted.points),
            found.information,
            found.matched,
            float(self._state[FORWARD]),
            math.sqrt(self._covariance[FORWARD, FORWARD]),
            float(self._state[SIDEWAYS]),
            yaw,
            x,
            y,
            math.degrees(sensor.rad),
            *self._progress.take(at_s, x, y, sensor.rad + float(self._state[OFFSET])),
            self._reports.outputs(at_s),
            float(self._state[FULL]) - 2.0 * math.sqrt(self._covariance[FULL, FULL]),
            self._heading_check.off_deg,
            self._reports.newest_s(at_s) - at_s > _SILENT_S,
            at_s - min(self._heard_s.values()) > _SILENT_S,
            self._is_turned(piece, fitted, yaw, judges),
        )

    def _turn_drift(self, piece: Piece, found: Fit, sensor: Heading) -> None:
        """Widen the position by what a lidar that may be turned makes of its way."""
        if self._mounting.known:
            return
        assert self._time_s is not None
        lidar, turned = np.array((*piece.origin_m, 0.0)), np.array((0.0, 0.0, 1.0))
        steps = (self._state, self._heading_rad), (found.state, sensor.rad)
        before, now = (compose(state[:3] + rad * turned, lidar) for state, rad in steps)
        moved_m = now[:2] - before[:2]
        if not self._mounting.turned:
            self._drift.turn(moved_m, self._mounting.sigma_rad)
            return
        output = self._reports.command(piece.at_s)[0] or 0.0
        could_m = abs(output) * max(_FULL_M_S, self._state[FULL]) * (piece.at_s - self._time_s)
        self._drift.stray(max(could_m, math.hypot(*moved_m)))

    def _is_turned(self, piece: Piece, fitted: _Fitted, yaw: float, known: bool) -> bool:
        assert self._time_s is not None
        found, pose = fitted.fit, self._pose()
        ahead = np.array((math.cos(pose[2]), math.sin(pose[2])))
        stand = Stand(
            self._time_s,
            piece.lidar,
            *pose,
            yaw,
            float(found.state[ERROR]),
            self._heading_check.lidars_deg,
            found.matched,
            known,
            fitted.old_or_turned,
            math.degrees(found.state[OFFSET]),
            is_determined(found.information, np.array((-ahead[1], ahead[0]))),
            math.sqrt(ahead @ found.covariance[:2, :2] @ ahead),
            self._shared_walls.compared,
        )
        was_turned, sigma_rad = self._mounting.turned, self._mounting.sigma_rad
        turned = self._mounting.judge(stand)
        if turned and not was_turned:
            self._drift.bump(math.hypot(*piece.origin_m), self._mounting.sigma_rad)
        elif self._mounting.known and sigma_rad > self._mounting.sigma_rad:
            self._drift.settle(1.0 if was_turned else self._mounting.sigma_rad / sigma_rad)
        return turned

    def _repeats(self, at_s: float, found: Fit) -> bool:
        assert self._time_s is not None
        before = self._state
        angle = self._heading_rad + before[OFFSET]
        moved_m = float((found.state[:2] - before[:2]) @ (math.cos(angle), math.sin(angle)))
        gap = self._reports.linear(self._time_s, at_s)
        return repeats(at_s - self._time_s, float(before[FORWARD]), moved_m, gap)

    def _cross_check(self, found: Fit, dt_s: float, judges: bool) -> None:
        """Update the recent difference between the lidars' heading and the sensor's."""
        if not judges:
            self._heading_check.forget(dt_s)
            return
        seen_rad = float(found.state[ERROR]) if found.matched > _MATCHED else 0.0
        followed_rad = float(found.state[OFFSET] - self._state[OFFSET])
        self._heading_check.judge(seen_rad, followed_rad, dt_s)

    def _judge_gap(self, at_s: float, heading: float) -> None:
        """Start another track after a long gap in the scans, unless the chair stood in it."""
        assert self._time_s is not None
        if at_s - self._time_s <= _GAP_S:
            return
        stands = abs(self._state[FORWARD]) < _STOOD_M_S
        if stands and self._reports.stood(self._time_s, at_s, heading - self._heading_rad):
            self._state[[FORWARD, SIDEWAYS]] = 0.0
            return
        self._begin_afresh()
        self._time_s, self._heading_rad = at_s, heading

    def _begin_afresh(self) -> None:
        """Start another track: nothing that is seen is known, as after being carried."""
        self._track += 1
        self._doubts.forget()
        self._shared_walls.forget()
        self._surfaces.forget()
        self._drift = Drift()
        self._state[[FORWARD, SIDEWAYS]] = 0.0
        self._covariance = _FIRST_COVARIANCE.copy()

    def _predict(
        self, at_s: float, heading: float, heading_known: bool
    ) -> tuple[FloatArray, FloatArray, bool]:
        assert self._time_s is not None
        dt_s = at_s - self._time_s
        command, changing = self._reports.command(at_s)
        speed = self._speed_by_command.predict(
            float(self._state[FORWARD]),
            float(self._state[FULL]),
            math.sqrt(self._covariance[FULL, FULL]),
            command,
            changing,
            dt_s,
        )
        state, covariance = predict(
            self._state,
            self._covariance,
            self._heading_rad,
            heading - self._heading_rad,
            speed,
            dt_s,
        )
        if self._differs:
            covariance[OFFSET, OFFSET] += (_DIFFERS_RAD_S * dt_s) ** 2
        if not heading_known:
            covariance[OFFSET, OFFSET] += (_UNKNOWN_RAD_S * dt_s) ** 2
        return state, covariance, speed.learns

    def _pose(self) -> tuple[float, float, float]:
        x, y, offset, error = self._state[[X, Y, OFFSET, ERROR]].tolist()
        return x, y, self._heading_rad + offset + error

    def _remember(self, piece: Piece, fitted: _Fitted) -> None:
        if self._reports.steps:  # its heading may be wrong
            return
        seen = fitted.points, fitted.normals
        self._surfaces.renew(piece.lidar, piece.at_s, *seen, self._pose(), fitted.fit.known)

    def _estimate(self, yaw: float, found: Fit, doubts: tuple[str, ...]) -> Estimate:
        assert self._time_s is not None
        (x, y, angle), state = self._pose(), self._state
        along = np.array((math.cos(angle), math.sin(angle)))
        across = np.array((-along[1], along[0]))
        place = self._drift.with_match(self._covariance[:2, :2])
        return Estimate(
            self._time_s,
            x,
            y,
            math.degrees(angle),
            float(state[FORWARD]),
            float(state[SIDEWAYS]),
            yaw,
            math.sqrt(along @ place @ along),
            math.sqrt(across @ place @ across),
            math.degrees(self._drift.heading_rad(self._covariance, self._mounting.sigma_rad)),
            math.sqrt(self._covariance[FORWARD, FORWARD]),
            found.matched,
            doubts,
            self._track,
            math.degrees(self._mounting.sigma_rad),
            self._mounting.lidar if self._mounting.turned else None,
            self._mounting.by_walls,
        )
