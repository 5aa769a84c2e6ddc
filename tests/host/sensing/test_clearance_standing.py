"""The chair approaches a possible person so slowly that they may start to walk towards it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazeboard.core import limits
from gazeboard.core.stopping import Stopping
from gazeboard.io.settings import Settings
from gazechair.base.footprint import Footprint
from gazechair.sensing.clearance.reach import LidarReach
from gazechair.sensing.clearance.standing import Approach, Standing, like_persons
from gazechair.sensing.clearance.stood import Stood
from gazechair.sensing.clearance.surface import Surfaces, surfaces
from gazelink import codes, zone
from gazelink.settings_table import PROFILES
from gazesim.rooms import Person, Room, box
from gazesim.zone import zone_of
from lidarviews import HALL, LOOK_S, NOISE_M, points_of, view_of

pytestmark = pytest.mark.costly

ZONE = zone_of()
AHEAD = Approach(ZONE.of(codes.DIR_FORWARD))


def reach_of() -> LidarReach:
    reach = LidarReach(Footprint())
    reach.use(ZONE)
    return reach


def forward_m(
    reach: LidarReach,
    room: Room,
    at_s: float,
    noise_m: float = NOISE_M,
    heading_deg: float = 0.0,
) -> float:
    chance = np.random.default_rng(round(1000 * at_s))
    points = points_of(room, chance, noise_m, heading_deg=heading_deg)
    return reach.update(view_of(points, at_s))[codes.DIR_FORWARD]


def hall(*people: Person, furniture: tuple = ()) -> Room:
    return Room("hall", HALL, furniture, people=people)


def test_the_way_told_grows_with_the_way_and_is_never_longer() -> None:
    reported = [AHEAD.reported_m(way_m) for way_m in np.arange(0.0, 6.0, 0.01)]
    assert reported == sorted(reported)
    assert all(0.0 <= one <= way for one, way in zip(reported, np.arange(0, 6, 0.01), strict=True))
    assert AHEAD.reported_m(AHEAD.blocked_within_m - 0.001) == 0.0
    assert AHEAD.reported_m(math.inf) == math.inf


@pytest.mark.parametrize("profile", range(len(PROFILES)))
@pytest.mark.parametrize("way_m", [0.56, 0.6, 0.7, 0.85, 1.0, 1.2, 1.5, 1.8])
def test_the_board_then_lets_it_run_so_fast_that_he_may_start_to_walk(
    profile: int, way_m: float
) -> None:
    settings = Settings()
    settings.profile = profile
    settings.linear_permille = 1000
    stopping = Stopping(settings, codes.DIR_FORWARD, True)
    reported_mm = int(1000 * AHEAD.reported_m(way_m))
    levels = [n for n, begin in enumerate(stopping.begin) if begin <= reported_mm]
    fastest_m_s = stopping.speed(stopping.permille[levels[-1]]) / 1000.0 if levels else 0.0
    assert levels or way_m < AHEAD.blocked_within_m < 0.72
    braking_s = 0.49 + max(0.0, fastest_m_s - 0.05) / 0.5
    own_m = fastest_m_s * 0.49 + fastest_m_s**2 / (2 * 0.5)
    assert own_m + 1.0 * braking_s <= way_m + 0.001


@pytest.mark.parametrize("noise_m", [0.006, 0.03])
@pytest.mark.parametrize("beside_m", [0.0, 0.4])
def test_the_way_to_somebody_who_stands_is_cut(noise_m: float, beside_m: float) -> None:
    someone = Person(((2.0, beside_m),), radius_m=0.25)
    gap_m = 2.0 - math.sqrt(0.25**2 - max(0.0, beside_m - 0.375) ** 2) - 0.70
    way_m = forward_m(reach_of(), hall(someone), 0.0, noise_m)
    assert way_m == pytest.approx(AHEAD.reported_m(gap_m), abs=0.06)


def test_somebody_before_a_wall_is_somebody() -> None:
    someone = Person(((2.0, 0.0),), radius_m=0.25)
    room = hall(someone, furniture=(box(2.6, 0.0, 1.0, 4.0, 0.0, 2.0, "wall"),))
    way_m = forward_m(reach_of(), room, 0.0)
    assert way_m == pytest.approx(AHEAD.reported_m(2.0 - 0.25 - 0.70), abs=0.03)


@pytest.mark.parametrize("wide_m", [0.05, 1.2])
def test_table_legs_and_cupboards_are_neared_as_ever(wide_m: float) -> None:
    room = hall(furniture=(box(2.0, 0.0, wide_m, wide_m, 0.0, 1.8, "wood"),))
    way_m = forward_m(reach_of(), room, 0.0)
    assert way_m == pytest.approx(2.0 - wide_m / 2 - 0.70, abs=0.03)


BEHIND = Approach(ZONE.of(codes.DIR_BACKWARD))


@pytest.mark.parametrize("aside_m", [0.0, 0.2])
@pytest.mark.parametrize(("wide_m", "person"), [(1.2, False), (0.14, True)])
def test_straight_behind_a_rear_lidar_a_thing_is_as_wide_as_elsewhere(
    wide_m: float, person: bool, aside_m: float
) -> None:
    gap_m = 0.8 if person else 0.4
    thing = box(-0.5 - gap_m - wide_m / 2, aside_m, wide_m, wide_m, 0.0, 1.8, "wood")
    rear = (-0.42, 0.0)
    points = points_of(hall(furniture=(thing,)), np.random.default_rng(1), origin_m=rear)
    backward_m = reach_of().update(view_of(points, 0.0, rear))[codes.DIR_BACKWARD]
    reported_m = BEHIND.reported_m(gap_m) if person else gap_m
    assert backward_m == pytest.approx(reported_m, abs=0.03)


def test_what_has_not_moved_for_ten_seconds_before_a_standing_chair_is_furniture() -> None:
    stool = hall(furniture=(box(1.4, 0.0, 0.4, 0.4, 0.0, 0.5, "wood"),))
    reach = reach_of()
    ways = [forward_m(reach, stool, LOOK_S * n) for n in range(round(11.0 / LOOK_S))]
    assert set(ways[: round(9.5 / LOOK_S)]) == {0.0}
    assert ways[-1] == pytest.approx(AHEAD.creep_way_m)


@pytest.mark.parametrize("deg_s", [4.0, 24.0])
def test_somebody_beside_a_stool_is_no_furniture_after_a_turn_towards_him(deg_s: float) -> None:
    stool = box(1.4, 0.0, 0.4, 0.4, 0.0, 0.5, "wood")
    beside = (1.4 * math.cos(math.radians(35.0)), 1.4 * math.sin(math.radians(35.0)))
    room = hall(Person((beside,), radius_m=0.2), furniture=(stool,))
    reach = reach_of()
    waits = round(11.0 / LOOK_S)
    for n in range(waits):
        way_m = forward_m(reach, room, LOOK_S * n)
    assert way_m == pytest.approx(AHEAD.creep_way_m)
    turns = round(35.0 / deg_s / LOOK_S)
    for n in range(turns + 60):
        heading_deg = min(35.0, deg_s * LOOK_S * n)
        way_m = forward_m(reach, room, LOOK_S * (waits + n), heading_deg=heading_deg)
    assert way_m == 0.0


def test_the_noise_of_a_standing_chairs_lidar_is_no_turn() -> None:
    stool = hall(furniture=(box(1.4, 0.0, 0.4, 0.4, 0.0, 0.5, "wood"),))
    reach = reach_of()
    for n in range(round(30.0 / LOOK_S)):
        forward_m(reach, stool, LOOK_S * n, 0.03)
    assert reach._movers is not None
    assert abs(reach._movers.turned_deg) < 3.0


class Judged:
    """A Standing, the memory of what has stood, and their clock."""

    def __init__(self) -> None:
        self.standing = Standing()
        self.standing.approach = AHEAD
        self.stood = Stood()
        self.at_s = 0.0

    def look(
        self,
        way_m: float,
        for_s: float = LOOK_S,
        stands: bool = True,
        walks: bool = False,
        turned_deg: float = 0.0,
        looks_like_m: float | None = None,
    ) -> float:
        """A thing that is `way_m` ahead and looks like a person `looks_like_m` ahead."""
        bearings = np.radians(np.arange(-180.0, 180.0, 0.3))
        ahead = np.abs(bearings) < 0.15
        ranges = np.where(ahead, min(1.0 + way_m, 4.0), 4.0)
        points = np.stack((np.cos(bearings) * ranges, np.sin(bearings) * ranges), axis=1)
        turns = np.diff(bearings, append=bearings[0] + 2.0 * np.pi)
        lone = np.zeros(len(ranges), dtype=np.bool_)
        seen = Surfaces(points, ranges, bearings, turns, lone, 0.0)
        like_m = way_m if looks_like_m is None else looks_like_m
        things = [ahead.nonzero()[0]] if math.isfinite(like_m) else []
        end_s = self.at_s + for_s - 1e-9
        while self.at_s < end_s:
            self.at_s += LOOK_S
            if walks or not stands:
                self.stood.restart()
            stood = all(self.stood.update(seen, things, turned_deg, self.at_s))
            found = self.standing.update(like_m, stood, walks, turned_deg, self.at_s)
        return found


@pytest.mark.parametrize(
    "disturbed",
    [
        {"way_m": 0.35, "stands": False},
        {"way_m": 0.35, "walks": True},
        {"way_m": 0.42, "for_s": 1.2},
        {"way_m": 0.28},
        {"way_m": 0.35, "turned_deg": 11.0},
    ],
)
def test_the_ten_seconds_begin_again_with(disturbed: dict) -> None:
    judged = Judged()
    assert judged.look(0.35, 9.0) == 0.0
    judged.look(**disturbed)
    assert judged.look(0.35, 9.5) == 0.0
    assert judged.look(0.35, 1.6) == AHEAD.creep_way_m


@pytest.mark.parametrize("seen_instead_m", [math.inf, 2.4, 0.7])
@pytest.mark.parametrize("for_s", [0.3, 2.0])
def test_what_looks_like_a_wall_between_has_stood_nevertheless(
    seen_instead_m: float, for_s: float
) -> None:
    judged = Judged()
    for _ in range(6):
        judged.look(0.35, 1.5)
        reported_m = judged.look(0.35, for_s, looks_like_m=seen_instead_m)
        assert reported_m == AHEAD.reported_m(seen_instead_m) or judged.at_s > 10.0
    assert judged.look(0.35) == AHEAD.creep_way_m


@pytest.mark.parametrize("seen_instead_m", [math.inf, 2.4, 0.7])
def test_furniture_that_looks_like_a_wall_for_a_moment_stays_furniture(
    seen_instead_m: float,
) -> None:
    judged = Judged()
    judged.look(0.35, 10.5)
    judged.look(seen_instead_m, 0.3, stands=False)
    assert judged.look(0.30, stands=False) == AHEAD.creep_way_m
    judged.look(seen_instead_m, 3.0)
    assert judged.look(0.35) == 0.0


@pytest.mark.parametrize(("away_s", "reported_m"), [(0.5, AHEAD.creep_way_m), (1.5, 0.0)])
def test_who_goes_away_for_longer_than_a_second_is_another_one(
    away_s: float, reported_m: float
) -> None:
    judged = Judged()
    judged.look(0.35, 8.0)
    judged.look(math.inf, away_s)
    assert judged.look(0.35, 3.0) == reported_m


def test_a_thing_that_nobody_saw_for_more_than_a_second_is_another_one() -> None:
    judged = Judged()
    judged.look(0.35, 9.0)
    judged.at_s += 1.5
    assert judged.look(0.35, 9.5) == 0.0


def test_a_leg_of_a_table_that_is_hardly_wide_enough_is_furniture_after_ten_seconds() -> None:
    # In some scans it looks like a person's leg, and a cupboard stands behind it.
    leg = box(1.34, -0.2, 0.07, 0.1, 0.0, 0.7, "wood")
    cupboard = box(1.7, 0.25, 0.4, 0.3, 0.0, 1.8, "wood")
    rooms = hall(furniture=(leg, cupboard)), hall(furniture=(cupboard,))
    reach = reach_of()
    ways = [forward_m(reach, rooms[n % 9 > 3], LOOK_S * n) for n in range(round(13.5 / LOOK_S))]
    assert 0.0 in ways[: round(9.0 / LOOK_S)]
    assert min(ways[round(12.0 / LOOK_S) :]) == pytest.approx(AHEAD.creep_way_m)


def test_the_board_goes_on_to_furniture_after_it_was_blocked() -> None:
    # What a clearance plays, and what the board needs more before it goes on.
    ahead = ZONE.of(codes.DIR_FORWARD)
    assert ahead is not None
    assert AHEAD.creep_way_m - 0.04 > ahead.permits_at[zone.CREEP] + limits.BAND_MM / 1000.0


def test_furniture_can_be_crept_up_to_until_it_walks_or_is_left() -> None:
    for ends in (
        {"way_m": 0.2, "walks": True},
        {"way_m": 0.70, "for_s": 1.1},
        {"way_m": 0.2, "turned_deg": -11.0},
    ):
        judged = Judged()
        judged.look(0.35, 10.5)
        assert judged.look(0.30, 1.0, stands=False) == AHEAD.creep_way_m
        assert judged.look(0.20, 1.0, stands=False) == AHEAD.creep_way_m
        judged.look(**ends)
        assert judged.look(0.20, stands=False) == 0.0


def test_somebody_far_off_does_not_become_furniture_by_waiting() -> None:
    judged = Judged()
    judged.look(1.0, 30.0)
    assert judged.look(1.0) == AHEAD.reported_m(1.0)
    assert judged.look(0.5, stands=False) == 0.0


def test_where_the_board_does_not_go_on_waiting_helps() -> None:
    # Anywhere a chair is stopped before something that may be a person, ten seconds of standing
    # make furniture of it: else it would stand there for good.
    ahead = ZONE.of(codes.DIR_FORWARD)
    assert ahead is not None
    goes_on_m = ahead.permits_at[zone.CREEP] + limits.BAND_MM / 1000.0 + 0.04
    for way_m in np.arange(0.2, 1.0, 0.01):
        judged = Judged()
        stuck = judged.look(float(way_m), 0.2) < goes_on_m
        assert not stuck or judged.look(float(way_m), 10.5) >= goes_on_m


def test_objects_without_a_point_that_counts_are_left_out() -> None:
    rng = np.random.default_rng(3)
    seen_before_the_first_point = 0
    for _ in range(200):
        bearings = np.sort(rng.uniform(-np.pi, np.pi, 700))
        ranges = np.full(700, 3.0)
        for middle in (math.pi, *rng.uniform(-np.pi, np.pi, 6)):  # one straight behind the lidar
            apart = np.abs((bearings - middle + np.pi) % (2.0 * np.pi) - np.pi)
            ranges[apart < rng.uniform(0.02, 0.2)] = rng.uniform(0.5, 2.5)
        points = np.stack((np.cos(bearings) * ranges, np.sin(bearings) * ranges), axis=1)
        seen = surfaces(points, (0.0, 0.0))
        where = rng.random(700) < rng.choice((0.0, 0.003, 0.02, 1.0))
        found = [one.tolist() for one in like_persons(seen, where)]
        assert found == [one.tolist() for one in like_persons(seen) if where[one].any()]
        seen_before_the_first_point += any(one[0] > one[-1] for one in found)
    assert seen_before_the_first_point > 20
