"""A flat of four rooms around a corridor, and what lidars see on a drive through it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from gazechair.base.arrays import FloatArray
from gazesim.lidar_noise import NOISE_M
from gazesim.rooms import Person, Room, box

BEAMS = 360
_FARTHEST_M = 18.0
_WALL_M = 0.1


def _wall(x1: float, y1: float, x2: float, y2: float) -> object:
    length, wide = abs(x2 - x1) + _WALL_M, abs(y2 - y1) + _WALL_M
    return box((x1 + x2) / 2, (y1 + y2) / 2, length, wide, 0.0, 2.5, "wall")


def flat(*more: object, people: Sequence[Person] = ()) -> Room:
    """10 m by 8 m; the corridor runs along y = 4, doors are 1 m wide."""
    walls = (
        _wall(0, 0, 10, 0),
        _wall(0, 8, 10, 8),
        _wall(0, 0, 0, 8),
        _wall(10, 0, 10, 8),
        *(_wall(a, y, b, y) for y in (3.3, 4.7) for a, b in ((0, 1.5), (2.5, 7), (8, 10))),
        _wall(4.2, 0, 4.2, 3.3),
        _wall(5.5, 4.7, 5.5, 8),
    )
    furniture = (
        box(1.0, 0.6, 1.6, 0.8, 0.0, 0.9, "sofa"),
        box(3.7, 1.8, 0.4, 1.2, 0.0, 1.8, "cupboard"),
        box(9.3, 1.5, 0.8, 2.0, 0.0, 0.6, "bed"),
        box(5.0, 0.4, 1.0, 0.4, 0.0, 1.8, "cupboard"),
        box(0.5, 7.0, 0.6, 1.4, 0.0, 0.8, "desk"),
        box(3.6, 7.6, 1.4, 0.5, 0.0, 1.0, "cupboard"),
        box(9.5, 6.2, 0.5, 0.9, 0.0, 1.5, "fridge"),
        box(7.2, 7.5, 1.2, 0.7, 0.0, 0.8, "table", 20.0),
    )
    return Room("flat", (), (*walls, *furniture, *more), people=tuple(people))  # type: ignore[arg-type]


# Through every room, and through the corridor twice.
ROUTE = (
    *((2.0, 4.0), (2.0, 1.8), (2.0, 4.0), (7.5, 4.0), (7.5, 1.8), (7.5, 6.2), (7.5, 4.0)),
    *((2.0, 4.0), (2.0, 6.2), (2.0, 4.0), (4.0, 4.0)),
)


def poses(
    route: Sequence[tuple[float, float]] = ROUTE, step_m: float = 0.3
) -> Iterator[FloatArray]:
    """(3,) poses along a route, headings in radians: the chair turns on the spot at corners."""
    heading = 0.0
    for (ax, ay), (bx, by) in pairwise(route):
        wanted = math.atan2(by - ay, bx - ax)
        turn = (wanted - heading + math.pi) % (2.0 * math.pi) - math.pi
        for share in np.linspace(0.0, 1.0, max(2, round(abs(turn) / math.radians(15.0)))):
            yield np.array((ax, ay, heading + share * turn))
        heading += turn
        length_m = math.hypot(bx - ax, by - ay)
        for share in np.linspace(0.0, 1.0, max(2, round(length_m / step_m))):
            yield np.array((ax + share * (bx - ax), ay + share * (by - ay), heading))


def scan(
    room: Room, pose: FloatArray, chance: np.random.Generator, half_deg: float = 180.0
) -> tuple[FloatArray, FloatArray]:
    """Bearings in radians and distances in m of a lidar on the drive axle; 0: no return."""
    bearings = np.radians(np.linspace(-half_deg, half_deg, BEAMS, endpoint=False))
    metres = room.cast(float(pose[0]), float(pose[1]), bearings + pose[2], 0.25)
    seen = metres < _FARTHEST_M
    noisy = metres[seen] + chance.normal(0.0, NOISE_M, int(seen.sum()))
    found = np.zeros(BEAMS)
    found[seen] = noisy
    return bearings, found


def points(bearings: FloatArray, metres: FloatArray) -> FloatArray:
    """(N, 2) in the chair's frame."""
    seen = metres > 0.0
    turned = bearings[seen]
    return np.asarray(metres[seen, None] * np.stack((np.cos(turned), np.sin(turned)), axis=1))
