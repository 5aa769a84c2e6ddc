"""Arcs built to collide: obstacles just outside the straight path and inside the turning arc.

The hand's path is computed first, then a post or a wall's end is put where that path sweeps it
and the straight path does not. The chairs respond as slowly as the settings state, but with other
physics than the twin's.
"""

from __future__ import annotations

import math
import random
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from gazechair.base.angles import half_turn_deg
from gazechair.base.arrays import FloatArray
from gazechair.sensing.lidar.scan import in_arcs
from gazelink import codes
from gazelink.settings_table import profile_row
from gazemeasure.obstacles.eyes import Mount
from gazemeasure.obstacles.run import FULL, STEP_S
from gazesim.chair import FRONT_M, HALF_TRACK_M, HALF_WIDTH_M, REAR_M
from gazesim.profiles import PROFILES as CHAIRS
from gazesim.rooms import Room, Solid, box

_HALL_M = 6.0
_BESIDE_M = 0.25  # from the straight path
_FREE_M = 0.015  # from the chair at the start
_TOUCHING_M = 0.005
_TRIES = 60
_LOOK = 4  # steps between two poses of the path
_UNEVEN = 0.9
_SAMPLING_STEPS = 2  # 10 ms steps, of a chair that reads its joystick every 20 ms

KINDS = ("exact", "second order", "jerk", "uneven", "slow drive", "slow turn", "sampled")


@dataclass(frozen=True)
class Hold:
    """The hand presses `verb` for `for_s`; linear and turn (permille) are the stick's.

    `press`: it was released before.
    """

    for_s: float
    verb: int
    linear: int = 0
    turn: int = 0
    press: bool = False


@dataclass(frozen=True)
class Attack:
    """A room, a hand, and the chair's physics for them."""

    room: Room
    hand: tuple[Hold, ...]
    kind: str
    points: tuple[tuple[float, float], ...]
    """Points of the obstacle in the path."""


class AttackedAxis:
    """One axis: dead time, ramp (or jerk-limited), then one or two lags; no friction.

    It stops within the longest distance that the settings state: speed * (dead time + lag) +
    speed^2 / 2 brake, however the lag is shared between a jerk limit and a second lag.
    """

    def __init__(
        self, full: tuple[float, float], dead_s: float, lag_s: float, brake: float, kind: str
    ) -> None:
        self.speed = 0.0
        self._full = full
        self._brake = brake
        self._accelerate = brake if kind == "second order" else 0.6 * brake
        self._lags = [lag_s / 2, lag_s / 2] if kind == "second order" else [lag_s]
        self._jerk = math.inf
        if kind == "jerk":
            self._lags = [lag_s / 2]
            self._jerk = brake / lag_s
        self._pending = deque([0.0] * max(1, round(dead_s / STEP_S)))
        self._ramp = self._slope = 0.0
        self._stages = [0.0] * len(self._lags)

    def step(self, deflection: float) -> None:
        """10 ms with the stick at `deflection`."""
        pending = self._pending
        pending.append(deflection * self._full[0 if deflection >= 0 else 1])
        wanted = pending.popleft()
        away = wanted - self._ramp
        grows = abs(wanted) > abs(self._ramp) and wanted * self._ramp >= 0.0
        most = self._accelerate if grows else self._brake
        slope = max(-most, min(most, away / STEP_S))
        if self._jerk != math.inf:
            # Limited, so that the jerk limit can end it in time.
            gentle = math.sqrt(2.0 * self._jerk * abs(away))
            slope = max(-gentle, min(gentle, slope))
            change = self._jerk * STEP_S
            slope = max(self._slope - change, min(self._slope + change, slope))
            if abs(away) < change * STEP_S:
                slope = away / STEP_S
        self._slope = slope
        self._ramp += slope * STEP_S
        new = self._ramp
        for n, lag_s in enumerate(self._lags):
            self._stages[n] += (new - self._stages[n]) * (1.0 - math.exp(-STEP_S / lag_s))
            new = self._stages[n]
        still = wanted == 0.0 and abs(self._ramp) < 1e-3 * self._full[0]
        if still and abs(new) < 0.01 * self._full[0]:
            new = 0.0
            self._ramp = self._slope = 0.0
            self._stages = [0.0] * len(self._stages)
        self.speed = new


class AttackedChair:
    """A chair with such axes in a profile, as slow to stop as `settings` permit."""

    def __init__(self, profile: str, kind: str, settings: Any, even_left: bool) -> None:
        self.x_m = self.y_m = self.heading_deg = 0.0
        self.speed_m_s = self.yaw_rate_deg_s = 0.0
        chair = CHAIRS[profile]
        at = list(CHAIRS).index(profile)

        def row(name: str) -> float:
            return float(getattr(settings, profile_row(at, name)))

        dead_s, lag_s = row("dead_time_ms") / 1000.0, row("lag_ms") / 1000.0
        early_s = 0.05
        sampled_s = _SAMPLING_STEPS * STEP_S if kind == "sampled" else 0.0
        linear_s = early_s if kind == "slow turn" else dead_s - sampled_s
        turn_s = early_s if kind == "slow drive" else dead_s - sampled_s
        full = (chair.linear.positive, chair.linear.negative)
        self._linear = AttackedAxis(full, linear_s, lag_s, row("brake_mm_s2") / 1000.0, kind)
        full = (chair.turn.positive, chair.turn.negative)
        self._turn = AttackedAxis(full, turn_s, lag_s, row("brake_dps2"), kind)
        uneven = _UNEVEN if kind == "uneven" else 1.0
        self._sides = (1.0, uneven) if even_left else (uneven, 1.0)
        self._every = _SAMPLING_STEPS if kind == "sampled" else 1
        self._steps = 0
        self._stick = (0.0, 0.0)

    def place(self, x_m: float, y_m: float, heading_deg: float) -> None:
        """Put the chair there, standing."""
        self.x_m, self.y_m, self.heading_deg = x_m, y_m, heading_deg

    def step(self, dt_s: float, stick: tuple[float, float] | None) -> None:
        """10 ms; `stick` is (linear, turn), each -1..1."""
        if self._steps % self._every == 0:
            self._stick = stick or (0.0, 0.0)
        self._steps += 1
        self._linear.step(self._stick[0])
        self._turn.step(self._stick[1])
        aside = math.radians(self._turn.speed) * HALF_TRACK_M
        left = (self._linear.speed - aside) * self._sides[0]
        right = (self._linear.speed + aside) * self._sides[1]
        self.speed_m_s = 0.5 * (left + right)
        self.yaw_rate_deg_s = math.degrees((right - left) / (2.0 * HALF_TRACK_M))
        middle = math.radians(self.heading_deg + 0.5 * self.yaw_rate_deg_s * dt_s)
        self.x_m += self.speed_m_s * math.cos(middle) * dt_s
        self.y_m += self.speed_m_s * math.sin(middle) * dt_s
        self.heading_deg += self.yaw_rate_deg_s * dt_s


def attack(seed: int, profile: str, settings: Any) -> Attack:
    """The attack with that seed on a chair in `profile`."""
    chance = random.Random(f"attack {seed}")
    kind = KINDS[seed % len(KINDS)]
    for _ in range(_TRIES):
        hand, swings_s = _hand(chance, steady=bool(seed % 2))
        path = _path(hand, AttackedChair(profile, kind, settings, seed % 4 < 2))
        placed = _placed(chance, path, round(swings_s / STEP_S))
        if placed is not None:
            return Attack(placed[0], hand, kind, placed[1])
    raise RuntimeError(f"attack {seed}: no place for a post")


def attacked_chair(seed: int, profile: str, settings: Any) -> AttackedChair:
    """The chair of the attack with that seed."""
    return AttackedChair(profile, KINDS[seed % len(KINDS)], settings, seed % 4 < 2)


def _hand(chance: random.Random, steady: bool) -> tuple[tuple[Hold, ...], float]:
    # The moves, and when the chair first swings aside.
    ahead = chance.choice((1, 1, -1))
    linear = ahead * chance.choice((150, 300, 600, 800, 1000))
    turn = chance.choice((1, -1)) * chance.choice((150, 300, 600, 1000))
    moves = []
    swings_s = 0.0
    if chance.random() < 0.4:  # from full speed
        swings_s = chance.uniform(0.8, 1.6)
        moves.append(Hold(swings_s, codes.DRIVE, ahead * FULL, 0, True))
    if steady:
        for_s = chance.choice((0.4, 0.8, 1.5, 2.5))
        moves.append(Hold(for_s, codes.DRIVE, linear, turn, not moves))
        return tuple(moves), swings_s
    for n in range(chance.randint(2, 5)):
        what = chance.random()
        if n and what < 0.3:
            turn = -turn
        elif n and what < 0.5:
            linear = -linear
        elif n:
            turn = round(turn * chance.uniform(0.2, 1.0))
            linear = round(linear * chance.uniform(0.2, 1.0))
        for_s = chance.choice((0.1, 0.2, 0.5, 1.0))
        moves.append(Hold(for_s, codes.DRIVE, linear, turn, not moves))
    return tuple(moves), swings_s


def _path(hand: tuple[Hold, ...], chair: AttackedChair) -> FloatArray:
    """Poses of the hand's path without any rule, until standstill: x, y, heading in radians."""
    poses = []

    def step(stick: tuple[float, float]) -> None:
        chair.step(STEP_S, stick)
        poses.append((chair.x_m, chair.y_m, math.radians(chair.heading_deg)))

    for move in hand:
        for _ in range(round(move.for_s / STEP_S)):
            step((move.linear / FULL, move.turn / FULL))
    for _ in range(300):
        step((0.0, 0.0))
        if chair.speed_m_s == 0.0 == chair.yaw_rate_deg_s:
            break
    return np.array(poses)


def in_view(
    mounts: tuple[Mount, ...],
    chair: AttackedChair,
    points: tuple[tuple[float, float], ...],
) -> bool:
    """True if one of these lidars sees one of these points from the chair's pose."""
    turned = math.radians(chair.heading_deg)
    for mount in mounts:
        angles_deg = np.arange(-180.0, 180.0)
        seen_deg = mount.pose.directions_deg(angles_deg[~in_arcs(angles_deg, mount.mask)])
        for x_m, y_m in points:
            dx, dy = x_m - chair.x_m, y_m - chair.y_m
            x = math.cos(turned) * dx + math.sin(turned) * dy - mount.pose.x_m
            y = math.cos(turned) * dy - math.sin(turned) * dx - mount.pose.y_m
            off_deg = half_turn_deg(seen_deg - math.degrees(math.atan2(y, x)))
            if np.abs(off_deg).min() <= 1.0:
                return True
    return False


def touched(room: Room, chair: Any) -> tuple[tuple[float, float], ...]:
    """Points of the room that the chair touches, 1 cm apart along its walls and solids."""
    sides = [*room.walls]
    for solid in room.solids():
        ends = (*solid.corners[1:], solid.corners[0])
        sides += [(*a, *b) for a, b in zip(solid.corners, ends, strict=True)]
    pose = np.array([(chair.x_m, chair.y_m, math.radians(chair.heading_deg))])
    found = []
    for x1, y1, x2, y2 in sides:
        for share in np.linspace(0.0, 1.0, max(2, round(math.hypot(x2 - x1, y2 - y1) / 0.01))):
            x, y = x1 + share * (x2 - x1), y1 + share * (y2 - y1)
            if _gaps(pose, x, y)[0] < _TOUCHING_M:
                found.append((x, y))
    return tuple(found)


def _placed(
    chance: random.Random, path: FloatArray, swings: int
) -> tuple[Room, tuple[tuple[float, float], ...]] | None:
    """An obstacle in the path's sweep and outside the straight path, and its points; or None."""
    x0, y0, turned = path[swings - 1] if swings else (0.0, 0.0, 0.0)
    reach = path[:, 0].min() + REAR_M - 0.2, path[:, 0].max() + FRONT_M + 0.2
    for _ in range(_TRIES):
        side = chance.choice((1, -1))
        wall = chance.random() < 0.3
        size = chance.uniform(0.04, 0.15)
        beside = HALF_WIDTH_M + chance.uniform(0.0, _BESIDE_M)
        # Where the straight path leads from the pose at which the chair begins to swing.
        ahead = chance.uniform(*reach)
        x = x0 + math.cos(turned) * ahead - math.sin(turned) * side * (beside + size / 2)
        y = y0 + math.sin(turned) * ahead + math.cos(turned) * side * (beside + size / 2)
        gaps = _gaps(path, x, y) - size / 2
        if gaps[0] < _FREE_M or gaps[: swings or 1].min() < _FREE_M or gaps[::_LOOK].min() > -0.01:
            continue
        h = _HALL_M
        walls = [(-h, -h, h, -h), (h, -h, h, h), (h, h, -h, h), (-h, h, -h, -h)]
        things: tuple[Solid, ...] = ()
        points: tuple[tuple[float, float], ...] = ((x, y), (x, y + side * 0.1))
        if wall:  # only its end is in the path
            far = y + side * 1.5
            walls.append((x, y, x, far))
            if _gaps(path[:1], x, y)[0] < _FREE_M:
                continue
        else:
            things = (box(x, y, size, size, 0.0, 1.0, "wood", chance.uniform(0, 90)),)
            points = tuple((float(px), float(py)) for px, py in things[0].corners)
        room = Room("attack", tuple(walls), things, start=(0.0, 0.0, 0.0))
        if room.clearance_m(0.0, 0.0, 0.0) > 0.0:
            return room, points
    return None


def _gaps(path: FloatArray, x: float, y: float) -> FloatArray:
    """Distance of a point to the chair at each pose, negative within."""
    c, s = np.cos(path[:, 2]), np.sin(path[:, 2])
    dx, dy = x - path[:, 0], y - path[:, 1]
    ahead, aside = c * dx + s * dy, c * dy - s * dx
    out = np.maximum(np.maximum(ahead - FRONT_M, REAR_M - ahead), np.abs(aside) - HALF_WIDTH_M)
    return np.asarray(out)
