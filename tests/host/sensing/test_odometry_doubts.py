"""What odometry notices: corridor, hall, pushed, stuck, carried, crowds, a silent lidar."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gazechair.base.health import Health
from gazechair.base.latest_value import Entry
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.odometry import doubts
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.obeys import Obeys
from gazechair.sensing.odometry.odometry import Odometry
from gazechair.sensing.odometry.shown import shown
from gazelink import codes
from gazesim.homes import Home, Walker
from gazesim.rooms import box

# x m, y m, heading deg at a time
Path = Callable[[float], tuple[float, float, float]]
Command = Callable[[float], tuple[int, int]]

POINTS = 400  # half a turn
STEP_S = 0.05


def room(half_m: float = 3.0) -> Home:
    h = half_m
    walls = ((-h, -h, h, -h), (h, -h, h, h), (h, h, -h, h), (-h, h, -h, -h))
    return Home("room", walls, (box(2.0, 1.0, 0.5, 0.8, 0.0, 1.0, "cupboard"),))


def corridor() -> Home:
    return Home("corridor", ((-60.0, -0.9, 60.0, -0.9), (-60.0, 0.9, 60.0, 0.9)))


def pieces(home: Home, path: Path, seconds: float, origin_m: float = 0.5) -> Iterator[Piece]:
    chance = np.random.default_rng(1)
    for step in range(1, round(seconds / STEP_S)):
        home.walk(STEP_S, *path(step * STEP_S))
        share = (np.arange(POINTS) + 0.5) / POINTS
        times = (step - 1 + share) * STEP_S
        own = -(share + step % 2) * 180.0
        poses = np.array([path(float(time_s)) for time_s in times])
        heading = np.radians(poses[:, 2])
        x = poses[:, 0] + origin_m * np.cos(heading)
        y = poses[:, 1] + origin_m * np.sin(heading)
        angles = (heading + np.radians(own)) % (2.0 * math.pi)
        order = np.argsort(angles)
        metres = np.empty(POINTS)
        metres[order] = home.cast_moving(x[order], y[order], angles[order], 0.25)
        metres = np.where(metres < 30.0, metres + chance.normal(0.0, 0.006, POINTS), 0.0)
        directions = (own + 180.0) % 360.0 - 180.0
        yield Piece(directions, metres, times, (origin_m, 0.0), 2 * POINTS)


def say(
    home: Home, path: Path, command: Command, seconds: float, odometry: Odometry | None = None
) -> list[Estimate]:
    odometry = odometry or Odometry()
    found = []
    for piece in pieces(home, path, seconds):
        for time_s in np.arange(piece.times_s[0], piece.times_s[-1], 0.02):
            heading = path(float(time_s))[2]
            odometry.motion(Motion(float(time_s), heading % 360.0, *command(float(time_s))))
        estimate = odometry.piece(piece)
        assert estimate is not None
        found.append(estimate)
    return found


def still(_time_s: float) -> tuple[float, float, float]:
    return 0.0, 0.0, 0.0


def idle(_time_s: float) -> tuple[int, int]:
    return 0, 0


def first(found: list[Estimate], doubt: str) -> float:
    """When it was first reported; inf: never."""
    return next((one.time_s for one in found if doubt in one.doubts), math.inf)


def test_a_chair_that_stands_in_a_room_doubts_nothing_and_stands() -> None:
    found = say(room(), still, idle, 3.0)
    assert {doubt for one in found for doubt in one.doubts} == set()
    assert max(abs(one.speed_m_s) for one in found[10:]) < 0.01
    assert math.hypot(found[-1].x_m, found[-1].y_m) < 0.005


def test_a_long_corridor_is_said_and_the_uncertainty_grows_along_it_alone() -> None:
    found = say(corridor(), lambda t: (0.4 * max(0.0, t - 1.0), 0.0, 0.0), lambda t: (800, 0), 6.0)
    assert first(found, doubts.CORRIDOR) < 0.5
    assert found[-1].along_sigma_m > 5.0 * found[-1].across_sigma_m
    true_m = 0.4 * (found[-1].time_s - 1.0)
    assert abs(found[-1].x_m - true_m) < 3.0 * found[-1].along_sigma_m
    assert abs(found[-1].y_m) < 0.02


def test_an_empty_hall_is_said() -> None:
    assert first(say(room(40.0), still, idle, 1.5), doubts.LITTLE) < 0.5


def test_being_pushed_is_said_within_half_a_second() -> None:
    found = say(room(), lambda t: (0.15 * max(0.0, t - 2.0), 0.0, 0.0), idle, 4.0)
    assert 2.0 < first(found, doubts.PUSHED) < 2.5


def test_being_turned_by_hand_is_said_within_half_a_second() -> None:
    found = say(room(), lambda t: (0.0, 0.0, 20.0 * max(0.0, t - 2.0)), idle, 3.5)
    assert 2.0 < first(found, doubts.PUSHED) < 2.5


def test_a_chair_that_is_held_while_it_drives_is_stuck_within_half_a_second() -> None:
    found = say(
        room(), lambda t: (0.3 * (min(max(t, 1.0), 4.0) - 1.0), 0.0, 0.0), lambda t: (600, 0), 6.0
    )
    assert 4.0 < first([one for one in found if one.time_s > 2.0], doubts.STUCK) < 4.5


def test_being_carried_sideways_is_said() -> None:
    found = say(room(), lambda t: (0.0, 0.3 * max(0.0, t - 2.0), 0.0), idle, 4.0)
    assert first(found, doubts.CARRIED) < 3.0
    assert abs(found[-1].y_m - 0.3 * (found[-1].time_s - 2.0)) < 0.05


def test_a_chair_set_down_elsewhere_begins_another_track() -> None:
    odometry = Odometry()
    say(room(), still, idle, 2.0, odometry)
    elsewhere = Home("elsewhere", corridor().walls, (box(1.5, 0.3, 0.4, 0.4, 0, 1, "pot", 30),))
    found = []
    for piece in pieces(elsewhere, lambda t: (0.0, 0.0, 65.0), 6.0):
        later = Piece(
            piece.directions_deg, piece.distances_m, piece.times_s + 2.0, (0.5, 0.0), 2 * POINTS
        )
        odometry.motion(Motion(later.middle_s, 0.0, 0, 0))
        found.append(odometry.piece(later))
    assert found[0] is not None
    assert found[0].track == 0
    assert found[-1] is not None
    assert found[-1].track >= 1
    assert not {doubts.LOST, doubts.CHANGED} & set(found[-1].doubts)


def test_people_who_walk_past_do_not_take_the_chair_along() -> None:
    home = room()
    home.people = tuple(
        Walker(((1.6, -2.0 + 0.5 * k), (1.9, 2.5 - 0.3 * k)), 0.5 + 0.1 * k) for k in range(5)
    )
    found = say(home, still, idle, 4.0)
    assert max(math.hypot(one.x_m, one.y_m) for one in found) < 0.01
    assert doubts.PUSHED not in {doubt for one in found for doubt in one.doubts}


def test_a_lidar_that_comes_back_in_step_with_the_other_is_not_silent() -> None:
    """Its half turns end with the other's, and are no newer."""
    odometry, said = Odometry(), []
    for one, other in zip(pieces(room(), still, 6.0), pieces(room(), still, 6.0), strict=True):
        estimate = odometry.piece(one)
        assert estimate is not None
        said.append(estimate)
        late_s = 0.01 if one.middle_s < 2.0 else 0.0
        if not 2.0 < one.middle_s < 4.0:
            odometry.piece(replace(other, times_s=other.times_s + late_s, lidar=1))
    assert 2.0 < first(said, doubts.SILENT) < 2.8
    assert doubts.SILENT not in {doubt for one in said if one.time_s > 4.2 for doubt in one.doubts}


@pytest.mark.parametrize("place_m", [-0.4, 0.5])
def test_a_lidar_that_falls_silent_is_said_and_the_other_goes_on(place_m: float) -> None:
    def pushed(time_s: float) -> tuple[float, float, float]:
        return 0.3 * max(0.0, time_s - 4.0), 0.0, 0.0

    odometry, health = Odometry(), Health("motion")
    board = SimpleNamespace(state=codes.ARMED)
    obeys = Obeys(health, lambda: board)  # type: ignore[arg-type, return-value]
    front = pieces(room(), pushed, 6.0)
    rear = pieces(room(), pushed, 6.0, origin_m=place_m)
    said, reasons = [], []
    for one, other in zip(front, rear, strict=True):
        odometry.motion(Motion(one.middle_s, 0.0, 0, 0))
        estimate = odometry.piece(one)
        assert estimate is not None
        obeys.judge(estimate)
        said.append(estimate)
        reasons.append(health.now().reason)
        if one.middle_s < 2.0:
            odometry.piece(replace(other, times_s=other.times_s + 0.01, lidar=1))
    assert 2.0 < first(said, doubts.SILENT) < 2.8
    assert first(said, doubts.LATE) == math.inf
    still_yet = [one for one in said if one.time_s < 4.0]
    assert math.hypot(still_yet[-1].x_m, still_yet[-1].y_m) < 0.01
    moved_m = 0.3 * (said[-1].time_s - 4.0)
    assert math.hypot(said[-1].x_m - moved_m, said[-1].y_m) < 0.03
    noticed = said[reasons.index("motion_uncommanded")].time_s
    assert 4.0 < noticed < 4.5
    told = shown(Entry(said[-1], said[-1].time_s, 1), said[-1].time_s)
    assert told is not None
    assert told["m_s"] == pytest.approx(0.3, abs=0.03)


def test_scans_that_come_late_are_said() -> None:
    odometry, found = Odometry(), []
    for piece in pieces(room(), still, 1.6):
        late_s = 0.3 if piece.times_s[-1] > 0.8 else 0.0
        for time_s in np.arange(piece.times_s[0], piece.times_s[-1] + late_s, 0.02):
            odometry.motion(Motion(float(time_s), 0.0, 0, 0))
        estimate = odometry.piece(piece)
        assert estimate is not None
        found.append(estimate)
    assert 0.8 < first(found, doubts.LATE) < 1.3
    assert first(found, doubts.SILENT) == math.inf


def test_a_heading_that_passes_north_moves_nothing() -> None:
    def path(time_s: float) -> tuple[float, float, float]:
        return 0.3 * max(0.0, time_s - 1.0), 0.0, 8.0 * math.sin(2.0 * time_s)

    found = say(room(), path, lambda t: (600 if t > 1.0 else 0, 0), 5.0)
    off = [math.hypot(one.x_m - path(one.time_s)[0], one.y_m) for one in found]
    assert max(off) < 0.03
    assert max(abs(one.sideways_m_s) for one in found) < 0.12


def test_without_a_heading_it_follows_slow_turns_and_says_so() -> None:
    odometry = Odometry()
    found = [
        odometry.piece(piece)
        for piece in pieces(room(), lambda t: (0.0, 0.0, 5.0 * max(0.0, t - 1.0)), 5.0)
    ]
    assert found[-1] is not None
    assert doubts.HEADING in found[-1].doubts
    assert abs(found[-1].heading_deg - 5.0 * (found[-1].time_s - 1.0)) < 1.5


def test_a_slow_profile_is_not_stuck_and_a_held_chair_is_before_it_was_ever_driven() -> None:
    slow = say(room(), lambda t: (0.04 * max(0.0, t - 0.5), 0.0, 0.0), lambda t: (250, 0), 4.0)
    assert first(slow, doubts.STUCK) == math.inf
    assert first(say(room(), still, lambda t: (700, 0), 2.0), doubts.STUCK) < 1.3


def test_a_chair_that_changes_direction_is_not_stuck() -> None:
    def path(time_s: float) -> tuple[float, float, float]:
        return (0.3 if time_s > 2.5 else 0.0) * (2.5 - time_s), 0.0, 0.0

    found = say(room(), path, lambda t: (600 if t < 2.0 else -600, 0), 3.0)
    assert not [one for one in found if 2.0 < one.time_s < 2.6 and doubts.STUCK in one.doubts]


@pytest.mark.parametrize("wrong", [lambda t: 2.0 * t, lambda t: 0.1 * 30.0 * t])
def test_a_heading_that_the_lidars_contradict_is_said_and_counts_less(
    wrong: Callable[[float], float],
) -> None:
    odometry = Odometry()
    found = []
    for piece in pieces(room(), lambda t: (0.0, 0.0, 30.0 * max(0.0, t - 1.0)), 5.0):
        for time_s in np.arange(piece.times_s[0], piece.times_s[-1], 0.02):
            turned = max(0.0, float(time_s) - 1.0)
            heading = 30.0 * turned + wrong(turned)
            odometry.motion(Motion(float(time_s), heading % 360.0, 0, 700))
        estimate = odometry.piece(piece)
        assert estimate is not None
        found.append(estimate)
    assert 1.0 < first(found, doubts.DIFFERS) < 2.2
    assert doubts.DIFFERS in found[-1].doubts
    assert abs(found[-1].heading_deg - 30.0 * (found[-1].time_s - 1.0)) < 0.5


def test_a_fast_chair_that_rolls_out_is_not_pushed_and_one_that_never_stops_is() -> None:
    def rolls(time_s: float) -> tuple[float, float, float]:
        """0.65 m/s until 1.5 s; then 0.35 m/s2 slower and slower."""
        passed_s = min(max(0.0, time_s - 1.5), 0.65 / 0.35)
        return -2.0 + 0.65 * (min(time_s, 1.5) + passed_s) - 0.175 * passed_s**2, 0.0, 0.0

    def command(time_s: float) -> tuple[int, int]:
        return (900 if time_s < 1.5 else 0), 0

    assert first(say(room(), rolls, command, 5.0), doubts.PUSHED) == math.inf
    runs = say(room(5.0), lambda t: (-2.0 + 0.65 * t, 0.0, 0.0), command, 5.0)
    assert 2.7 < first(runs, doubts.PUSHED) < 4.5
