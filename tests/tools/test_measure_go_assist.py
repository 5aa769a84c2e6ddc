"""The benchmark of assist: a door and a room by a simulated gaze driver; judged by the truth."""

import json
import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from gazemeasure.go import assist_set
from gazemeasure.go.assist import BARE, HELPED, Outcome, Run, Task, cluttered, door
from gazemeasure.go.assist_set import DOORS, add_rows
from gazemeasure.on_record import Job
from gazemeasure.report import Report

pytestmark = pytest.mark.costly


def test_a_door_beside_the_way_is_passed_with_assist_in_few_commands():
    outcome = Run(door(5, 0.90), HELPED, 5, "3.1")()
    assert outcome.arrived
    assert not outcome.contact
    assert outcome.commands <= 4
    assert outcome.loose == 0


def test_without_the_rule_the_same_person_bumps_into_the_door():
    outcome = Run(door(5, 0.81), BARE, 5, "3.1")()
    assert outcome.contact
    assert not outcome.arrived


def test_with_assist_the_chair_must_arrive():
    def verdict(arrived):
        bare, plain = [Outcome(contact=True)] * 10, [Outcome(commands=9)] * 10
        report = Report("")
        helped = [Outcome(arrived=n < arrived, commands=2) for n in range(10)]
        add_rows(report, "doors", bare, plain, helped)
        return report.ok

    assert verdict(10)
    assert not verdict(9)


def test_a_cluttered_room_has_a_route_that_keeps_off_everything():
    task = cluttered(3)
    assert len(task.route) >= 2
    start = task.room.start
    route = (start[:2], *task.route)
    for (x, y), (nx, ny) in pairwise(route[1:]):
        assert not task.room.collides(x, y, math.degrees(math.atan2(ny - y, nx - x)))


def drive_once(task: Task, way: str, seed: int, profile: str) -> Callable[[], Outcome]:
    """A run of a task; it fails when the task is driven again."""
    Path(f"{task.name} {seed} {way}").touch(exist_ok=False)
    return lambda: Outcome(arrived=way == HELPED, contact=way == BARE, commands=3 + seed)


def test_tasks_on_record_are_not_driven_again_and_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(assist_set, "Run", drive_once)
    file = tmp_path / "assist.json"
    first = assist_set.gather([Job(DOORS, 0)], file)
    both = assist_set.gather([Job(DOORS, 0), Job(DOORS, 1)], file)
    assert both[0] == first[0]
    counted = json.loads(file.read_text())["kinds"][DOORS]
    assert counted["tasks"] == 2
    assert counted[f"arrived, {HELPED}"] == 2
    assert counted[f"contact, {HELPED}"] == 0
    assert counted[f"commands, {HELPED}"] == 7
    assert counted[f"contact, {BARE}"] == 2
