"""Numbers of what is drawn: each that is accepted can be read back, and fits a tile's name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gazechair.producers.places import Places
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.stored import home_map
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.places import Drawn, EditRefused, drawn_of
from gazechair.sensing.mapping.stored.store import MapStore

BED = {"name": "Bed", "icon": "bed", "x": 1.0, "y": 0.5, "heading": 90.0}
DESK = {**BED, "name": "Desk", "icon": "desk"}
SQUARE = [[0.1, 0.1], [1.0, 0.1], [1.0, 1.0]]
MOST, MOST_READ = 99_999_999, 2_147_483_647


def read(*numbers: int) -> Drawn:
    """Places and areas with these numbers, as from a file."""
    return drawn_of(
        {
            "places": [{**BED, "name": f"Bed {one}", "number": one} for one in numbers],
            "no_go": [{"corners": SQUARE, "number": one} for one in numbers],
            "home": None,
        }
    )


def numbers(drawn: Drawn) -> list[int]:
    """Those of the places; the areas have the same."""
    found = [one.number for one in drawn.places]
    assert [one.number for one in drawn.no_go] == found
    return found


@pytest.mark.parametrize("number", [True, 1.0, "1", [1], 2, 0, -1, False])
def test_a_place_is_changed_by_its_whole_number_only(number: Any) -> None:
    drawn = Drawn().with_place(BED)
    with pytest.raises(EditRefused) as caught:
        drawn.with_place({**DESK, "number": number})
    assert caught.value.reason == "map_gone"
    changed = drawn.with_place({**DESK, "number": 1})
    assert [(one.number, one.name) for one in changed.places] == [(1, "Desk")]


def test_after_the_highest_number_an_unused_one_is_next() -> None:
    drawn = read(1, 3, MOST)
    for _ in range(2):
        drawn = drawn.with_place({**DESK, "name": f"Desk {len(drawn.places)}"}).with_area(SQUARE)
    assert numbers(drawn) == [1, 3, MOST, 2, 4]
    assert drawn_of(drawn.as_json()) == drawn
    assert numbers(read(1, 3).with_place(DESK).with_area(SQUARE)) == [1, 3, 4]


def test_a_number_from_elsewhere_that_fits_no_tile_is_replaced(tmp_path: Path) -> None:
    drawn = read(MOST_READ, 2, MOST + 1, MOST)
    assert numbers(drawn) == [1, 2, 3, MOST]
    with pytest.raises(EditRefused):
        read(MOST_READ + 1)
    cells = np.full((40, 40), 5, dtype=np.uint16)
    grid = OccupancyGrid(0.05, np.zeros(2), cells, cells)
    foreign = replace(drawn.places[0], number=MOST_READ)
    HomeMap("home", grid, drawn=replace(drawn, places=(foreign,))).save(tmp_path / "a.map")
    store = MapStore(tmp_path)
    tiles = Places(store, lambda: "a", lambda: True)
    assert [one.name for one in tiles().values()] == [f"Bed {MOST_READ}"]
    store.draw("a", "place", DESK)
    store.draw("a", "place", {**BED, "name": "New bed", "number": 1})
    assert sorted(one.name for one in tiles().values()) == ["Desk", "New bed"]
    assert sorted(one.number for one in home_map.load(tmp_path / "a.map").drawn.places) == [1, 2]
