"""The whole chair's missions: how they are judged, ROS maps in other styles, ways that are shut."""

from __future__ import annotations

import math
from itertools import pairwise, product
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import occupancy_of
from gazechair.sensing.mapping.stored import ros_map as product_maps
from gazemeasure.go import foreign_maps
from gazemeasure.go.scenes import DOOR, PERSON, ROUND, SHUT, Shut, _add
from gazemeasure.go.whole import Driven, Judge, Scene, drive
from gazemeasure.home.localization import look
from gazemeasure.on_record import Job
from gazemeasure.report import Report
from gazesim import ros_map
from gazesim.home_drive import FRONT, REAR
from gazesim.homes import Home
from gazesim.rooms import Door, box

GOAL = (1.5, 1.6, 0.5)


def room() -> Home:
    """One room that looks the same from nowhere else."""
    corners = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.2), (0.0, 3.2), (0.0, 0.0))
    walls = tuple((*a, *b) for a, b in pairwise(corners))
    return Home("one room", walls, (box(3.6, 0.5, 0.6, 0.8, 0.0, 1.0, "cupboard"),))


def test_the_whole_chair_finds_itself_and_the_truth_judges_what_it_says() -> None:
    home, chance = room(), np.random.default_rng(1)
    keys = []
    for x, y in product((0.9, 1.6, 2.3), (1.0, 1.6, 2.2)):
        pose = np.array((x, y, chance.uniform(-3.0, 3.0)))
        seen = look(home, pose, chance, (FRONT, REAR))
        keys.append(KeyScan(pose, seen.points_m, seen.origins_m, 0.0, 0.0, 0.0))
    pushed_m: list[float] = []

    def push(judge: Judge) -> None:
        if judge.pressed_ms and judge.chair.news["state"] == "arrived" and not pushed_m:
            pushed_m.append(judge.chair.off(GOAL[0], GOAL[1], math.degrees(GOAL[2]))[0])
            judge.chair.world.chair.place(GOAL[0] + 0.3, GOAL[1], math.degrees(GOAL[2]))

    driven = drive(Scene(home, occupancy_of(keys), GOAL, GOAL, "3.1"), push)
    assert driven.ended == "arrived"
    assert driven.took_s < 2.0
    assert pushed_m[0] < 0.05
    assert not driven.arrived
    assert driven.end_m > 0.15


def test_maps_of_other_styles_are_homes_and_maps(tmp_path: Path) -> None:
    home = ros_map.load(foreign_maps.drawn_by_hand(tmp_path, noisy=False))
    assert len(home.places) >= 4
    grid = product_maps.read(foreign_maps.drawn_by_hand(tmp_path, noisy=True), "x").grid
    slanted_m, column_m, floor_m = (4.7, 3.8), (8.4, 3.36), (2.0, 2.0)
    for at, solid in ((slanted_m, True), (column_m, True), (floor_m, False)):
        near = np.hypot(*(grid.occupied_m() - at).T).min() < 0.12
        assert near == solid
        assert (home.clearance_m(*at, 0.0) <= 0.0) == solid


class _Chair:
    """What Shut sees of one that drives along x."""

    def __init__(self) -> None:
        self.now_ms, self.x_m = 0, 1.3
        self.news = {"state": "drives", "reason": ""}
        self.world: Any = SimpleNamespace(pose=(0.0, 0.0, 0.0))


def shut(kind: str, seed: int = 2) -> tuple[Any, Shut, Home]:
    """A mission on its way, and who shuts its way."""
    home = room()
    home.doors = (Door("door 0", (4.0, 1.0), (4.0, 2.0)), Door("door 1", (4.0, 2.2), (4.0, 3.1)))
    chair = _Chair()
    judge: Any = SimpleNamespace(
        chair=chair,
        pressed_ms=1,
        scene=SimpleNamespace(room=home, start=(1.3, 1.5, 0.0)),
        driven=SimpleNamespace(silent_s=0.0, shut=False),
        moves=True,
    )
    return judge, Shut(Job(kind, seed)), home


def run(judge: Any, who: Shut, seconds: float, to_m: float) -> None:
    """So long, towards there."""
    chair = judge.chair
    for _ in range(round(20 * seconds)):
        chair.now_ms += 50
        judge.moves = chair.x_m < to_m
        chair.x_m = min(to_m, chair.x_m + 0.02)
        chair.world.pose = (chair.x_m, 1.5, 0.0)
        who.act(judge)


def test_every_way_is_shut_before_the_chair_is_too_near() -> None:
    for seed in range(60):
        judge, who, _ = shut(DOOR, seed)
        run(judge, who, 10.0, 3.5)
        assert judge.driven.shut, seed


def test_ways_that_were_not_shut_or_not_explained_fall_short() -> None:
    for kind in SHUT:
        good = {"arrived": True, "took_s": 30.0, "ideal_s": 20.0, "least_m": 0.1, "shut": True}
        for of, ok in (({}, True), ({"shut": False}, False), ({"silent_s": 12.0}, False)):
            report = Report("")
            _add(report, kind, [Driven(**good), Driven(**(good | of))])
            assert report.ok == ok, (kind, of)


def test_the_way_is_shut_on_the_way_and_opens_when_the_pages_were_told() -> None:
    for kind in (DOOR, PERSON, ROUND):
        judge, who, home = shut(kind)
        run(judge, who, 0.5, 3.0)
        assert home.doors[0].open
        assert not home.people
        run(judge, who, 15.0, 2.4)
        assert (not home.doors[0].open) == (kind != PERSON)
        assert bool(home.people) == (kind == PERSON)
        assert home.doors[1].open
        ahead_m = home.cast(2.4, 1.5, np.linspace(-0.1, 0.1, 41), 0.25).min()
        assert ahead_m < 1.65  # lidars see whoever or whatever shuts it
        assert 11.0 < judge.driven.silent_s < 13.0  # 15 s, of which it drove 3
        judge.chair.news["reason"] = "going_obstacle"
        run(judge, who, 25.0, 2.4)
        assert home.doors[0].open == (kind != ROUND)
        assert not home.people
