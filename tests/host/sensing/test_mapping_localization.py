"""The chair finds its pose in a known map, or reports that it is unknown; never a wrong pose."""

from __future__ import annotations

import math
import sys
from itertools import pairwise

import numpy as np
import pytest

from gazechair.base.poses import between, compose
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, occupancy_of
from gazechair.sensing.mapping.locating.candidate import Candidate
from gazechair.sensing.mapping.locating.localization import Localization
from gazechair.sensing.mapping.locating.location import Location
from gazechair.sensing.mapping.locating.map_match import Look, MapMatch
from gazechair.sensing.mapping.locating.recent_looks import RecentLooks
from gazechair.sensing.mapping.matching import ndt
from gazesim.rooms import Person, Room, Solid, box
from homerig import flat, points, poses, scan

# What it is made of takes longer than the tests: one process makes it.
pytestmark = [pytest.mark.xdist_group("mapping_localization"), pytest.mark.costly]

CHANCE = np.random.default_rng(8)
HERE = np.array((2.0, 1.8, 0.7))
STANDING = np.zeros(3)
NOTHING = Look(np.zeros((0, 2)), np.zeros((0, 2)))
SQUARE = Room("square", ((-2, -2, 2, -2), (2, -2, 2, 2), (2, 2, -2, 2), (-2, 2, -2, -2)))


def map_of(room: Room, at: list[np.ndarray]) -> OccupancyGrid:
    keys = []
    for pose in at:
        seen = points(*scan(room, pose, CHANCE))
        keys.append(KeyScan(pose, seen, np.zeros_like(seen), 0.0, 0.0, 0.0))
    return occupancy_of(keys)


@pytest.fixture(scope="module")
def grid() -> OccupancyGrid:
    return map_of(flat(), list(poses())[::2])


def look(room: Room, pose: np.ndarray) -> Look:
    seen = points(*scan(room, pose, CHANCE))
    return Look(seen, np.zeros_like(seen))


def is_right(location: Location | None, pose: np.ndarray) -> bool:
    assert location is not None
    off = between(pose, location.pose)
    return math.hypot(off[0], off[1]) < 0.1 and abs(off[2]) < math.radians(3.0)


def turned(
    localization: Localization, room: Room, pose: np.ndarray, times: int = 6
) -> tuple[Location | None, np.ndarray]:
    """Look every half second while the chair turns slowly, until the pose is known."""
    found, at = None, pose
    for number in range(times):
        turn = np.array((0.0, 0.0, math.radians(10.0 * number)))
        at = compose(pose, turn)
        found = localization.look(look(room, at), turn, 0.5 * number)
        if found is not None:
            break
    return found, at


@pytest.mark.parametrize("number", range(4))
def test_it_finds_itself_anywhere_without_a_hint(grid: OccupancyGrid, number: int) -> None:
    places = ((2.0, 1.8), (7.5, 1.7), (7.3, 6.0), (2.2, 6.1))
    pose = np.array((*places[number], 1.3 * number - 2.0))
    found, at = turned(Localization(grid), flat(), pose)
    assert is_right(found, at)


def test_four_looks_after_the_first_have_to_find_the_same_pose(grid: OccupancyGrid) -> None:
    localization = Localization(grid)
    for at_s in (0.0, 0.1, 0.6, 0.7, 1.2, 1.8):  # half a second apart, or they are no new looks
        assert localization.look(look(flat(), HERE), STANDING, at_s) is None
    assert is_right(localization.look(look(flat(), HERE), STANDING, 2.4), HERE)


def test_in_a_room_that_looks_the_same_from_four_sides_it_does_not_guess() -> None:
    at = [np.array((x, y, 0.0)) for x in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0)]
    found, _ = turned(Localization(map_of(SQUARE, at)), SQUARE, np.array((0.5, 0.8, 0.3)))
    assert found is None


def test_where_both_ways_look_the_same_it_waits_until_it_has_seen_a_difference() -> None:
    # A corridor with a wing at each end, turned half around each other; one is longer.
    corners = (
        *((0.0, 0.0), (8.6, 0.0), (8.6, -4.0), (10.0, -4.0)),
        *((10.0, 1.4), (1.4, 1.4), (1.4, 3.4), (0.0, 3.4), (0.0, 0.0)),
    )
    walls = tuple((*one, *after) for one, after in pairwise(corners))
    room = Room("corridor with wings", walls)
    along = [np.array((x, 0.7, 0.0)) for x in np.arange(0.7, 9.5, 0.4)]
    aside = [np.array((0.7, 2.4, 1.0)), *(np.array((9.3, -y, 1.0)) for y in (0.5, 1.5, 2.5, 3.3))]
    localization = Localization(map_of(room, [*along, *along, *aside, *aside]))
    start = np.array((5.0, 0.7, 0.0))
    assert turned(localization, room, start)[0] is None
    for number in range(20):
        odometry = np.array((min(0.4 * number, 4.3), 0.0, 0.0))
        pose = compose(start, odometry)
        found = localization.look(look(room, pose), odometry, 5.0 + number)
        if found is not None:
            break
    assert is_right(found, pose)


def test_in_a_corridor_without_ends_it_does_not_guess(grid: OccupancyGrid) -> None:
    walls = tuple((-30.0, y, 30.0, y) for y in (3.3, 4.7))
    found, _ = turned(Localization(grid), Room("corridor", walls), np.array((0.0, 4.0, 0.0)))
    assert found is None


def test_in_a_home_that_is_not_on_the_map_it_does_not_guess(grid: OccupancyGrid) -> None:
    desk = box(1.0, 0.4, 0.9, 0.5, 0.0, 0.8, "desk", 30.0)
    other = Room("other", SQUARE.walls, (desk,))
    found, _ = turned(Localization(grid), other, np.array((0.3, -0.4, 0.2)))
    assert found is None


def twin_rooms(*more: Solid) -> Room:
    """Two closed rooms 6 m apart, alike but for `more`."""
    shape = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (2.6, 3.0), (2.6, 3.8), (0.0, 3.8), (0.0, 0.0))
    walls = [(a + x, b, c + x, d) for (a, b), (c, d) in pairwise(shape) for x in (0.0, 6.0)]
    return Room("twins", tuple(walls), more)


@pytest.mark.parametrize("side_m", [0.4, 0.7, 0.9])
def test_where_a_table_stood_it_does_not_take_the_room_for_one_that_had_none(
    side_m: float,
) -> None:
    table = box(1.6, 1.5, side_m, side_m, 0.0, 0.8, "table")
    corners = ((0.5, 0.5), (3.3, 0.5), (3.3, 2.4), (0.5, 3.2), (0.6, 1.8))
    at = [np.array((x + aside, y, 0.0)) for x, y in corners for aside in (0.0, 6.0)]
    localization = Localization(map_of(twin_rooms(table), at + at))
    assert turned(localization, twin_rooms(), np.array((1.6, 1.5, 0.4)), 7)[0] is None


@pytest.mark.parametrize("more", [(), (box(1.6, 0.7, 1.2, 0.6, 0.0, 0.9, "cupboard", 12.0),)])
def test_a_room_that_is_its_own_mirror_image_is_no_certain_place(
    more: tuple[Solid, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules[__name__], "CHANCE", np.random.default_rng(3))
    corners = ((0.0, -0.7), (2.4, -1.2), (2.4, 1.2), (0.0, 0.7), (0.0, -0.7))
    room = Room("tapering", tuple((*one, *after) for one, after in pairwise(corners)), more)
    at = [np.array((x, y, 0.0)) for x in (0.4, 0.8, 1.3, 2.0) for y in (-0.4, -0.3, 0.1)]
    start = np.array((0.8, -0.3, 0.5))
    found, pose = turned(Localization(map_of(room, at)), room, start, 7)
    assert is_right(found, pose) if more else found is None


def test_it_follows_the_chair_and_is_not_dragged_off(grid: OccupancyGrid) -> None:
    localization = Localization(grid)
    path = [np.array((2.0 + 0.1 * k, 4.0, 0.0)) for k in range(50)]
    odometry, found = np.zeros(3), None
    for number, pose in enumerate(path):
        if number:
            moved = between(path[number - 1], pose) * (1.05, 1.0, 1.0)
            odometry = compose(odometry, moved)
        found = localization.look(look(flat(), pose), odometry, 0.5 * number)
    assert is_right(found, path[-1])


def test_people_all_around_never_make_it_claim_a_wrong_place(grid: OccupancyGrid) -> None:
    localization = Localization(grid)
    found, at = turned(localization, flat(), HERE)
    assert found is not None
    odometry = at - HERE
    crowd = [Person(((2.0 + 0.7 * math.cos(a), 1.8 + 0.7 * math.sin(a)),)) for a in range(7)]
    hidden = flat(people=crowd)
    free = np.isclose(scan(flat(), at, CHANCE)[1], scan(hidden, at, CHANCE)[1], atol=0.05)
    assert free.mean() < 0.4
    for step in range(10):
        location = localization.look(look(hidden, at), odometry, 5.0 + step)
        assert location is None or is_right(location, at)


def test_a_look_that_hardly_tells_the_heading_does_not_turn_the_place(
    grid: OccupancyGrid,
) -> None:
    localization = Localization(grid)
    localization.place(HERE, STANDING)
    assert is_right(localization.look(look(flat(), HERE), STANDING, 0.0), HERE)
    assert localization.sure
    # Of all around, a piece of one wall; somebody stands at its end, almost as far away.
    seen = points(*scan(flat(), HERE, CHANCE))
    c, s = math.cos(HERE[2]), math.sin(HERE[2])
    ends = seen @ np.array(((c, s), (-s, c))) + HERE[:2]
    near = (ends[:, 1] > 3.0) & (ends[:, 0] > 0.6) & (ends[:, 0] < 1.4)
    part = seen[near] - np.outer(ends[near, 0] - 0.6, (s, c)) * 0.06
    for number in range(1, 12):
        found = localization.look(Look(part, np.zeros_like(part)), STANDING, 0.3 * number)
        assert not localization.sure
        assert found is None or abs(math.degrees(found.pose[2] - HERE[2])) < 1.0


def crowd(share: float) -> list[Person]:
    """People around HERE, each time at other places, who hide that share of the surroundings."""
    bearings = CHANCE.permutation(np.arange(0.0, 2.0 * math.pi, 0.35))
    bearings = bearings[: round(share * len(bearings))]
    return [Person(((2.0 + 0.9 * math.cos(a), 1.8 + 0.9 * math.sin(a)),)) for a in bearings]


def hidden_share(room: Room, pose: np.ndarray) -> float:
    free, seen = scan(flat(), pose, CHANCE)[1], scan(room, pose, CHANCE)[1]
    return 1.0 - float(np.isclose(free, seen, atol=0.05).mean())


def test_people_who_walk_hide_most_of_every_look_but_walls_stay(grid: OccupancyGrid) -> None:
    localization = Localization(grid)
    for number in range(20):
        room = flat(people=crowd(0.7))
        assert hidden_share(room, HERE) > 0.5
        found = localization.look(look(room, HERE), STANDING, 0.5 * number)
        if found is not None:
            break
    assert is_right(found, HERE)


def test_a_crowd_that_stands_around_a_known_place_is_no_reason_to_forget_it(
    grid: OccupancyGrid, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of some crowds it is: they hide most of what is farther away. A wrong place is never told."""
    kept = 0
    for seed in range(1000, 1008):
        monkeypatch.setattr(sys.modules[__name__], "CHANCE", np.random.default_rng(seed))
        localization = Localization(grid)
        localization.place(HERE, STANDING)
        room = flat(people=crowd(0.7))
        assert hidden_share(room, HERE) > 0.5
        for number in range(30):
            found = localization.look(look(room, HERE), STANDING, 0.2 * number)
            assert found is None or is_right(found, HERE)
        kept += found is not None
    assert kept >= 7


def test_carried_into_a_crowd_it_knows_no_more(grid: OccupancyGrid) -> None:
    localization = Localization(grid)
    localization.place(np.array((7.5, 1.7, 0.2)), STANDING)
    room = flat(people=crowd(0.7))
    for number in range(25):
        found = localization.look(look(room, HERE), STANDING, 0.2 * number)
    assert found is None


def test_a_place_where_walls_are_seen_through_is_none_however_much_agrees(
    grid: OccupancyGrid,
) -> None:
    # The same rooms, but without the walls between them.
    open_flat = Room("open", tuple(flat().walls), tuple(flat().furniture[:4]))
    found, _ = turned(Localization(grid), open_flat, HERE, 12)
    assert found is None


def test_carried_away_is_noticed_within_five_seconds(grid: OccupancyGrid) -> None:
    for away in ((7.5, 1.7, 0.2), (7.3, 6.0, 2.0), (2.2, 6.1, -1.0)):
        localization = Localization(grid)
        turned(localization, flat(), HERE)
        assert localization.location is not None
        there = np.array(away)
        lost_s = None
        for step in range(25):
            found = localization.look(look(flat(), there), STANDING, 10.0 + 0.2 * step)
            if found is None or is_right(found, there):
                lost_s = 0.2 * step
                break
        assert lost_s is not None
        assert lost_s < 5.0


def beams_through(seen: Look, low_deg: float, high_deg: float) -> Look:
    """The same look, but between these bearings three metres more: as in a mirror."""
    points_m = seen.points_m.copy()
    bearings = np.degrees(np.arctan2(points_m[:, 1], points_m[:, 0]))
    into = (bearings > low_deg) & (bearings < high_deg)
    points_m[into] *= 1.0 + 3.0 / np.hypot(*points_m[into].T)[:, None]
    return Look(points_m, seen.origins_m)


def test_a_mirror_close_by_is_no_reason_to_forget_a_known_place(grid: OccupancyGrid) -> None:
    # The wall is 0.3 m ahead: half a metre of it is as many beams as a sixth of the room.
    close = np.array((0.7, 2.95, math.pi / 2))
    localization = Localization(grid)
    localization.place(close, STANDING)
    seen = beams_through(look(flat(), close), -40.0, 40.0)
    evidence = MapMatch(grid).evidence(seen, close)
    assert evidence.through > 0.16
    assert evidence.crossed < 0.15
    for number in range(30):
        seen = beams_through(look(flat(), close), -40.0, 40.0)
        assert is_right(localization.look(seen, STANDING, 0.2 * number), close)


def test_what_lies_behind_a_wall_contradicts_the_pose(grid: OccupancyGrid) -> None:
    match = MapMatch(grid)
    seen = look(flat(), HERE)
    right = match.evidence(seen, HERE)
    assert right.explained > 0.9
    assert right.through < 0.02
    wrong = match.evidence(seen, np.array((3.0, 1.0, 2.0)))
    assert wrong.explained < 0.6
    assert wrong.through > 0.1
    assert wrong.crossed > 0.15 > 0.02 > right.crossed


def test_surfaces_agree_where_they_are_and_floor_contradicts_walls_elsewhere(
    grid: OccupancyGrid,
) -> None:
    looks, match = RecentLooks(), MapMatch(grid)
    for _ in range(3):
        seen = look(flat(), HERE)
        looks.add(seen.origins_m, seen.points_m, STANDING)
    settled = looks.settled()
    assert settled is not None
    right = match.agreement(settled, HERE)
    assert right.agreed.mean() > 0.95
    assert right.contradicted_m < 0.1
    assert right.value_m == pytest.approx(right.agreed_m - right.contradicted_m)
    wrong = match.agreement(settled, np.array((3.0, 1.0, 2.0)))
    assert wrong.agreed.mean() < 0.6
    assert wrong.contradicted_m > 1.0
    assert wrong.value_m < right.value_m - 3.0


def test_people_in_a_row_are_no_wall() -> None:
    passes = np.full((100, 60), 9, dtype=np.uint16)
    hits = np.zeros_like(passes)
    hits[0] = 9
    match, stood = MapMatch(OccupancyGrid(0.05, np.zeros(2), hits, passes)), np.array((2.0, 2.5))
    row = [(1.025 + 0.65 * n + 0.05 * k, 1.025) for n in range(5) for k in range(7)]
    wall = [(x, 1.025) for x in np.arange(1.025, 4.0, 0.1)]
    for seen, length_m in ((row, 0.35), (wall, 1.5)):
        looks, ends = RecentLooks(), np.array(seen)
        for _ in range(3):
            looks.add(np.tile(stood, (len(ends), 1)), ends, stood)
        settled = looks.settled()
        assert settled is not None
        agreement = match.agreement(settled, STANDING)
        assert not agreement.agreed.any()
        straight_m = match.new_straight_m(settled, agreement, STANDING)
        assert straight_m == pytest.approx(length_m, abs=0.051)


WALL = box(2.0, 2.7, 3.2, 0.1, 0.0, 2.0, "wall")
PEOPLE = [Person((at,)) for at in ((1.2, 2.6), (1.9, 2.8), (2.7, 2.6))]


@pytest.mark.parametrize(
    ("room", "possible"), [(flat(), True), (flat(people=PEOPLE), True), (flat(WALL), False)]
)
def test_a_wall_where_the_map_has_floor_speaks_against_a_place_and_people_do_not(
    grid: OccupancyGrid, room: Room, possible: bool
) -> None:
    looks, match = RecentLooks(), MapMatch(grid)
    for _ in range(3):
        seen = look(room, HERE)
        looks.add(seen.origins_m, seen.points_m, STANDING)
    settled = looks.settled()
    assert settled is not None
    fitted = ndt.fit(match.ndt, settled.surfaces_m, HERE)
    here = Candidate(match, settled, STANDING, HERE, fitted)
    assert here.agreement.contradicted_m < 0.2
    assert here.is_possible() == possible


def test_an_empty_map_is_refused_and_an_empty_look_is_nothing(grid: OccupancyGrid) -> None:
    zeros = np.zeros((5, 5), dtype=np.uint16)
    with pytest.raises(ValueError, match="nothing in the map"):
        Localization(OccupancyGrid(0.05, np.zeros(2), zeros, zeros))
    assert Localization(grid).look(NOTHING, STANDING, 0.0) is None


def test_with_nothing_in_range_odometry_moves_the_pose_for_two_seconds(grid: OccupancyGrid) -> None:
    localization = Localization(grid)
    localization.place(HERE, STANDING)
    assert is_right(localization.look(look(flat(), HERE), STANDING, 0.0), HERE)
    assert localization.sure
    for number in range(1, 20):
        moved = np.array((0.04 * number, 0.0, 0.0))
        found = localization.look(NOTHING, moved, 0.1 * number)
        assert is_right(found, compose(HERE, moved))
        assert not localization.sure
    there = compose(HERE, moved)
    assert is_right(localization.look(look(flat(), there), moved, 2.0), there)  # seen again
    assert localization.sure
    for at_s in (2.5, 3.0, 3.5, 4.0):
        assert localization.look(NOTHING, moved, at_s) is not None
    assert localization.look(NOTHING, moved, 4.5) is None
