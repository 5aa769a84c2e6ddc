"""Plans of the available rooms, by name; `home-7` is the generated home of seed 7."""

from __future__ import annotations

from collections.abc import Callable

from gazesim import home_plans
from gazesim.home_routes import Router
from gazesim.homes import Home
from gazesim.rooms import Door, Person, Room, box

_HOME = "home-"


def _rectangle(
    x0: float, y0: float, x1: float, y1: float
) -> tuple[tuple[float, float, float, float], ...]:
    return ((x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0))


def _open() -> Room:
    """A hall 20 m square, nothing near: for turns and speeds."""
    return Room("open", _rectangle(-10, -10, 10, 10))


def _wall() -> Room:
    """A straight run of 4 m from the chair's origin to a wall, 2 m of space at both sides."""
    return Room("wall", _rectangle(-2, -2, 4, 2))


def _living() -> Room:
    """A living room of 6 x 5 m with furniture, a door to a hallway, someone walking there."""
    walls = (
        (-1.5, -2.5, 4.5, -2.5),  # right-hand wall
        (4.5, -2.5, 4.5, 4.1),  # far wall, hallway's end included
        (4.5, 4.1, -1.5, 4.1),  # hallway's left wall
        (-1.5, 4.1, -1.5, -2.5),  # wall behind
        (-1.5, 2.5, 1.6, 2.5),  # between living room and hallway, up to the door
        (2.6, 2.5, 4.5, 2.5),
    )
    table_legs = tuple(
        box(3.3 + dx, -1.2 + dy, 0.06, 0.06, 0.0, 0.72, "wood")
        for dx in (-0.35, 0.35)
        for dy in (-0.55, 0.55)
    )
    furniture = (
        box(0.6, -2.05, 2.0, 0.85, 0.0, 0.42, "sofa"),  # sofa along the right-hand wall
        box(0.6, -2.38, 2.0, 0.22, 0.42, 0.85, "sofa"),
        box(4.25, 1.3, 0.45, 1.6, 0.0, 1.9, "cupboard"),
        box(-1.25, 1.6, 0.45, 1.2, 0.0, 0.8, "cupboard"),
        *table_legs,
        box(3.3, -1.2, 0.9, 1.4, 0.72, 0.76, "wood"),  # the lidar sees only its legs
        box(2.5, -1.2, 0.42, 0.42, 0.0, 0.46, "wood"),  # chair at the table
        box(2.3, -1.2, 0.05, 0.42, 0.46, 0.9, "wood"),
        box(-1.2, -2.2, 0.35, 0.35, 0.0, 0.35, "pot"),  # plant
        box(-1.2, -2.2, 0.55, 0.55, 0.35, 1.3, "plant", 30),
        box(4.48, -1.2, 0.03, 1.6, 0.9, 2.1, "window"),
        box(0.0, 2.48, 0.9, 0.03, 1.2, 1.8, "picture"),
        box(4.48, 3.3, 0.03, 0.9, 0.0, 2.05, "door"),  # front door at the hallway's end
        box(2.1, 2.5, 1.0, 0.1, 2.05, 2.5, "wall"),  # lintel
    )
    return Room(
        "living",
        walls,
        furniture,
        (Door("hallway", (2.6, 2.5), (1.6, 2.5), swing=1),),
        (Person(((0.5, 3.3), (3.9, 3.3))),),
        start=(0.0, 0.2, 0.0),
    )


FLAT_PLACES = {
    "Keuken": ("kitchen", 5.9, 0.9, 90.0),
    "Bank": ("sofa", 1.3, 1.2, 180.0),
    "Raam": ("window", 1.6, -0.9, 0.0),
}
"""Of the flat, where the chair can stand: sign, x, y in metres, heading in degrees."""


def _flat() -> Room:
    """A living room and a kitchen with a wide opening between them; nobody walks there."""
    wall = 0.1
    solids = (
        box(3.6, -1.55, wall, 1.9, 0.0, 2.5, "wall"),  # the opening is 1.3 m wide
        box(3.6, 1.6, wall, 1.8, 0.0, 2.5, "wall"),
        box(0.2, -2.1, 1.9, 0.75, 0.0, 0.8, "sofa"),
        box(-1.25, 1.7, 0.45, 1.3, 0.0, 1.9, "cupboard"),
        box(2.5, 2.25, 1.2, 0.45, 0.0, 0.8, "cupboard"),
        box(5.8, 2.2, 2.2, 0.6, 0.0, 0.9, "wood"),  # the kitchen's counter
        box(6.7, -0.6, 0.6, 1.4, 0.0, 1.8, "cupboard"),
        box(4.4, -2.2, 1.0, 0.6, 0.0, 0.75, "wood"),
    )
    return Room("flat", _rectangle(-1.5, -2.5, 7.0, 2.5), solids, start=(0.6, 0.0, 0.0))


_ROOMS: dict[str, Callable[[], Room]] = {
    "living": _living,
    "wall": _wall,
    "open": _open,
    "flat": _flat,
}


def names() -> tuple[str, ...]:
    """The names of all rooms, homes aside."""
    return tuple(_ROOMS)


def room(name: str) -> Room:
    """A fresh room of that name; ValueError when there is none."""
    number = name.removeprefix(_HOME)
    if number != name and number.isdecimal():
        return _home(int(number))
    if name not in _ROOMS:
        raise ValueError(f"no room {name!r}; there are {', '.join(_ROOMS)}, {_HOME}NUMBER")
    return _ROOMS[name]()


def _home(seed: int) -> Home:
    """The chair starts where it has room to turn, in the first room that has such a place."""
    home = home_plans.home(seed)
    router = Router(home)
    found = (router.place(*home.places[one]) for one in sorted(home.places))
    home.start = (*next(one for one in found if one is not None), 0.0)
    return home
