"""Missions for `measure go`: drawn from a home's places, driven, judged."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from gazechair.base.footprint import Footprint
from gazechair.going.costmap import costmap_of
from gazechair.going.plan import Pose
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazelink.settings_table import PROFILES
from gazemeasure.go.rig import Go, Outcome
from gazemeasure.home.localization import mapped
from gazemeasure.obstacles.attack import KINDS as PHYSICS
from gazemeasure.obstacles.attack import AttackedChair
from gazemeasure.on_record import Job
from gazemeasure.report import percentile
from gazemeasure.turn.board import settings_with
from gazesim import home_plans
from gazesim.home_routes import Router
from gazesim.homes import GLASS, Home
from gazesim.rooms import box

TWO, ONE, FOREIGN, PEOPLE, DOORS, HOMES = (
    "two lidars", "one lidar", "foreign chairs", "people", "doors of 0.85-0.90 m",
    "two lidars in 100 homes",
)  # fmt: skip
KINDS = {TWO: 200, ONE: 40, FOREIGN: 42, PEOPLE: 40, DOORS: 40, HOMES: 1000}
MISSIONS_IN_A_HOME = 4
_IN_A_HOME = {HOMES: 10}
_TRIES = 150
_AROUND_M = 0.10  # least gap all round for a turn on the spot where a mission begins or ends
_FENCE_M = 3.0
_LIMIT_S = 90.0  # and four times the ideal


@dataclass(frozen=True)
class Result:
    """The result of a mission."""

    job: Job
    arrived: bool
    collisions: int
    least_m: float
    ratio: float
    acceleration: float
    jerk: float
    why: str
    spent_s: dict[str, float] = field(default_factory=dict)
    plan_s: list[float] = field(default_factory=list)
    step_ms: float = 0.0
    """95th percentile of the mission's steps, ms."""


def kept(row: dict[str, Any]) -> Result:
    """A result from its JSON row."""
    return Result(**{**row, "job": Job(**row["job"])})


def mission(job: Job) -> Result:
    """Drive one mission; returns its result."""
    seed = job.seed
    home, grid = _door(seed) if job.kind == DOORS else _home(_number(job))
    if job.kind == PEOPLE:
        home.people = home_plans.home(_number(job)).people
    no_go = tuple(np.array(one.corners) for one in home.solids() if one.material == GLASS)
    chance = np.random.default_rng((seed, len(job.kind)))
    found = poses(home, grid, chance, 2, job.kind == DOORS)
    profile = PROFILES[seed % len(PROFILES)]
    chair: Any = None
    if job.kind == FOREIGN:
        profile = "3.1"
        chair = AttackedChair(
            profile, PHYSICS[seed % len(PHYSICS)], settings_with({}), seed % 4 < 2
        )
    lidars = ONE if job.kind == ONE else TWO
    go = Go(home, grid, found[0], profile, lidars, seed, chair, no_go)
    outcome = go.go(found[1], _LIMIT_S)
    return _result(job, outcome)


def _result(job: Job, outcome: Outcome) -> Result:
    often = max(outcome.overrides, key=lambda name: outcome.overrides[name], default="")
    off = f"{outcome.end_m:.2f} m and {outcome.end_deg:.0f} deg off"
    return Result(
        job,
        arrived=outcome.arrived,
        collisions=outcome.collisions,
        least_m=outcome.least_m,
        ratio=outcome.took_s / max(outcome.ideal_s, 1.0),
        acceleration=max(outcome.accelerations, default=0.0),
        jerk=float(np.percentile(outcome.jerks, 99)) if outcome.jerks else 0.0,
        why=f"{outcome.ended or outcome.reason}, {off}, {often}",
        spent_s=outcome.spent_s,
        plan_s=outcome.plan_s,
        step_ms=percentile(outcome.step_ms, 0.95) if outcome.step_ms else 0.0,
    )


def _number(job: Job) -> int:
    """Number of the home that a mission is driven in."""
    return job.seed // _IN_A_HOME.get(job.kind, MISSIONS_IN_A_HOME)


@lru_cache(maxsize=2)
def _map_of(seed: int) -> OccupancyGrid:
    return mapped(fenced(seed), np.random.default_rng(seed))


def _home(number: int) -> tuple[Home, OccupancyGrid]:
    return fenced(number), _map_of(number)


def fenced(seed: int) -> Home:
    """A home without people, in a fence, so that a beam through its windows hits something."""
    home = home_plans.home(seed)
    home.people, home.script = (), ()
    rows = home.body_segments().reshape(-1, 2)
    (x0, y0), (x1, y1) = rows.min(axis=0) - _FENCE_M, rows.max(axis=0) + _FENCE_M
    corners = ((x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0))
    home.walls = (
        *home.walls,
        *((*a, *b) for a, b in pairwise(corners)),
    )
    home.changed()
    return home


def _door(seed: int) -> tuple[Home, OccupancyGrid]:
    """Two empty rooms, and a door without a leaf between them."""
    chance = np.random.default_rng(seed)
    width, at = chance.uniform(0.85, 0.90), chance.uniform(1.3, 2.7)
    walls = [(4.0, 0.5 * (at - width / 2), at - width / 2)]
    walls.append((4.0, 0.5 * (4.0 + at + width / 2), 4.0 - at - width / 2))
    solids = [box(x, y, 0.1, long, 0.0, 2.5, "wall") for x, y, long in walls]
    shell = ((0.0, 0.0, 8.0, 0.0), (8.0, 0.0, 8.0, 4.0), (8.0, 4.0, 0.0, 4.0), (0.0, 4.0, 0.0, 0.0))
    home = Home(f"door {seed}", shell, tuple(solids), start=(1.8, 2.0, 0.0))
    home.places = {"here": (1.6, 2.0), "there": (6.4, 2.0)}
    return home, mapped(home, chance)


def poses(
    home: Home, grid: OccupancyGrid, chance: np.random.Generator, count: int, doors: bool
) -> list[Pose]:
    """Random poses in different rooms of the map, with room to turn, by the truth.

    `doors`: two rooms side by side, whose door may be too narrow for the router's lattice.
    """
    costmap = costmap_of(grid, Footprint())
    router = Router(home)
    names = sorted(home.places)
    costs = router.costs_to(*home.places[names[0]])
    around = np.radians(np.arange(0.0, 360.0, 10.0))
    found: list[Pose] = []
    order = [str(one) for one in chance.permutation(names)]
    for name in (order * count)[: 4 * count]:
        for _ in range(_TRIES):
            x, y = np.array(home.places[name]) + chance.uniform(-1.6, 1.6, 2)
            known = costmap.clearance_m(np.full(36, x), np.full(36, y), around).min()
            if known < 0.05 or any(math.dist((x, y), one[:2]) < 1.5 for one in found):
                continue
            if not doors:
                place = router.place(x, y)
                if place is None or math.dist(place, (x, y)) > 0.12:
                    continue
                if not router.reaches(costs, x, y):
                    continue
            if min(home.clearance_m(x, y, 10.0 * k) for k in range(36)) >= _AROUND_M:
                found.append((float(x), float(y), float(chance.uniform(-math.pi, math.pi))))
                break
        if len(found) == count:
            return found
    raise AssertionError(f"{home.name}: no places for a mission")
