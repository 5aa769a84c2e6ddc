"""The clearance's shortcuts, compared with the plain formulas: equal to the last bit."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest

from gazechair.base.arrays import FloatArray
from gazechair.base.footprint import Footprint, Margins, distance_m, inside
from gazechair.sensing.clearance import surface
from gazechair.sensing.clearance.arcs import arc_reach
from gazechair.sensing.clearance.movers import Movers
from gazechair.sensing.clearance.sweeps import BEND_PER_M, RANGE_M, Sweeps
from gazechair.sensing.lidar.nodes import Nodes
from gazechair.sensing.lidar.scan import Placing, Pose, Scan, to_chair, view_of
from gazechair.sensing.lidar.sweep import Sweep
from gazelink import codes

TURN = 2.0 * math.pi
Point = tuple[float, float]
Path = Callable[[float], Point]
CHAIRS = (
    Footprint(),
    Footprint([(0.7, 0.2), (0.2, 0.4), (-0.5, 0.35), (-0.5, -0.35), (0.2, -0.4), (0.7, -0.2)]),
    Footprint([(0.7, 0.3), (-0.5, 0.3), (-0.5, -0.3), (0.7, -0.3), (0.3, 0.0)]),
)


def points_around(seed: int) -> FloatArray:
    """Points within the chair, close to it, far away, and exactly on its outline."""
    random = np.random.default_rng(seed)
    scale = random.choice((0.5, 1.0, 3.0, 8.0), (400, 1))
    points = random.uniform(-1.0, 1.0, (400, 2)) * scale
    points[:4] = CHAIRS[0].body
    points[4:8] = CHAIRS[0].body + np.array((0.02, 0.005))
    points[8:12] = ((0.0, 0.0), (-0.7, 0.0), (-0.7, -0.0), (1.0, 0.0))
    return points


def crossings(points: FloatArray, polygon: FloatArray) -> FloatArray:
    """(2 S, N): where each point's circle crosses each side; NaN where it does not."""
    ax, ay = polygon[:, :1], polygon[:, 1:]
    ex, ey = np.roll(ax, -1, axis=0) - ax, np.roll(ay, -1, axis=0) - ay
    squared = points[:, 0] ** 2 + points[:, 1] ** 2
    a, b = ex**2 + ey**2, ax * ex + ay * ey
    root = b**2 - a * (ax**2 + ay**2 - squared)
    with np.errstate(invalid="ignore"):
        spread = np.sqrt(root)
    found = []
    for share in ((-b - spread) / a, (-b + spread) / a):
        on_side = (share >= -1e-9) & (share <= 1.0 + 1e-9)
        found.append(np.where(on_side, np.arctan2(ay + share * ey, ax + share * ex), np.nan))
    return np.concatenate(found)


def least(turns: FloatArray) -> FloatArray:
    """Wrapped to one turn, the least for each point; inf = none."""
    return np.where(np.isnan(turns), np.inf, turns % TURN).min(axis=0)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("chair", CHAIRS)
def test_turns_are_those_of_all_circles_and_sides(chair: Footprint, seed: int) -> None:
    points = points_around(seed)
    found = Sweeps(chair).contacts(points)
    own = np.arctan2(points[:, 1], points[:, 0])
    cut = np.concatenate([crossings(points, part) for part in chair.parts])
    left, right = np.degrees(least(own - cut)), np.degrees(least(cut - own))
    out = ~chair.contains(points) & (np.hypot(*points.T) <= chair.reach_m)
    assert out.sum() > 30
    assert found[out, codes.DIR_LEFT].tobytes() == left[out].tobytes()
    assert found[out, codes.DIR_RIGHT].tobytes() == right[out].tobytes()
    beyond = np.hypot(*points.T) > chair.reach_m
    assert np.isinf(found[beyond][:, codes.DIR_LEFT :]).all()


def after_leaving(chair: Footprint, began: bool, ways: np.ndarray, end: float, path: Path) -> float:
    """The way along `path` to its contact, piece by piece between its crossings `ways`."""
    cuts = [0.0, *sorted(way for way in ways.tolist() if way < end), end]
    left, free_of_body = False, not began
    for first, last in itertools.pairwise(cuts):
        if last - first > 1e-9:
            middle = np.array([path(0.5 * (first + last))])
            grown, body = chair.contains(middle)[0], inside(chair.body, middle)[0]
            free_of_body |= not body
            if (left and grown) or (body and free_of_body and not left and grown):
                return first
            left |= not grown
    return math.inf


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("chair", CHAIRS)
def test_within_the_margin_each_path_is_cut_where_it_crosses_a_side(
    chair: Footprint, seed: int
) -> None:
    random = np.random.default_rng(seed)
    points = random.uniform(-0.8, 0.8, (3000, 2))
    points = points[chair.contains(points) & ~inside(chair.body, points)][:60]
    found = Sweeps(chair).contacts(points)
    polygons = [*chair.parts, chair.body]
    for (x, y), contacts in zip(points.tolist(), found, strict=True):
        own, radius = math.atan2(y, x), math.hypot(x, y)
        cut = np.concatenate([crossings(np.array([[x, y]]), one)[:, 0] for one in polygons])
        for direction, sign in ((codes.DIR_LEFT, 1.0), (codes.DIR_RIGHT, -1.0)):
            turns = (sign * (own - cut[~np.isnan(cut)])) % TURN

            def circle(way: float, own: float = own, r: float = radius, s: float = sign) -> Point:
                return r * math.cos(own - s * way), r * math.sin(own - s * way)

            expected = after_leaving(chair, False, turns, TURN, circle)
            assert contacts[direction] == pytest.approx(math.degrees(expected), abs=1e-9)
        for direction, sign in ((codes.DIR_FORWARD, 1.0), (codes.DIR_BACKWARD, -1.0)):
            ways = []
            for one in polygons:
                for (ax, ay), (bx, by) in zip(one, np.roll(one, -1, axis=0), strict=True):
                    if (ay > y) != (by > y):
                        ways.append(sign * (x - (ax + (bx - ax) * (y - ay) / (by - ay))))

            def line(way: float, x: float = x, y: float = y, s: float = sign) -> Point:
                return x - s * way, y

            ahead = np.array([way for way in ways if way >= 0.0])
            expected = after_leaving(chair, False, ahead, RANGE_M, line)
            assert contacts[direction] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("chair", CHAIRS)
def test_what_one_point_gets_does_not_depend_on_the_others(chair: Footprint) -> None:
    points, sweeps = points_around(20), Sweeps(chair)
    alone = np.concatenate([sweeps.contacts(one[None]) for one in points])
    assert sweeps.contacts(points).tobytes() == alone.tobytes()
    alone_bent = np.concatenate([sweeps.bent(one[None], 2.0) for one in points])
    assert sweeps.bent(points, 2.0).tobytes() == alone_bent.tobytes()
    beside = np.concatenate([sweeps.alongside(one[None]) for one in points])
    assert sweeps.alongside(points).tolist() == beside.tolist()


@pytest.mark.parametrize("range_m", [0.9, 3.0, math.inf])
@pytest.mark.parametrize("chair", CHAIRS)
def test_a_bend_is_a_circle_about_its_middle_to_either_side(
    chair: Footprint, range_m: float
) -> None:
    points, range_m = points_around(3), min(range_m, RANGE_M)
    points = points[points[:, 0] <= np.concatenate(chair.parts)[:, 0].max()]
    gap_m = np.maximum(distance_m(chair.body, points) - 0.001, 0.0)
    aside = np.sign(points[:, 1]) * np.minimum(gap_m, 0.01)
    nearest = np.column_stack((points[:, 0], points[:, 1] - aside))
    plain = np.full(len(points), np.inf)
    for side in (1.0, -1.0):
        middle = np.array((0.0, side / BEND_PER_M))
        own = np.arctan2(*(nearest - middle).T[::-1])
        turns = least(side * (crossings(nearest - middle, chair.body - middle) - own))
        plain = np.minimum(plain, turns / BEND_PER_M)
    plain[(plain > range_m) | inside(chair.body, points)] = np.inf
    found = Sweeps(chair).bent(points, range_m)
    hit = np.isfinite(found)
    assert hit.sum() > 10
    assert np.allclose(found[hit], plain[hit], rtol=1e-12)
    # It may leave out what only a wider swing than any bend's reaches.
    assert (np.abs(points[~hit & np.isfinite(plain), 1]) > chair.half_width_m).all()


@pytest.mark.parametrize("noise_m", [0.0, 0.006, 0.02])
@pytest.mark.parametrize("seed", range(4))
def test_smoothing_is_the_mean_of_what_is_near(seed: int, noise_m: float) -> None:
    random = np.random.default_rng(seed)
    bearings = np.sort(random.uniform(-math.pi, math.pi, 700))
    ranges = 1.5 + 0.8 * np.sin(3.0 * bearings) + noise_m * random.standard_normal(700)
    ranges[random.integers(0, 700, 20)] -= 0.4
    points = np.column_stack((ranges * np.cos(bearings), ranges * np.sin(bearings)))
    points += np.array((0.4, 0.1))
    seen = surface.surfaces(points, (0.4, 0.1))
    offset = points - (0.4, 0.1)
    bearings, ranges = np.arctan2(offset[:, 1], offset[:, 0]), np.hypot(*offset.T)
    gate_m = min(max(5.0 * surface.noise_m(ranges), 0.03), 0.15)
    near = np.flatnonzero(ranges < 2.0)
    expected = ranges.copy()
    for at, beam in enumerate(near):
        around = near[max(0, at - 12) : at + 13]
        around = around[np.abs(bearings[around] - bearings[beam]) < 0.03]
        centre = ranges[beam]
        for _ in range(2):
            total, count = 0.0, 0
            for value in ranges[around].tolist():
                if abs(value - centre) < gate_m:
                    total, count = total + value, count + 1
            centre = total / count if count else centre
        expected[beam] = centre
    assert seen.ranges_m.tobytes() == expected.tobytes()
    stretched = offset.T * (expected / ranges) + np.array(((0.4,), (0.1,)))
    assert seen.points_m.T.tobytes() == stretched.tobytes()
    turns = np.append(bearings[1:], bearings[:1] + TURN) - bearings
    assert seen.turns_rad.tobytes() == turns.tobytes()


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("chair", CHAIRS)
def test_alongside_is_what_the_side_margin_holds(chair: Footprint, seed: int) -> None:
    points = points_around(seed)
    points[100:300] = chair.body[0] * (0.3, 1.0) + np.linspace(-0.1, 0.1, 200)[:, None]
    expected = chair.contains(points) & ~inside(chair.body, points)
    expected &= (np.abs(points[:, 1]) <= chair.half_width_m) & (
        (points[:, 0] > chair.body[:, 0].min()) & (points[:, 0] < chair.body[:, 0].max())
    )
    assert expected.any()
    assert Sweeps(chair).alongside(points).tolist() == expected.tolist()


@pytest.mark.parametrize("seed", range(4))
def test_the_least_of_the_arcs_is_that_of_every_point(seed: int) -> None:
    chair = Footprint(margins=Margins(0.05, 0.02, 0.05))
    points = points_around(seed)
    points = np.repeat(points[inside(chair.body, points) == bool(seed % 2)], 2, axis=0)
    contacts, reach = Sweeps(chair).contacts(points), arc_reach(chair)
    doubted = np.arange(3, len(points), 7)
    every = reach.ways(points, contacts)
    assert reach.least(points, contacts).tolist() == every.min(axis=0).tolist()
    sure = np.delete(every, doubted, axis=0)
    assert reach.least(points, contacts, doubted).tolist() == sure.min(axis=0).tolist()


@pytest.mark.parametrize("pose", [Pose(0.5, 0.1, 170.0), Pose(-0.4, 0.2, -180.0, True)])
def test_a_view_is_the_plain_formula(pose: Pose) -> None:
    random = np.random.default_rng(5)
    angles = np.concatenate((random.uniform(-180.0, 180.0, 900), [-180.0, -0.0, 0.0, 122.0]))
    ranges = random.choice((0.0, 0.04, 1.0, 5.0), len(angles)) * random.uniform(1.0, 1.2)
    mask = ((122.0, -122.0), (10.0, 12.5))
    view = to_chair(Scan(angles, ranges, 1.0, codes.SIMULATED), pose, mask)
    kept = ranges >= 0.05
    for start, end in mask:
        kept &= (angles - start) % 360.0 > (end - start) % 360.0
    turned = -angles[kept] if pose.upside_down else angles[kept]
    radians = np.radians((turned + pose.heading_deg + 180.0) % 360.0 - 180.0)
    x, y = ranges[kept] * np.cos(radians), ranges[kept] * np.sin(radians)
    assert view.points_m.tobytes() == np.column_stack((pose.x_m + x, pose.y_m + y)).tobytes()


@pytest.mark.parametrize("pose", [Pose(), Pose(-0.4, 0.2, -180.0, True)])
def test_what_is_placed_as_it_comes_is_what_a_whole_scan_gives(pose: Pose) -> None:
    random = np.random.default_rng(6)
    placing = Placing(pose, ((122.0, -122.0),))
    sweep = Sweep(placing=placing)
    for first in range(0, 5000, 250):
        turned = np.arange(first, first + 250) * 0.225
        angles = (180.0 - turned) % 360.0 - 180.0
        ranges = random.choice((0.0, 0.04, 1.0, 5.0), 250) * random.uniform(1.0, 1.2)
        starts = np.diff(turned // 360.0, prepend=(first - 1) * 0.225 // 360.0) > 0.0
        sweep.take(Nodes(angles, ranges, starts, np.arange(249, -1, -1)), first * 6e-5)
        scan = sweep.scan()
        if scan is None or first < 3200:
            continue
        assert scan.placing is placing
        fast = view_of(scan, placing)
        plain = to_chair(
            Scan(scan.angles_deg, scan.distances_m, scan.acquired_s, scan.source),
            pose,
            ((122.0, -122.0),),
        )
        assert fast.points_m.tobytes() == plain.points_m.tobytes()
        assert fast.states.tobytes() == plain.states.tobytes()
        known = surface.surfaces(fast.points_m, fast.origin_m, fast.polar)
        found = surface.surfaces(fast.points_m, fast.origin_m)
        for name in ("points_m", "bearings_rad", "ranges_m"):  # as measured, or from x and y again
            assert getattr(known, name) == pytest.approx(getattr(found, name), abs=1e-12)


def test_a_movers_bins_are_those_of_the_remainder() -> None:
    points = points_around(7)
    found = Movers((0.1, -0.2))._ranges(points.T)
    offset = points - (0.1, -0.2)
    degrees = np.degrees(np.arctan2(offset[:, 1], offset[:, 0]) % TURN).astype(int)
    for degree in range(360):
        there = np.hypot(*offset.T)[degrees == degree]
        assert found[degree] == pytest.approx(there.min(initial=np.inf), rel=1e-15)
