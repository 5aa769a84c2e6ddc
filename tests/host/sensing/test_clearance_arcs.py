"""How far the chair may travel while it turns, compared with random paths in small steps."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from gazechair.base.arrays import FloatArray
from gazechair.base.footprint import DEFAULT_CORNERS, Corner, Footprint, Margins, inside
from gazechair.sensing.clearance.arcs import ArcReach, arc_reach
from gazechair.sensing.clearance.sweeps import Sweeps
from gazelink import arcs

pytestmark = pytest.mark.costly

NOTCHED: tuple[Corner, ...] = (
    (0.65, 0.30),
    (0.65, 0.10),
    (0.45, 0.10),
    (0.45, -0.10),
    (0.65, -0.10),
    (0.65, -0.30),
    (-0.45, -0.375),
    (-0.45, 0.375),
)
STEP_M = 0.004
STEP_RAD = math.radians(0.25)


def drive(chance: random.Random, quadrant: int, turn_rad: float, travel_m: float) -> FloatArray:
    """Poses (N, 3) of a path with that turn and travel, in any order, in a quadrant."""
    ahead = 1.0 if quadrant % 2 == 0 else -1.0
    left = 1.0 if quadrant < 2 else -1.0
    travels, turns = math.ceil(travel_m / STEP_M), math.ceil(turn_rad / STEP_RAD)
    what = chance.choice(("mixed", "bursts", "straight first", "turn first"))
    steps = [True] * travels + [False] * turns
    if what == "mixed":
        chance.shuffle(steps)
    elif what == "turn first":
        steps.reverse()
    elif what == "bursts":
        cut = [*sorted(chance.choices(range(travels + 1), k=3)), travels]
        cuts = [*sorted(chance.choices(range(turns + 1), k=3)), turns]
        steps, before = [], (0, 0)
        for a, b in zip(cut, cuts, strict=True):
            steps += [True] * (a - before[0]) + [False] * (b - before[1])
            before = (a, b)
    return poses(steps, ahead * STEP_M, left * STEP_RAD)


def poses(steps: list[bool], step_m: float, step_rad: float) -> FloatArray:
    x = y = heading = 0.0
    found = [(x, y, heading)]
    for travels in steps:
        if travels:
            x += step_m * math.cos(heading)
            y += step_m * math.sin(heading)
        else:
            heading += step_rad
        found.append((x, y, heading))
    return np.array(found)


def touches(body: FloatArray, path: FloatArray, points: FloatArray) -> np.ndarray:
    """Which points the bare outline covers anywhere on the path."""
    found = np.zeros(len(points), dtype=np.bool_)
    radius_m = float(np.hypot(*body.T).max()) + 0.001
    for part in (path[at : at + 20] for at in range(0, len(path), 20)):
        middle = part[:, :2].mean(axis=0)
        reach_m = radius_m + float(np.hypot(*(part[:, :2] - middle).T).max())
        # Only what the chair may reach in these poses, and has not touched before.
        left = np.flatnonzero(~found & (np.hypot(*(points - middle).T) < reach_m))
        px, py = points[left].T
        x, y, heading = part.T[:, :, None]
        c, s = np.cos(heading), np.sin(heading)
        dx, dy = px - x, py - y
        seen = np.stack((c * dx + s * dy, c * dy - s * dx), axis=2)
        found[left] = inside(body, seen.reshape(-1, 2)).reshape(dx.shape).any(axis=0)
    return found


@pytest.mark.parametrize("corners", [DEFAULT_CORNERS, NOTCHED])
def test_no_path_within_a_row_touches_what_the_row_left_free(corners: tuple[Corner, ...]) -> None:
    """Quadrants: paths that turn and travel one way each."""
    footprint = Footprint(corners)
    chance = random.Random(1)
    source = np.random.default_rng(1)
    points = np.column_stack((source.uniform(-1.6, 1.9, 4000), source.uniform(-1.6, 1.6, 4000)))
    points = points[~inside(footprint.body, points)]
    ways = arc_reach(footprint).ways(points, Sweeps(footprint).contacts(points))
    met = 0
    for quadrant in range(arcs.QUADRANTS):
        for row, turn_deg in enumerate(arcs.TURNS_DEG):
            for travel_m in (0.1, 0.35, 0.8):
                path = drive(chance, quadrant, math.radians(turn_deg), travel_m)
                free = ways[:, quadrant * arcs.ROWS + row] >= travel_m * 1000 / arcs.UNIT_MM
                hit = touches(footprint.body, path, points)
                met += int(hit.sum())
                assert not (hit & free).any(), (quadrant, turn_deg, travel_m, points[hit & free])
    assert met > 1000


def test_no_path_that_turns_both_ways_touches_what_a_side_left_free() -> None:
    """Sides: the stick is reversed on the way, once or often."""
    footprint = Footprint()
    chance = random.Random(2)
    source = np.random.default_rng(2)
    points = np.column_stack((source.uniform(-1.6, 1.9, 4000), source.uniform(-1.6, 1.6, 4000)))
    points = points[~inside(footprint.body, points)]
    ways = arc_reach(footprint).ways(points, Sweeps(footprint).contacts(points))
    for side in range(arcs.SIDES):
        for row, turn_deg in enumerate(arcs.BOTH_TURNS_DEG):
            for travel_m in (0.1, 0.35, 0.8):
                for _ in range(3):
                    path = weave(chance, side, math.radians(turn_deg), travel_m)
                    at = arcs.BOTH_AT + side * arcs.BOTH_ROWS + row
                    free = ways[:, at] >= travel_m * 1000 / arcs.UNIT_MM
                    hit = touches(footprint.body, path, points)
                    assert not (hit & free).any(), (side, turn_deg, travel_m)


def weave(chance: random.Random, side: int, turn_rad: float, travel_m: float) -> FloatArray:
    ahead = STEP_M if side == 0 else -STEP_M
    x = y = heading = 0.0
    wanted = chance.choice((-turn_rad, turn_rad))
    found = []
    for _ in range(math.ceil(travel_m / STEP_M)):
        while chance.random() < 0.9:
            heading += max(-STEP_RAD, min(STEP_RAD, wanted - heading))
            found.append((x, y, heading))
            if heading == wanted:
                wanted = -wanted if chance.random() < 0.3 else wanted
        x += ahead * math.cos(heading)
        y += ahead * math.sin(heading)
        found.append((x, y, heading))
    return np.array(found)


def test_rows_are_not_much_shorter_than_they_must_be() -> None:
    """A point ahead: beside the worst path, with the margins and two cells more."""
    footprint = Footprint()
    source = np.random.default_rng(3)
    points = np.column_stack((source.uniform(0.8, 1.5, 200), source.uniform(-0.6, 0.6, 200)))
    ways = arc_reach(footprint).ways(points, Sweeps(footprint).contacts(points))
    wide = Footprint(DEFAULT_CORNERS, Margins(0.11, 0.08, 0.11)).parts[0]
    for row in (0, 2, 5):
        reported_m = ways[:, row].astype(float) * arcs.UNIT_MM / 1000.0
        worst = np.full(len(points), np.inf)
        for heading in np.linspace(0.0, math.radians(arcs.TURNS_DEG[row]), 12):
            for course in np.linspace(0.0, float(heading), 6):
                for travel_m in np.arange(0.0, 1.3, 0.05):
                    at = (travel_m * math.cos(course), travel_m * math.sin(course), heading)
                    hit = touches(wide, np.array([at]), points)
                    worst = np.where(hit, np.minimum(worst, travel_m), worst)
        # 5 cm is the step of the paths here.
        assert (reported_m >= np.minimum(worst, 1.2) - 0.06).all()
        assert np.isfinite(worst).mean() > 0.2


def test_more_turn_never_leaves_more_way() -> None:
    """Rows ascend in turn and descend in travel."""
    source = np.random.default_rng(4)
    points = source.uniform(-2.5, 2.5, (3000, 2))
    footprint = Footprint()
    ways = arc_reach(footprint).ways(points, Sweeps(footprint).contacts(points)).astype(int)
    for quadrant in range(arcs.QUADRANTS):
        rows = ways[:, quadrant * arcs.ROWS : (quadrant + 1) * arcs.ROWS]
        assert (np.diff(rows, axis=1) <= 0).all()
    for side in range(arcs.SIDES):
        at = arcs.BOTH_AT + side * arcs.BOTH_ROWS
        assert (np.diff(ways[:, at : at + arcs.BOTH_ROWS], axis=1) <= 0).all()


def test_the_least_of_many_is_the_least_of_each() -> None:
    """The fast computation over all points equals that point by point."""
    source = np.random.default_rng(5)
    footprint = Footprint()
    for _ in range(20):
        points = source.uniform(-1.5, 1.5, (40, 2))
        contacts = Sweeps(footprint).contacts(points)
        reach = arc_reach(footprint)
        assert (reach.least(points, contacts) == reach.ways(points, contacts).min(axis=0)).all()
    nothing = reach.least(np.zeros((0, 2)), np.zeros((0, 4)))
    assert (nothing == arcs.FAR).all()


def test_what_is_beside_within_the_margin_leaves_the_way_out() -> None:
    """A post 1.5 cm beside the front left: not to the left, but away to the right."""
    points = np.array(((0.5, 0.39),))
    footprint = Footprint()
    ways = arc_reach(footprint).ways(points, Sweeps(footprint).contacts(points))[0]
    assert (ways[: arcs.ROWS] == 0).all()  # forward left
    assert (ways[2 * arcs.ROWS : 3 * arcs.ROWS] > 15).all()  # forward right
    assert (ways[3 * arcs.ROWS : 4 * arcs.ROWS] > 15).all()


def test_within_the_outline_driving_and_turning_alone_say_what_is_left() -> None:
    """A hand on the left side: a motion that takes it deeper has clearance 0, as have its arcs."""
    points = np.array(((0.5, 0.37),))
    footprint = Footprint()
    contacts = Sweeps(footprint).contacts(points)
    ways = arc_reach(footprint).ways(points, contacts)[0]
    assert contacts[0, 2] == 0.0
    assert (ways[: arcs.ROWS] == 0).all()
    assert (ways[2 * arcs.ROWS : 2 * arcs.ROWS + 3] > 0).all()


def test_tables_for_some_points_say_the_same_of_them_as_whole_ones() -> None:
    points = np.random.default_rng(7).uniform(-2.0, 2.0, (200, 2))
    footprint = Footprint()
    contacts = Sweeps(footprint).contacts(points)
    some = ArcReach(footprint, points).ways(points, contacts)
    assert (some == arc_reach(footprint).ways(points, contacts)).all()
    assert some.min() < arcs.FAR
