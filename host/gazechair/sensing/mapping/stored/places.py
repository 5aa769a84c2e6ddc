"""What people draw on a map: named places, no-go areas, a home spot."""

from __future__ import annotations

import itertools
import math
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from gazechair.base.refused import Refused

Corner = tuple[float, float]

ICONS = (
    *("star", "bed", "sofa", "table", "desk", "kitchen", "toilet", "bath", "tv", "window"),
    *("door", "garden", "lift", "charger"),
)
MOST_PLACES, MOST_AREAS = 50, 50
_MOST_NAME = 40  # characters
_MOST_CORNERS = 24
_MOST_NUMBER = 10**8 - 1  # a longer one does not fit into the name of a tile
_MOST_READ_NUMBER = (1 << 31) - 1
_LEAST_AREA_M2 = 0.01
FARTHEST_M = 1000.0


class EditRefused(Refused):
    """Raised when a caretaker's request is refused."""


@dataclass(frozen=True)
class Spot:
    """A pose in the map: metres, and the heading in degrees counter-clockwise."""

    x_m: float
    y_m: float
    heading_deg: float


@dataclass(frozen=True)
class Place:
    """A spot with a name."""

    number: int
    name: str
    icon: str
    """One of ICONS."""
    spot: Spot


@dataclass(frozen=True)
class Area:
    """A polygon that the chair must not enter by itself."""

    number: int
    corners_m: tuple[Corner, ...]


@dataclass(frozen=True)
class Drawn:
    """Everything that people drew on one map."""

    places: tuple[Place, ...] = ()
    no_go: tuple[Area, ...] = ()
    home: Spot | None = None
    last_place: int = 0
    last_area: int = 0
    """Highest numbers that were removed. None is used again: a request may come late."""

    def as_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "places": [
                {"number": one.number, "name": one.name, "icon": one.icon, **_spot(one.spot)}
                for one in self.places
            ],
            "no_go": [
                {"number": one.number, "corners": [list(corner) for corner in one.corners_m]}
                for one in self.no_go
            ],
            "home": None if self.home is None else _spot(self.home),
            "last_place": self.last_place,
            "last_area": self.last_area,
        }

    @property
    def spots_m(self) -> list[Corner]:
        """Everything that must lie on the map."""
        spots = [one.spot for one in self.places] + ([self.home] if self.home is not None else [])
        corners = [corner for area in self.no_go for corner in area.corners_m]
        return [(one.x_m, one.y_m) for one in spots] + corners

    def with_place(self, fields: Any) -> Drawn:
        """With one more place, or the one with the `number` in `fields` changed. EditRefused."""
        if not isinstance(fields, dict):
            raise EditRefused("map_request", "a place is an object")
        number = fields.get("number")
        name, icon = name_of(fields.get("name")), fields.get("icon")
        if icon not in ICONS:
            raise EditRefused("map_request", f"an icon is one of {', '.join(ICONS)}")
        others = self.places if number is None else _without(self.places, number)
        if any(same_name(one.name, name) for one in others):
            raise EditRefused("map_name_taken", f"there is a place {name} already")
        if len(others) >= MOST_PLACES:
            raise EditRefused("map_full", f"a map has at most {MOST_PLACES} places")
        kept = number if number is not None else _next(self.places, self.last_place)
        place = Place(kept, name, icon, spot_of(fields))
        return replace(self, places=(*others, place))

    def without_place(self, number: Any) -> Drawn:
        """Without that place. Raises EditRefused."""
        places = _without(self.places, number)
        return replace(self, places=places, last_place=max(number, self.last_place))

    def with_area(self, corners: Any) -> Drawn:
        """With one more no-go area. Raises EditRefused."""
        if len(self.no_go) >= MOST_AREAS:
            raise EditRefused("map_full", f"a map has at most {MOST_AREAS} areas")
        if not isinstance(corners, list) or not 3 <= len(corners) <= _MOST_CORNERS:
            raise EditRefused("map_area", f"an area has 3 to {_MOST_CORNERS} corners")
        if not all(isinstance(one, list) and len(one) == 2 for one in corners):
            raise EditRefused("map_area", "a corner is [x, y]")
        area = Area(
            _next(self.no_go, self.last_area), tuple((_metres(x), _metres(y)) for x, y in corners)
        )
        if _size_m2(area.corners_m) < _LEAST_AREA_M2:
            raise EditRefused("map_area", "the area has no extent")
        return replace(self, no_go=(*self.no_go, area))

    def without_area(self, number: Any) -> Drawn:
        """Without that area. Raises EditRefused."""
        no_go = _without(self.no_go, number)
        return replace(self, no_go=no_go, last_area=max(number, self.last_area))

    def with_home(self, fields: Any) -> Drawn:
        """With another home spot; `fields` None: without one. Raises EditRefused."""
        return replace(self, home=None if fields is None else spot_of(fields))


def drawn_of(fields: Any) -> Drawn:
    """What as_json gave. Raises EditRefused, KeyError or TypeError."""
    for rows in (fields["places"], fields["no_go"]):
        numbers = [row["number"] for row in rows]
        if any(type(one) is not int or not 0 < one <= _MOST_READ_NUMBER for one in numbers):
            raise EditRefused("map_request", "numbers are whole and positive")
        if len(set(numbers)) < len(numbers):
            raise EditRefused("map_request", "a number is there twice")
    drawn = Drawn(home=None if fields["home"] is None else spot_of(fields["home"]))
    for number, row in _numbered(fields["no_go"]):
        area = drawn.with_area(row["corners"]).no_go[-1]
        drawn = replace(drawn, no_go=(*drawn.no_go, replace(area, number=number)))
    for number, row in _numbered(fields["places"]):
        place = drawn.with_place({**row, "number": None}).places[-1]
        drawn = replace(drawn, places=(*drawn.places, replace(place, number=number)))
    last_place, last_area = (_last(fields.get(key, 0)) for key in ("last_place", "last_area"))
    return replace(drawn, last_place=last_place, last_area=last_area)


def name_of(text: Any) -> str:
    """A name as it is kept. Raises EditRefused."""
    if not isinstance(text, str) or len(text) > 10 * _MOST_NAME:
        raise EditRefused("map_name", f"a name has 1 to {_MOST_NAME} characters")
    name = " ".join(unicodedata.normalize("NFC", text).split())
    if not 1 <= len(name) <= _MOST_NAME:
        raise EditRefused("map_name", f"a name has 1 to {_MOST_NAME} characters")
    # Joiners of emoji are of the category Cf, and so is what turns the direction of writing.
    if any(unicodedata.category(one) in ("Cc", "Cs", "Co") for one in name) or any(
        "\u202a" <= one <= "\u202e" or "\u2066" <= one <= "\u2069" for one in name
    ):
        raise EditRefused("map_name", "a name is made of letters, digits and signs")
    return name


def free_name(name: str, others: list[str]) -> str:
    """`name`, with a number when one of the others has it."""
    short = name[: _MOST_NAME - 4].rstrip()
    tries = [name, *(f"{short} {number}" for number in range(2, len(others) + 3))]
    return next(one for one in tries if not any(same_name(one, other) for other in others))


def same_name(one: str, other: str) -> bool:
    """Whether people would take them for the same."""
    return one.casefold() == other.casefold()


def spot_of(fields: Any) -> Spot:
    """Of `x`, `y`, `heading`. Raises EditRefused."""
    if not isinstance(fields, dict):
        raise EditRefused("map_request", "a spot has x, y and heading")
    heading = _number(fields.get("heading"))
    return Spot(_metres(fields.get("x")), _metres(fields.get("y")), round(heading % 360.0, 1))


def _spot(spot: Spot) -> dict[str, float]:
    return {"x": spot.x_m, "y": spot.y_m, "heading": spot.heading_deg}


def _metres(value: Any) -> float:
    number = _number(value)
    if abs(number) > FARTHEST_M:
        raise EditRefused("map_outside", "that is not on the map")
    return round(number, 3)


def _number(value: Any) -> float:
    if type(value) not in (int, float) or not abs(value) < 1e9 or not math.isfinite(value):
        raise EditRefused("map_request", "x, y and heading are numbers")
    return float(value)


def _last(value: Any) -> int:
    if type(value) is not int or not 0 <= value <= _MOST_READ_NUMBER:
        raise EditRefused("map_request", "numbers are whole and positive")
    return value


def _next(rows: tuple[Place, ...] | tuple[Area, ...], last: int) -> int:
    taken = [one.number for one in rows]
    number = max(last, *taken, 0) + 1
    return number if number <= _MOST_NUMBER else _unused(taken)


def _unused(taken: Iterable[int]) -> int:
    among = set(taken)
    return next(one for one in itertools.count(1) if one not in among)


def _numbered(rows: list[dict[str, Any]]) -> list[tuple[int, dict[str, Any]]]:
    """Each row with its number; those with too long a one, from elsewhere, get unused ones."""
    taken = {row["number"] for row in rows}
    found = []
    for row in rows:
        number = row["number"]
        if number > _MOST_NUMBER:
            number = _unused(taken)
            taken.add(number)
        found.append((number, row))
    return found


def _without(rows: Any, number: Any) -> Any:
    kept = tuple(one for one in rows if one.number != number)
    if type(number) is not int or len(kept) == len(rows):
        raise EditRefused("map_gone", f"there is no number {number!r} any more")
    return kept


def _size_m2(corners_m: tuple[Corner, ...]) -> float:
    around = zip(corners_m, (*corners_m[1:], corners_m[0]), strict=True)
    return 0.5 * abs(sum(ax * by - bx * ay for (ax, ay), (bx, by) in around))
