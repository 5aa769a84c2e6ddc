"""Random rooms with a task for the chair: doors, narrow passages, furniture, people who walk in.

Everything follows from one seed. All obstacles are in the lidar's plane; tables have only
legs, because a lidar at that height never sees their tops.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass

from gazelink import codes
from gazesim import chair
from gazesim.rooms import Room, Solid, box

KINDS = ("door", "way", "room", "people")
WALKER_M_S = 1.0
WALKER_RADIUS_M = 0.22
_HALL_M = 5.0
_PEOPLE_HALL_M = 8.0  # people start inside its walls
_TRIES = 200
_VERBS = (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT)


@dataclass(frozen=True)
class Walker:
    """A person who walks straight on and never waits. Stands still before `from_s`."""

    x_m: float
    y_m: float
    heading_deg: float
    from_s: float

    def at(self, time_s: float) -> tuple[float, float]:
        """The person's position."""
        way = WALKER_M_S * max(0.0, time_s - self.from_s)
        angle = math.radians(self.heading_deg)
        return self.x_m + way * math.cos(angle), self.y_m + way * math.sin(angle)


@dataclass(frozen=True)
class Task:
    """One run: the chair starts at `room.start` and `verb` (codes.FORWARD ...) stays pressed.

    `goal`: metres, or degrees for a turn, after which the driver releases it.
    """

    kind: str
    room: Room
    verb: int
    goal: float
    walker: Walker | None = None


def task(kind: str, seed: int) -> Task:
    """The task of that kind with that seed. Raises ValueError for an unknown kind."""
    if kind not in KINDS:
        raise ValueError(f"no kind of task {kind!r}; there are {', '.join(KINDS)}")
    chance = random.Random(f"{kind} {seed}")
    return {"door": _door, "way": _way, "room": _room, "people": _people}[kind](chance)


def door_task(
    width_m: float, depth_m: float, offset_m: float, heading_deg: float, before_m: float
) -> Task:
    """Through a door `width_m` wide in a wall `depth_m` thick at x = 0.

    The path crosses the middle of the opening `offset_m` off its centre, `heading_deg` off the
    straight; the chair's front starts `before_m` in front of the wall.
    """
    way = before_m + chair.FRONT_M + depth_m / 2
    angle = math.radians(heading_deg)
    start = (-way * math.cos(angle), offset_m - way * math.sin(angle), heading_deg)
    posts = tuple(
        box(0.0, side * (width_m / 2 + 1.5), depth_m, 3.0, 0.0, 2.05, "wall") for side in (1, -1)
    )
    return Task("door", Room("door", _square(), posts, start=start), codes.FORWARD, way + 1.0)


def wall_task(gap_m: float, length_m: float = 4.0, left: bool = True) -> Task:
    """Along a wall, `gap_m` from the chair's side."""
    side = (1 if left else -1) * (chair.HALF_WIDTH_M + gap_m)
    wall = (-1.5, side, length_m + 3.5, side)
    room = Room("wall", (*_square(), wall), start=(0.0, 0.0, 0.0))
    return Task("way", room, codes.FORWARD, length_m)


def _square(half_m: float = _HALL_M) -> tuple[tuple[float, float, float, float], ...]:
    h = half_m
    return ((-h, -h, h, -h), (h, -h, h, h), (h, h, -h, h), (-h, h, -h, -h))


def _door(chance: random.Random) -> Task:
    width = chance.uniform(0.84, 1.15)
    spare = max(0.0, (width - 2 * chair.HALF_WIDTH_M) / 2 - 0.04)
    return door_task(
        width,
        chance.uniform(0.05, 0.25),
        chance.uniform(-1.2, 1.2) * spare,
        chance.uniform(-3.0, 3.0),
        chance.uniform(0.3, 1.5),
    )


def _way(chance: random.Random) -> Task:
    # A passage with cupboards on one side, a wall on the other.
    gaps = [chance.choice((chance.uniform(0.06, 0.2), chance.uniform(0.2, 0.8))) for _ in "lr"]
    left, right = (chair.HALF_WIDTH_M + gap for gap in gaps)
    cupboards = []
    for _ in range(chance.randint(0, 3)):
        deep = chance.uniform(0.1, 0.5)
        x = chance.uniform(-0.5, 4.0)
        long = chance.uniform(0.3, 1.2)
        cupboards.append(box(x, left + deep / 2, long, deep, 0, 1.8, "cupboard"))
    walls = (
        (-4.0, -right, 4.9, -right),
        (-4.0, left + 0.5, 4.9, left + 0.5),
        (-4.0, -right, -4.0, left + 0.5),
    )
    start = (0.0, 0.0, chance.uniform(-1.0, 1.0))
    room = Room("way", (*walls, *_square()), tuple(cupboards), start=start)
    return Task("way", room, codes.FORWARD, chance.uniform(1.5, 2.8))


def _furniture(chance: random.Random) -> list[Solid]:
    half = 2.6
    found: list[Solid] = []
    for _ in range(chance.randint(4, 9)):
        x, y = chance.uniform(-half, half), chance.uniform(-half, half)
        turn = chance.choice((0.0, 90.0, chance.uniform(0, 180)))
        what = chance.random()
        if what < 0.35:  # a table: four legs
            long, wide = chance.uniform(0.6, 1.6), chance.uniform(0.6, 1.0)
            thick = chance.uniform(0.03, 0.07)
            c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
            for i in (-0.5, 0.5):
                for j in (-0.5, 0.5):
                    dx, dy = i * long, j * wide
                    at = (x + c * dx - s * dy, y + s * dx + c * dy)
                    found.append(box(*at, thick, thick, 0.0, 0.72, "wood", turn))
        elif what < 0.5:  # a chair, a pot
            size = chance.uniform(0.2, 0.45)
            found.append(box(x, y, size, size, 0.0, 0.5, "wood", turn))
        else:  # a cupboard, a sofa
            long, deep = chance.uniform(0.4, 2.0), chance.uniform(0.3, 0.9)
            found.append(box(x, y, long, deep, 0.0, 0.9, "sofa", turn))
    return found


def _room(chance: random.Random) -> Task:
    half = 3.0
    for _ in range(_TRIES):
        start = (chance.uniform(-2, 2), chance.uniform(-2, 2), chance.uniform(-180, 180))
        room = Room("room", _square(half), tuple(_furniture(chance)), start=start)
        if room.clearance_m(*start) >= 0.12:
            verb = chance.choices(_VERBS, (6, 2, 3, 3))[0]
            straight = verb in (codes.FORWARD, codes.BACKWARD)
            return Task("room", room, verb, chance.uniform(0.5, 3.0) if straight else 360.0)
    raise AssertionError("no free place in any of the rooms")


def _people(chance: random.Random) -> Task:
    # A person who reaches a place on the chair's path at about the same time as the chair.
    meet = (chance.uniform(1.0, 3.0), chance.uniform(-0.3, 0.3))
    heading = chance.uniform(60.0, 300.0)
    way = chance.uniform(1.5, 3.5)
    angle = math.radians(heading)
    walker = Walker(
        meet[0] - way * math.cos(angle),
        meet[1] - way * math.sin(angle),
        heading,
        chance.uniform(0.0, 8.0),
    )
    room = Room("people", _square(_PEOPLE_HALL_M), start=(0.0, 0.0, 0.0))
    return Task("people", room, codes.FORWARD, 3.0, walker)
