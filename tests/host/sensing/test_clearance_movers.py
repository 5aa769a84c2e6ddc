"""Objects that approach are told from standing ones, and their travel reduces the clearance."""

from __future__ import annotations

import numpy as np
import pytest

from gazechair.base.footprint import Footprint
from gazechair.sensing.clearance import movers
from gazechair.sensing.clearance.movers import Movers
from gazechair.sensing.clearance.reach import LidarReach
from gazelink import codes
from gazesim.plans import room as plan
from gazesim.rooms import Person, Room
from gazesim.zone import zone_of
from lidarviews import HALL, LOOK_S, NOISE_M, ORIGIN, points_of, view_of


class Film:
    """A chair that drives through a room at constant speeds, and what its lidar sees."""

    def __init__(self, room: Room, noise_m: float = NOISE_M) -> None:
        self.room = room
        self.noise_m = noise_m
        self.chance = np.random.default_rng(3)
        self.movers = Movers(ORIGIN)
        self.movers.zone = zone_of()
        self.x_m, self.heading_deg, self.time_s = 0.0, 0.0, 0.0

    def points(self) -> np.ndarray:
        return points_of(self.room, self.chance, self.noise_m, self.x_m, self.heading_deg)

    def look(self, speed_m_s: float, rate_deg_s: float = 0.0, walk_m_s: float = 0.0) -> np.ndarray:
        self.time_s += LOOK_S
        self.x_m += speed_m_s * LOOK_S
        self.heading_deg += rate_deg_s * LOOK_S
        for person in self.room.people:
            person.x_m -= walk_m_s * LOOK_S
        return self.movers.update(self.points(), self.time_s)


@pytest.mark.parametrize(
    ("speed_m_s", "rate_deg_s"), [(0.0, 0.0), (0.55, 0.0), (-0.4, 0.0), (0, 8)]
)
def test_how_the_chair_moves_is_seen_and_a_room_that_stands_does_not_come(
    speed_m_s: float, rate_deg_s: float
) -> None:
    film = Film(plan("living"))
    for _ in range(12):
        coming = film.look(speed_m_s, rate_deg_s)
        assert len(coming) == 0
    assert film.movers.speed_m_s == pytest.approx(speed_m_s, abs=0.05)
    assert film.movers.rate_deg_s == pytest.approx(rate_deg_s, abs=1.0)


def test_a_fit_that_has_settled_is_as_good_as_one_that_goes_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Speeds up, turns, brakes; somebody comes. One film is fitted to the end each time.
    ways = [(0.05 * k, 0.0) for k in range(10)] + [(0.5, 6.0)] * 10 + [(0.1, 0.0)] * 10
    reported: list[list[tuple[float, float, bool]]] = []
    for settled in (None, 0.0):
        if settled is not None:
            monkeypatch.setattr(movers, "_SETTLED_M", settled)
        film = Film(plan("living"))
        film.room.people = (Person(((4.0, 0.3),)),)
        reported.append([])
        for speed_m_s, rate_deg_s in ways:
            coming = len(film.look(speed_m_s, rate_deg_s, walk_m_s=0.8)) > 0
            reported[-1].append((film.movers.speed_m_s, film.movers.rate_deg_s, coming))
    early, whole = (np.array(one) for one in reported)
    assert np.abs(early[:, 0] - whole[:, 0]).max() < 0.005
    assert np.abs(early[:, 1] - whole[:, 1]).max() < 0.1
    assert (early[:, 2] == whole[:, 2]).all()
    assert whole[:, 2].any()
    assert not np.array_equal(early, whole)


@pytest.mark.parametrize("speed_m_s", [0.0, 0.2, 0.55])
def test_someone_who_comes_is_where_he_will_be(speed_m_s: float) -> None:
    film = Film(Room("hall", plan("wall").walls, people=(Person(((3.5, 0.0),)),)))
    film.room.walls = HALL
    for _ in range(12):
        coming = film.look(speed_m_s, walk_m_s=1.0)
    face_m = film.room.people[0].x_m - 0.22 - film.x_m
    stop_s = 0.49 + speed_m_s / 0.5  # the board's dead time and lag
    assert coming[:, 0].min() == pytest.approx(face_m - stop_s, abs=0.3 * stop_s)
    assert coming[:, 0].max() < face_m + 0.2


def test_someone_who_stands_or_goes_leaves_the_way_as_it_is() -> None:
    for walk_m_s in (0.0, -1.0):
        film = Film(plan("open"), noise_m=0.01)
        film.room.people = (Person(((2.5, 0.0),)),)
        for _ in range(10):
            assert len(film.look(0.5, walk_m_s=walk_m_s)) == 0


def test_the_way_ahead_is_shortened_by_what_he_walks_meanwhile() -> None:
    film = Film(plan("wall"))
    film.room.people = (Person(((3.8, 0.0),), radius_m=0.6),)  # none takes it for one who stands
    reach = LidarReach(Footprint())
    reach.use(zone_of())
    for _ in range(12):
        film.look(0.0, walk_m_s=1.0)
        way_m = reach.update(view_of(film.points(), film.time_s))[codes.DIR_FORWARD]
    gap_m = film.room.people[0].x_m - 0.6 - 0.70
    assert way_m == pytest.approx(gap_m - 0.49, abs=0.1)


def test_a_clock_that_jumps_starts_afresh() -> None:
    film = Film(plan("living"))
    for _ in range(6):
        film.look(0.3)
    film.time_s -= 1.0
    assert len(film.look(0.3)) == 0
    film.time_s += 50.0
    assert len(film.look(0.3)) == 0
