"""Draws docs/architecture.svg: the rooms in their storeys, and an arrow for each import.

An arrow that a path of other arrows implies is omitted.
"""

from __future__ import annotations

from collections.abc import Iterable

from gazehouse.arrows import STOREYS, Arrow, arrows, imports, modules
from gazesetup import ROOT

DOCUMENT = ROOT / "docs" / "architecture.svg"

_WIDTH, _STOREY, _BOX_WIDTH, _BOX_HEIGHT = 1100, 84, 150, 40
# The folder of a room -> its colour.
_COLOURS = {
    "gazechair": "#cfe3f7",
    "gazeboard": "#f9dcc4",
    "gazelink": "#d8ecd2",
}
_OTHER = "#e8e4ef"

Place = tuple[float, float]


def render() -> str:
    """The drawing as SVG text."""
    found = _direct(arrows(imports(modules())))
    places = _places()
    height = _STOREY * len(STOREYS) + 10
    parts = [
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}"'
            ' font-family="sans-serif" font-size="15" text-anchor="middle">'
        ),
        f'<rect width="{_WIDTH}" height="{height}" fill="white"/>',
        (
            '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7"'
            ' markerHeight="7" orient="auto"><path d="M0 0L8 4L0 8z" fill="#888"/></marker></defs>'
        ),
        *_lines(found, places),
        *(_box(name, place) for name, place in places.items()),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _direct(found: list[Arrow]) -> list[Arrow]:
    """The arrows that no longer path of arrows implies."""
    ends: dict[str, set[str]] = {}
    for arrow in found:
        ends.setdefault(arrow.start, set()).add(arrow.end)

    def reached(start: str) -> set[str]:
        return ends.get(start, set()).union(*map(reached, ends.get(start, ())))

    return [
        arrow
        for arrow in found
        if not any(arrow.end in reached(other) for other in ends[arrow.start] - {arrow.end})
    ]


def _places() -> dict[str, Place]:
    """The middle of each room's box."""
    return {
        name: (_WIDTH * (at + 1) / (len(names) + 1), _STOREY * (storey + 0.5))
        for storey, names in enumerate(STOREYS)
        for at, name in enumerate(names)
    }


def _box(name: str, place: Place) -> str:
    x, y = place
    colour = _COLOURS.get(name.partition(".")[0], _OTHER)
    left, top = x - _BOX_WIDTH / 2, y - _BOX_HEIGHT / 2
    return (
        f'<rect x="{left:.0f}" y="{top:.0f}" width="{_BOX_WIDTH}" height="{_BOX_HEIGHT}" rx="8"'
        f' fill="{colour}" stroke="#555"/><text x="{x:.0f}" y="{y + 5:.0f}">{name}</text>'
    )


def _lines(found: Iterable[Arrow], places: dict[str, Place]) -> list[str]:
    """One line per arrow, thicker with more imports."""
    drawn = []
    for arrow in found:
        (x1, y1), (x2, y2) = places[arrow.start], places[arrow.end]
        width = min(4.0, 0.8 + len(arrow.imports) / 6)
        drawn.append(
            f'<line x1="{x1:.0f}" y1="{y1 + _BOX_HEIGHT / 2:.0f}" x2="{x2:.0f}"'
            f' y2="{y2 - _BOX_HEIGHT / 2:.0f}" stroke="#888" stroke-width="{width:.1f}"'
            ' marker-end="url(#tip)"/>'
        )
    return drawn
