"""The obstacles benchmark: a few runs of each kind, what they count, and its verdict."""

from __future__ import annotations

import pytest

from gazelink import codes
from gazemeasure.obstacles.benchmark import Trial, along_wall, through_door, trial
from gazemeasure.obstacles.firmware import firmware_run
from gazemeasure.obstacles.run import NONE, OURS, PROTOTYPE, Run
from gazesim.random_rooms import Task, Walker, door_task, wall_task
from gazesim.rooms import Room, box

pytestmark = pytest.mark.costly

HALL = ((-5.0, -5.0, 5.0, -5.0), (5, -5, 5, 5), (5, 5, -5, 5), (-5, 5, -5, -5))


def before_a_wall() -> Task:
    wall = box(2.2, 0.0, 0.2, 3.0, 0.0, 2.0, "wall")
    return Task("room", Room("wall", HALL, (wall,)), codes.FORWARD, 4.0)


@pytest.mark.parametrize("profile", ["1.2", "5.1"])
def test_ours_stops_before_a_wall_and_nobody_else_does(profile: str) -> None:
    ours = Run(before_a_wall(), profile, OURS, 1)()
    assert (ours.collided, ours.stopped, ours.arrived) == (False, True, False)
    assert 0.05 < ours.least_m < 0.6
    alone = Run(before_a_wall(), profile, NONE, 1)()
    assert alone.collided


def test_a_cupboard_beside_the_wheels_is_bumped_by_the_prototypes_rule_alone() -> None:
    # The first prototype's own accident: the front is free, the turning corner is not.
    cupboard = box(-0.3, 0.75, 0.4, 0.6, 0.0, 1.8, "cupboard")
    turn = Task("room", Room("cupboard", HALL, (cupboard,)), codes.RIGHT, 90.0)
    assert Run(turn, "4.1", PROTOTYPE, 1)().collided
    ours = Run(turn, "4.1", OURS, 1)()
    assert (ours.collided, ours.stopped) == (False, True)


def test_somebody_who_comes_towards_the_chair() -> None:
    walker = Walker(4.5, 0.0, 180.0, from_s=2.0)
    ours = Run(Task("people", Room("hall", HALL), codes.FORWARD, 3.0, walker), "5.1", OURS, 1)()
    assert ours.met
    assert ours.stoppable
    assert not ours.collided
    assert ours.stopped


@pytest.mark.parametrize("seed", [117, 199, 241, 891])
def test_somebody_who_stands_before_the_chair_and_starts_towards_it(seed: int) -> None:
    ours = trial(("people", seed)).ours
    assert ours.stoppable
    assert ours.stopped
    assert not ours.collided


def test_somebody_who_runs_into_its_side_is_no_fault_of_the_rule() -> None:
    walker = Walker(1.1, 2.0, -90.0, from_s=1.5)
    run = Run(Task("people", Room("hall", HALL), codes.FORWARD, 3.0, walker), "5.1", OURS, 1)()
    assert not (run.collided and run.met and run.stoppable)


def test_a_door_and_a_wall_are_passed_without_a_stop() -> None:
    door = through_door(3)
    assert door.arrived
    assert not door.stopped
    wall = Run(wall_task(0.15, 1.5), "3.1", OURS, 2)()
    assert (wall.arrived, wall.stopped, wall.collided) == (True, False, False)
    assert callable(along_wall)


def test_a_door_that_is_too_narrow_is_not_tried() -> None:
    narrow = Run(door_task(0.74, 0.1, 0.0, 0.0, 0.5), "3.1", OURS, 1)()
    assert (narrow.collided, narrow.stopped, narrow.arrived) == (False, True, False)


def test_a_trial_knows_what_is_passable() -> None:
    found = trial(("way", 1))
    assert isinstance(found, Trial)
    assert found.passable == (found.free.arrived and found.free.least_m >= 0.05)
    assert not found.ours.collided


def test_the_whole_firmware_drives_past_things() -> None:
    whole = firmware_run(2)
    assert not whole.collided
    assert whole.arrived or whole.stopped
