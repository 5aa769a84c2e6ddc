"""Several maps: each that is read is a sign of life; after a lift ride the old one is forgotten."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np
import pytest

from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, occupancy_of
from gazechair.sensing.mapping.locating.atlas import Atlas
from gazechair.sensing.mapping.locating.location import Location
from gazechair.sensing.mapping.locating.looks import Seen
from gazechair.sensing.mapping.locating.map_match import Look
from gazechair.sensing.odometry.estimate import Estimate
from gazesim.rooms import Room
from homerig import flat, points, poses, scan

pytestmark = pytest.mark.costly

CHANCE = np.random.default_rng(8)
HERE = np.array((2.0, 1.8, 0.7))
CABIN = Room("cabin", ((1, 1, 3, 1), (3, 1, 3, 2.6), (3, 2.6, 1, 2.6), (1, 2.6, 1, 1)))


def grid(wall: int) -> OccupancyGrid:
    hits = np.zeros((40, 40), dtype=np.uint16)
    hits[wall] = 5
    return OccupancyGrid(0.05, np.zeros(2), hits, np.where(hits, 0, 5).astype(np.uint16))


def test_each_map_that_is_read_is_a_sign_of_life_also_when_the_chairs_own_is_gone() -> None:
    told: list[tuple[str, bool]] = []
    atlas = Atlas(lambda: told.append((atlas.id, atlas.location is not None)))
    atlas.know({"a": grid(0), "b": grid(5)})
    assert told == [("", False)] * 2
    atlas.place("a", np.array((1.0, 1.0, 0.0)), np.zeros(3), 0)
    atlas.know({"a": grid(0), "b": grid(6)})
    assert told[2:] == [("a", True)]
    atlas.know({"b": grid(7), "c": grid(8)})
    assert told[3:] == [("", False)] * 2
    assert atlas.ids == ["b", "c"]


def map_of(room: Room, at: Iterable[np.ndarray]) -> OccupancyGrid:
    keys = []
    for pose in at:
        seen = points(*scan(room, pose, CHANCE))
        keys.append(KeyScan(pose, seen, np.zeros_like(seen), 0.0, 0.0, 0.0))
    return occupancy_of(keys)


def floor() -> OccupancyGrid:
    return map_of(flat(), list(poses(((2.0, 4.0), (2.0, 1.8), (2.0, 4.0), (5.0, 4.0))))[::2])


def look(atlas: Atlas, room: Room, at_s: float, pose: np.ndarray = HERE) -> Location | None:
    """Look at `room` from `pose`, at rest."""
    seen = points(*scan(room, pose, CHANCE))
    estimate = Estimate(at_s, *(0.0,) * 10, 1.0, (), 0)
    return atlas.look(Seen(Look(seen, np.zeros_like(seen)), np.zeros(3), estimate))


@pytest.mark.parametrize(("opens_s", "id_"), [(4.0, "b"), (60.0, "")])
def test_which_of_two_like_floors_it_is_on_is_not_known_after_a_lift_ride(
    opens_s: float, id_: str
) -> None:
    atlas, grid = Atlas(), floor()
    atlas.know({"a": grid, "b": grid})
    look(atlas, flat(), -0.5)
    atlas.place("b", HERE, np.zeros(3), 0)
    assert look(atlas, flat(), 0.0) is not None
    for at_s in (0.5, 2.6, *np.arange(10.0, opens_s, 10.0)):
        lost = look(atlas, CABIN, at_s) is None
    assert lost
    for number in range(16):
        look(atlas, flat(), opens_s + 0.5 * number)
        if atlas.id or atlas.rivalled:
            break
    assert (atlas.id, atlas.rivalled) == (id_, not id_)


def landing(*far: tuple[float, float], is_open: bool = True) -> Room:
    """A lift's cabin, its door, and a hall with these corners opposite the door."""
    corners = (
        *((0.0, -0.45), (0.0, -0.6), (-1.6, -0.6), (-1.6, 0.6), (0.0, 0.6), (0.0, 0.45)),
        *((0.1, 0.45), (0.1, 3.0), *far, (0.1, -3.0), (0.1, -0.45), (0.0, -0.45)),
    )
    walls = [(*one, *after) for one, after in pairwise(corners)]
    return Room("landing", (*walls, *(() if is_open else ((0.0, -0.45, 0.0, 0.45),))))


def test_from_a_mapped_lift_another_floors_hall_is_noticed_within_five_seconds() -> None:
    mapped = (4.0, 3.0), (4.0, -3.0)
    other = (5.5, 3.0), (5.5, 0.4), (4.0, 0.4), (4.0, -3.0)
    atlas, cabin = Atlas(), np.array((-0.8, 0.0, 0.0))
    along = [np.array((x, y, 0.0)) for x in (-0.8, 0.6, 1.5, 3.0) for y in (-0.2, 0.0, 0.2)]
    atlas.know({"a": map_of(landing(*mapped), along)})
    atlas.place("a", cabin, np.zeros(3), 0)
    for at_s in np.arange(0.0, 3.0, 0.2):
        assert look(atlas, landing(*mapped), at_s, cabin) is not None
    for at_s in np.arange(3.0, 15.0, 0.2):  # no wall of the hall is in sight: it may be this floor
        assert look(atlas, landing(*mapped, is_open=False), at_s, cabin) is not None
    for at_s in np.arange(15.0, 20.0, 0.2):
        if look(atlas, landing(*other), at_s, cabin) is None:
            break
    assert not atlas.id
