"""The benchmark's mirrors, foreign maps and faulty lidars are what they are said to be."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.mapping.stored import ros_map
from gazemeasure.home import faults, foreign
from gazemeasure.home.faults import BUMPED, GONE, LATE, NOTHING, Drove
from gazemeasure.home.localization import Counted
from gazemeasure.home.maps import surfaces_off_m
from gazemeasure.report import Report
from gazesim import home_plans
from gazesim.home_drive import FRONT, REAR, Drive
from gazesim.homes import GLASS, MIRROR

pytestmark = pytest.mark.costly


def test_every_room_gets_a_mirror_or_a_pane() -> None:
    home = home_plans.home(2)
    before = len(home.furniture)
    home = foreign.with_mirrors(home, np.random.default_rng(1))
    more = [one.material for one in home.furniture[before:]]
    assert more.count(MIRROR) >= len(home.places) // 2
    assert more.count(GLASS) >= len(home.places) // 2


@pytest.mark.parametrize("seed", range(3))
def test_a_map_by_another_is_its_plan_but_for_the_noise(seed: int, tmp_path: Path) -> None:
    home = foreign.plan(seed)
    cell_m = (0.10, 0.05, 0.02)[seed]
    path = foreign.as_ros_map(home, cell_m, tmp_path, np.random.default_rng(seed))
    grid = ros_map.read(path, "plan").grid
    assert grid.cell_m == cell_m
    off_m = surfaces_off_m(grid.occupied_m(), np.array(home.walls))
    assert 0.005 < np.median(off_m) < 0.06
    assert np.percentile(off_m, 95) < 0.15
    assert grid.free.sum() > 4 * grid.occupied.sum()


def arrived(kind: str, seconds: float) -> list[tuple[float, float, float]]:
    """Of each half turn after the fault: its lidar's place, its age, and its middle beam."""
    driven = Drive(home_plans.home(2), 2, (FRONT, REAR), per_turn=200)
    return [
        (
            event.origin_m[0],
            driven.time_s - event.times_s[-1],
            float(event.directions_deg[len(event.times_s) // 2]),
        )
        for event in faults._events(driven, kind, seconds)
        if not isinstance(event, Motion)
    ]


def test_lidars_are_lost_late_and_bumped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(faults, "_BEGINS_S", 0.5)
    plain, late, gone, bumped = (arrived(kind, 1.1) for kind in (NOTHING, LATE, GONE, BUMPED))
    assert max(age_s for _, age_s, _ in plain) < 0.05
    assert late[-1][1] == pytest.approx(0.3, abs=0.02)
    assert len(gone) < len(plain)
    assert {x_m for x_m, _, _ in gone[-6:]} == {REAR.x_m}
    # What is told of a bumped lidar's directions is what is told of one that looks straight on.
    assert [row[2] for row in bumped] == pytest.approx([row[2] for row in plain], abs=1.5)


def found(wrong: int = 0, alarms: int = 0, noticed_s: float = 0.3) -> Drove:
    return Drove(wrong, 5, 10, alarms, noticed_s)


def test_a_fault_that_is_not_noticed_and_a_wrong_place_fall_short() -> None:
    for one, ok in (
        (found(), True),
        (found(wrong=1), False),
        (found(alarms=1), False),
        (found(noticed_s=math.inf), False),
    ):
        report = Report("home")
        faults.measure(report, True, lambda _, jobs, one=one: [one for _ in jobs])  # type: ignore[misc]
        assert report.ok is ok


def test_a_wrong_place_among_mirrors_falls_short() -> None:
    for which, ok in (("right", True), ("wrong", False)):

        def one(which: str = which) -> Counted:
            done = Counted()
            for kind in foreign._SEEDS:
                getattr(done, which)[kind] = 1
            return done

        report = Report("home")
        foreign.measure(report, True, lambda _, jobs: [one() for _ in jobs])
        assert report.ok is ok
