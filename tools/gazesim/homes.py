"""A home: rooms, doors that open and close, furniture that moves, people, glass and mirrors.

What happens by itself (a door, a moved chair) is a script in virtual time; people walk to and fro.
Everything true is an attribute, for judges.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gazechair.base.arrays import FloatArray
from gazesim import rays
from gazesim.rooms import Person, Room, Solid

GLASS, MIRROR = "glass", "mirror"
FARTHEST_M = 30.0
_STRAIGHT_DEG = 8.0  # glass returns beams that meet it this straight, and lets all others through
_LEG_M, _APART_M, _STRIDE_M = 0.055, 0.09, 0.35
_PATIENCE_S = 4.0  # near the chair, all in all
_NEAR_M = 1.6
_REST_S = 20.0
_AWAY = (1e3, 1e3)
_WAY_M = 0.06
_ROOM_M = 0.25  # nothing is moved, no door swings this near to the chair


@dataclass
class Walker(Person):
    """A person of whom a lidar near the floor sees two legs; out of the way after a while."""

    blocked_s: float = 0.0
    rests_s: float = 0.0

    def walk(self, dt_s: float) -> tuple[float, float]:
        """As a Person; one who left the way to the chair comes back after a while."""
        if self.rests_s > 0.0:
            self.rests_s -= dt_s
            return self.x_m, self.y_m
        if (self.x_m, self.y_m) == _AWAY:
            return self.path[0]
        return super().walk(dt_s)

    def wait(self, dt_s: float) -> None:
        """The chair is in the way: after a while, leave it the room."""
        self.blocked_s += dt_s
        if self.blocked_s > _PATIENCE_S:
            self.blocked_s, self.rests_s = 0.0, _REST_S
            self.x_m, self.y_m = _AWAY
            self._next, self._way = min(1, len(self.path) - 1), 1

    def legs(self) -> list[tuple[float, float, float]]:
        """Both legs as x, y, radius."""
        if len(self.path) == 1:
            dx, dy, left = 1.0, 0.0, 0.0
        else:
            goal = self.path[self._next]
            dx, dy = goal[0] - self.x_m, goal[1] - self.y_m
            left = math.hypot(dx, dy)
            dx, dy = (dx / left, dy / left) if left > 1e-9 else (1.0, 0.0)
        swing = 0.5 * _STRIDE_M * math.sin(math.pi * left / _STRIDE_M)
        return [
            (
                self.x_m - side * _APART_M * dy + side * swing * dx,
                self.y_m + side * _APART_M * dx + side * swing * dy,
                _LEG_M,
            )
            for side in (1.0, -1.0)
        ]


@dataclass(frozen=True)
class Event:
    """At `at_s` the door `door` opens or closes, or furniture `piece` is put where `solid` is."""

    at_s: float
    door: str = ""
    opens: bool = True
    piece: int = -1
    solid: Solid | None = None


@dataclass
class Home(Room):
    """Several rooms. `places`: a place in each that the chair can reach, by the room's name.

    The lidar's view of it (`cast`) knows glass, mirrors and legs.
    """

    places: dict[str, tuple[float, float]] = field(default_factory=dict)
    script: tuple[Event, ...] = ()
    time_s: float = 0.0
    _sights: dict[float, tuple[FloatArray, FloatArray]] = field(default_factory=dict)
    _due: list[Event] | None = None

    def changed(self) -> None:
        """Something in it has moved."""
        super().changed()
        self._sights = {}

    def walk(
        self,
        dt_s: float,
        x_m: float,
        y_m: float,
        heading_deg: float,
        way: Sequence[tuple[float, float, float]] = (),
    ) -> None:
        """`step`, and what the script says; nothing comes closer than 0.25 m to the chair.

        `way`: poses that the chair is about to take; no furniture is put there.
        """
        self.time_s += dt_s
        self.step(dt_s, x_m, y_m, heading_deg)
        for person in self.people:
            near = math.dist((person.x_m, person.y_m), (x_m, y_m)) < _NEAR_M
            if isinstance(person, Walker) and near:
                person.wait(dt_s)
        if self._due is None:
            self._due = sorted(self.script, key=lambda event: event.at_s)
        while self._due and self._due[0].at_s <= self.time_s:
            event = self._due.pop(0)
            if not self._happens(event, (x_m, y_m, heading_deg), way):
                self._due.append(replace(event, at_s=self.time_s + 1.0))
                self._due.sort(key=lambda one: one.at_s)

    def _happens(
        self,
        event: Event,
        pose: tuple[float, float, float],
        way: Sequence[tuple[float, float, float]],
    ) -> bool:
        if event.door:
            door = next(one for one in self.doors if one.name == event.door)
            before = door.open
            self.set_door(event.door, event.opens)
            if before != event.opens and self.clearance_m(*pose) < _ROOM_M:
                self.set_door(event.door, before)
                return False
        elif event.solid is not None:
            before_all = self.furniture
            kept = list(before_all)
            kept[event.piece] = event.solid
            self.furniture = tuple(kept)
            self.changed()
            near = self.clearance_m(*pose) < _ROOM_M
            if near or any(self.clearance_m(*one) < _WAY_M for one in way):
                self.furniture = before_all
                self.changed()
                return False
        return True

    def cast(self, x_m: float, y_m: float, angles_rad: FloatArray, height_m: float) -> FloatArray:
        """As a Room's; any order of angles."""
        turned = np.asarray(angles_rad) % (2.0 * math.pi)
        order = np.argsort(turned, kind="stable")
        found = np.empty(len(order))
        here = np.full(len(order), x_m), np.full(len(order), y_m)
        found[order] = self.cast_moving(*here, turned[order], height_m)
        return found

    def cast_moving(
        self, x_m: FloatArray, y_m: FloatArray, angles_rad: FloatArray, height_m: float
    ) -> FloatArray:
        """Distance along each beam from its own origin; ascending angles within one turn."""
        rows, kinds = self._sight(height_m)
        distance, which = rays.cast(x_m, y_m, angles_rad, rows, FARTHEST_M)
        kind = np.where(which >= 0, kinds[which], 0.0)
        through = np.flatnonzero(kind == 1.0)
        if len(through):
            normal = np.arctan2(
                rows[which[through], 2] - rows[which[through], 0],
                rows[which[through], 1] - rows[which[through], 3],
            )
            slant = np.abs((angles_rad[through] - normal + math.pi / 2) % math.pi - math.pi / 2)
            through = through[slant > math.radians(_STRAIGHT_DEG)]
            solid = np.flatnonzero(kinds != 1.0)
            behind = rays.cast(
                x_m[through], y_m[through], angles_rad[through], rows[solid], FARTHEST_M
            )
            distance[through] = behind[0]
        mirrored = np.flatnonzero(kind == 2.0)
        legs = [
            leg for person in self.people if isinstance(person, Walker) for leg in person.legs()
        ]
        discs = np.array(legs, dtype=np.float64).reshape(-1, 3)
        if len(mirrored):
            distance[mirrored] += _reflected(
                x_m[mirrored] + distance[mirrored] * np.cos(angles_rad[mirrored]),
                y_m[mirrored] + distance[mirrored] * np.sin(angles_rad[mirrored]),
                angles_rad[mirrored],
                rows[which[mirrored]],
                rows,
                discs,
            )
        return np.minimum(distance, rays.cast_discs(x_m, y_m, angles_rad, discs))

    def _sight(self, height_m: float) -> tuple[FloatArray, FloatArray]:
        """Segments that a plane at that height cuts, and their kinds: 1 glass, 2 mirror."""
        found = self._sights.get(height_m)
        if found is None:
            rows, kinds = list(self.walls), [0.0] * len(self.walls)
            for solid in self.solids():
                if solid.z0_m <= height_m <= solid.z1_m:
                    edges = solid.edges()
                    kind = {GLASS: 1.0, MIRROR: 2.0}.get(solid.material, 0.0)
                    rows += edges
                    kinds += [kind] * len(edges)
            found = np.array(rows, dtype=np.float64).reshape(-1, 4), np.array(kinds)
            self._sights[height_m] = found
        return found


def _reflected(
    x_m: FloatArray,
    y_m: FloatArray,
    angles_rad: FloatArray,
    mirrors: FloatArray,
    rows: FloatArray,
    discs: FloatArray,
) -> FloatArray:
    """How far each beam goes on after its mirror."""
    along = np.arctan2(mirrors[:, 3] - mirrors[:, 1], mirrors[:, 2] - mirrors[:, 0])
    onward = 2.0 * along - angles_rad
    dx, dy = np.cos(onward)[:, None], np.sin(onward)[:, None]
    ax, ay = rows[:, 0] - x_m[:, None], rows[:, 1] - y_m[:, None]
    ex, ey = rows[:, 2] - rows[:, 0], rows[:, 3] - rows[:, 1]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        inverse = 1.0 / (dx * ey - dy * ex)
        far = (ax * ey - ay * ex) * inverse
        share = (ax * dy - ay * dx) * inverse
        far[~((far > 1e-6) & (share >= 0.0) & (share <= 1.0))] = np.inf
    nearest: FloatArray = np.minimum(far.min(axis=1), rays.cast_discs(x_m, y_m, onward, discs))
    return nearest
