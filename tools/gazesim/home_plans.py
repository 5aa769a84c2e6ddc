"""Generated homes: rooms on both sides of a corridor, furnished, lived in; all from one seed.

Every home's rooms are connected for the chair with all doors open: `home` checks it by a search
with its footprint, and takes furniture out until it is so.
"""

from __future__ import annotations

import math
import random
from functools import lru_cache

from gazesim import home_routes
from gazesim.homes import GLASS, MIRROR, Event, Home, Walker
from gazesim.rooms import Door, Solid, box

_WALL_M = 0.10
_DOOR_M = (0.95, 1.10)
_TALL_M = 2.5
_TRIES = 12
_BEGIN_S, _END_S = 20.0, 600.0  # of the script

Box = tuple[float, float, float, float]  # x0, y0, x1, y1


@lru_cache(maxsize=4)
def _routes(seed: int) -> tuple[_Plan, tuple[Solid, ...]]:
    chance = random.Random(f"home {seed}")
    for _ in range(_TRIES):
        plan = _Plan(chance)
        furniture = plan.furnish()
        for _ in range(_TRIES):
            home = plan.home(seed, tuple(furniture))
            lost = home_routes.unreached(home)
            if not lost:
                return plan, tuple(furniture)
            # What stands in the rooms that cannot be reached, and in the corridor, goes.
            near = [one for one in furniture if plan.room_of(one) in lost]
            for one in chance.sample(near, math.ceil(len(near) / 2)):
                furniture.remove(one)
            if not near:
                break
    raise AssertionError(f"no connected home of seed {seed}")


def home(seed: int) -> Home:
    """The home of that seed, afresh: furnished, all doors open, people at their beginnings."""
    plan, furniture = _routes(seed)
    made = plan.home(seed, furniture)
    chance = random.Random(f"life {seed}")
    made.people = tuple(plan.people(chance, made))
    made.script = tuple(plan.script(chance, made))
    return made


class _Plan:
    def __init__(self, chance: random.Random) -> None:
        self._chance = chance
        self.length = chance.uniform(9.0, 15.0)
        self.corridor = (0.0, chance.uniform(1.5, 2.1))  # y from, to
        self.above = chance.uniform(3.2, 5.0)
        self.below = chance.uniform(3.2, 4.6)
        self.rooms: dict[str, Box] = {}
        self.walls: list[Solid] = []
        self.doors: list[Door] = []
        self._keep: list[Box] = []  # free of furniture
        self._row("up", self.corridor[1], self.corridor[1] + self.above, True)
        self._row("down", -self.below, 0.0, False)
        self.rooms["corridor"] = (0.0, 0.0, self.length, self.corridor[1])
        self._shell()

    def _row(self, name: str, y0: float, y1: float, above: bool) -> None:
        chance, count = self._chance, self._chance.choice((2, 3, 3, 4))
        while self.length / count < 3.0:
            count -= 1
        cuts = [0.0]
        for k in range(1, count):
            cuts.append(self.length * k / count + chance.uniform(-0.4, 0.4))
        cuts.append(self.length)
        wall_y = y0 if above else y1
        for k in range(count):
            x0, x1 = cuts[k], cuts[k + 1]
            self.rooms[f"{name}{k}"] = (x0, y0, x1, y1)
            width = chance.uniform(*_DOOR_M)
            at = chance.uniform(x0 + 0.9 + width / 2, x1 - 0.9 - width / 2)
            if chance.random() < 0.2:  # open to the corridor, without a door
                width = min(chance.uniform(1.3, 2.2), x1 - x0 - 1.6)
                at = 0.5 * (x0 + x1)
            else:
                hinge, jamb = at - width / 2, at + width / 2
                if chance.random() < 0.5:
                    hinge, jamb = jamb, hinge
                swing = (1 if above else -1) * (1 if jamb > hinge else -1)
                self.doors.append(Door(f"{name}{k}", (hinge, wall_y), (jamb, wall_y), swing))
            self._wall(x0, wall_y, at - width / 2, wall_y)
            self._wall(at + width / 2, wall_y, x1, wall_y)
            self._keep.append((at - 0.9, wall_y - 1.6, at + 0.9, wall_y + 1.6))
            if k:
                self._between(x0, y0, y1)

    def _between(self, x: float, y0: float, y1: float) -> None:
        """A wall between two rooms, now and then with an opening or a pane of glass in it."""
        what = self._chance.random()
        if what < 0.25:
            middle = 0.5 * (y0 + y1)
            half = self._chance.uniform(0.5, 0.8)
            self._wall(x, y0, x, middle - half)
            self._wall(x, middle + half, x, y1)
            self._keep.append((x - 1.2, middle - half, x + 1.2, middle + half))
        elif what < 0.35:
            self._wall(x, y0, x, y0 + 1.0)
            self.walls.append(box(x, 0.5 * (y0 + 1.0 + y1), 0.02, y1 - y0 - 1.0, 0, _TALL_M, GLASS))
        else:
            self._wall(x, y0, x, y1)

    def _wall(self, x0: float, y0: float, x1: float, y1: float) -> None:
        length = math.hypot(x1 - x0, y1 - y0)
        turn = math.degrees(math.atan2(y1 - y0, x1 - x0))
        middle = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
        self.walls.append(box(*middle, length, _WALL_M, 0, _TALL_M, "wall", turn))

    def _shell(self) -> None:
        low, high = -self.below, self.corridor[1] + self.above
        for y in (low, high):
            if self._chance.random() < 0.4:  # a window down to the floor
                x = self._chance.uniform(1.0, self.length - 3.0)
                self._wall(-0.05, y, x, y)
                self.walls.append(box(x + 1.0, y, 2.0, 0.02, 0, _TALL_M, GLASS))
                self._wall(x + 2.0, y, self.length + 0.05, y)
            else:
                self._wall(-0.05, y, self.length + 0.05, y)
        for x in (0.0, self.length):
            self._wall(x, low, x, high)

    def furnish(self) -> list[Solid]:
        """Something in every room, along the walls and in the middle."""
        chance, found = self._chance, []
        for name, (x0, y0, x1, y1) in self.rooms.items():
            if name == "corridor":
                if chance.random() < 0.5:
                    x = chance.uniform(x0 + 0.5, x1 - 0.5)
                    found.append(box(x, y1 - 0.2, 0.6, 0.3, 0, 1.0, "cupboard"))
                continue
            for _ in range(chance.randint(2, 5)):
                long, deep = chance.uniform(0.5, 2.0), chance.uniform(0.35, 0.95)
                side = chance.randrange(4)
                away = chance.uniform(0.0, 0.06) + _WALL_M / 2 + deep / 2
                turn = 0.0 if side < 2 else 90.0
                if side < 2:
                    at = chance.uniform(x0 + long / 2, x1 - long / 2), (y0 + away, y1 - away)[side]
                else:
                    at = (
                        (x0 + away, x1 - away)[side - 2],
                        chance.uniform(y0 + long / 2, y1 - long / 2),
                    )
                if chance.random() < 0.2:
                    turn += chance.uniform(-20.0, 20.0)
                found.append(box(*at, long, deep, 0, chance.uniform(0.4, 1.9), "cupboard", turn))
            if chance.random() < 0.6:
                found += self._table(x0, y0, x1, y1)
            if chance.random() < 0.3:
                middle = chance.uniform(x0 + 0.5, x1 - 0.5), chance.uniform(y0 + 0.5, y1 - 0.5)
                found.append(_round(*middle, chance.uniform(0.12, 0.35), 0.5))
            if chance.random() < 0.25:
                y = chance.choice((y0 + 0.07, y1 - 0.07))
                x = chance.uniform(x0 + 0.8, x1 - 0.8)
                found.append(box(x, y, chance.uniform(0.5, 1.4), 0.02, 0, 1.9, MIRROR))
        return [one for one in found if not self._kept_free(one)]

    def _table(self, x0: float, y0: float, x1: float, y1: float) -> list[Solid]:
        chance = self._chance
        long, wide = chance.uniform(0.8, 1.6), chance.uniform(0.7, 1.0)
        x, y = chance.uniform(x0 + 1, x1 - 1), chance.uniform(y0 + 1, y1 - 1)
        legs = [
            box(x + i * long / 2, y + j * wide / 2, 0.06, 0.06, 0, 0.72, "wood")
            for i in (1, -1)
            for j in (1, -1)
        ]
        seats = [
            box(x + i * (long / 2 + 0.25), y, 0.42, 0.42, 0, 0.46, "wood", chance.uniform(-30, 30))
            for i in (1, -1)
            if chance.random() < 0.7
        ]
        return legs + seats

    def _kept_free(self, one: Solid) -> bool:
        xs, ys = [c[0] for c in one.corners], [c[1] for c in one.corners]
        return any(
            min(xs) < x1 and max(xs) > x0 and min(ys) < y1 and max(ys) > y0
            for x0, y0, x1, y1 in self._keep
        )

    def room_of(self, one: Solid) -> str:
        """The room that a piece of furniture is in."""
        x = sum(c[0] for c in one.corners) / len(one.corners)
        y = sum(c[1] for c in one.corners) / len(one.corners)
        for name, (x0, y0, x1, y1) in self.rooms.items():
            if x0 <= x <= x1 and y0 <= y <= y1:
                return name
        return ""

    def home(self, seed: int, furniture: tuple[Solid, ...]) -> Home:
        """With this furniture, nobody in it."""
        doors = tuple(Door(d.name, d.hinge, d.jamb, d.swing) for d in self.doors)
        places = {
            name: (0.5 * (x0 + x1), 0.5 * (y0 + y1))
            for name, (x0, y0, x1, y1) in self.rooms.items()
        }
        x, y = places["corridor"]
        return Home(
            f"home {seed}", (), (*self.walls, *furniture), doors, start=(x, y, 0.0), places=places
        )

    def people(self, chance: random.Random, home: Home) -> list[Walker]:
        """Up to three, each to and fro in one room or along the corridor."""
        found = []
        for name in chance.sample(sorted(self.rooms), chance.randint(1, 3)):
            x0, y0, x1, y1 = self.rooms[name]
            ends = [
                (chance.uniform(x0 + 0.5, x1 - 0.5), chance.uniform(y0 + 0.4, y1 - 0.4))
                for _ in range(chance.randint(2, 4))
            ]
            found.append(Walker(tuple(ends), chance.uniform(0.3, 1.1)))
        return found

    def script(self, chance: random.Random, home: Home) -> list[Event]:
        """Doors close for a while, chairs are moved a little."""
        found = []
        for door in home.doors:
            if chance.random() < 0.4:
                at_s = chance.uniform(_BEGIN_S, _END_S)
                found.append(Event(at_s, door=door.name, opens=False))
                found.append(Event(at_s + chance.uniform(20, 90), door=door.name, opens=True))
        first = len(self.walls)
        loose = [k for k in range(first, len(home.furniture)) if _is_loose(home.furniture[k])]
        for piece in chance.sample(loose, min(len(loose), chance.randint(0, 4))):
            one = home.furniture[piece]
            dx, dy = chance.uniform(-0.25, 0.25), chance.uniform(-0.25, 0.25)
            moved = Solid(
                tuple((x + dx, y + dy) for x, y in one.corners), one.z0_m, one.z1_m, one.material
            )
            found.append(Event(chance.uniform(_BEGIN_S, _END_S), piece=piece, solid=moved))
        return found


def _is_loose(one: Solid) -> bool:
    xs, ys = [c[0] for c in one.corners], [c[1] for c in one.corners]
    return one.material == "wood" and 0.2 < max(xs) - min(xs) < 0.7 and max(ys) - min(ys) < 0.7


def _round(x: float, y: float, radius: float, height: float) -> Solid:
    angles = [2.0 * math.pi * k / 12 for k in range(12)]
    corners = tuple((x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles)
    return Solid(corners, 0.0, height, "pot")
