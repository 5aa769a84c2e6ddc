"""Noise, isolated returns, views and several lidars, up to the values sent to the board."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.base.footprint import Footprint
from gazechair.sensing.clearance.evaluate import Evaluator
from gazechair.sensing.clearance.reach import FREE, LidarReach
from gazechair.sensing.clearance.surface import noise_m, surfaces
from gazechair.sensing.clearance.sweeps import BEND_PER_M
from gazechair.sensing.lidar.blind import BLIND, MASKED, SEEN
from gazechair.sensing.lidar.scan import ChairView
from gazelink import codes
from gazelink.messages import CLEAR_FAR
from gazesim.zone import zone_of

F, B, L, R = codes.DIR_FORWARD, codes.DIR_BACKWARD, codes.DIR_LEFT, codes.DIR_RIGHT
CHAIR = Footprint()
ORIGIN = (0.5, 0.0)
ROUND = np.radians(np.arange(-180.0, 180.0, 0.1125))
OPEN = np.full(360, SEEN, dtype=np.uint8)

ZONE = zone_of()


def reach_of(chair: Footprint) -> LidarReach:
    reach = LidarReach(chair)
    reach.use(ZONE)
    return reach


def evaluator_of(origins_m: list[tuple[float, float]]) -> Evaluator:
    evaluator = Evaluator(CHAIR, origins_m)
    evaluator.zone = ZONE
    return evaluator


def points(ranges_m: np.ndarray, origin: tuple[float, float] = ORIGIN) -> np.ndarray:
    found = np.column_stack((np.cos(ROUND), np.sin(ROUND))) * ranges_m[:, None] + origin
    return found[ranges_m > 0]


def hall(radius_m: float = 4.0) -> np.ndarray:
    return np.full(len(ROUND), radius_m)


def view(ranges_m: np.ndarray, at_s: float = 1.0) -> ChairView:
    return ChairView(points(ranges_m), OPEN, ORIGIN, at_s, codes.SIMULATED)


def with_beams(ranges_m: np.ndarray, deg: float, distance_m: float, count: int = 1) -> np.ndarray:
    changed = ranges_m.copy()
    first = int(np.argmin(np.abs(ROUND - math.radians(deg))))
    changed[first : first + count] = distance_m
    return changed


def bits(*directions: int) -> int:
    return sum(1 << direction for direction in directions)


# -- noise -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("sigma_m", [0.006, 0.03])
def test_noise_is_measured_and_taken_off_surfaces(sigma_m: float) -> None:
    rough = hall(1.5) + np.random.default_rng(1).normal(0.0, sigma_m, len(ROUND))
    assert noise_m(rough) == pytest.approx(sigma_m, rel=0.1)
    smooth = surfaces(points(rough), ORIGIN).points_m - ORIGIN
    error = np.hypot(smooth[:, 0], smooth[:, 1]) - 1.5
    assert error.std() < 0.4 * sigma_m
    assert abs(error.mean()) < 0.05 * sigma_m
    assert error.min() > -1.5 * sigma_m


def test_a_single_beam_that_stands_out_keeps_its_place() -> None:
    rough = hall(1.5) + np.random.default_rng(1).normal(0.0, 0.03, len(ROUND))
    seen = surfaces(points(with_beams(rough, 10.0, 1.0)), ORIGIN)
    nearest = np.hypot(*(seen.points_m - ORIGIN).T)
    assert nearest.min() == pytest.approx(1.0)
    assert seen.lone[nearest.argmin()]


@given(st.floats(0.2, 3.0), st.integers(0, 3199), st.floats(0.0, 0.03))
@settings(max_examples=60, deadline=None)
def test_no_beam_is_moved_further_than_the_noise_allows(
    distance_m: float, at: int, sigma_m: float
) -> None:
    rough = hall(3.0) + np.random.default_rng(at).normal(0.0, sigma_m, len(ROUND))
    rough[at] = distance_m
    seen = surfaces(points(rough), ORIGIN)
    bearings = np.arctan2(*(points(rough) - ORIGIN).T[::-1])
    before = np.sort(rough[np.argsort(bearings, kind="stable")])
    after = np.sort(np.hypot(*(seen.points_m - ORIGIN).T))
    assert np.abs(before - after).max() <= 0.3


# -- speckles --------------------------------------------------------------------------------------


def test_a_speckle_beyond_the_stop_zone_slows_nothing() -> None:
    reach = reach_of(CHAIR)
    far_m = 0.70 + ZONE.far[F] + 0.1 - ORIGIN[0]
    assert reach.update(view(with_beams(hall(), 0.0, far_m))) == FREE or (
        reach.update(view(with_beams(hall(), 0.0, far_m)))[F] > 3.0
    )
    two = reach_of(CHAIR).update(view(with_beams(hall(), 0.0, far_m, count=2)))
    assert two[F] == pytest.approx(ZONE.far[F] + 0.1, abs=0.01)


def test_a_speckle_in_two_turns_is_an_obstacle() -> None:
    reach = reach_of(CHAIR)
    far_m = 1.5
    ways = [reach.update(view(with_beams(hall(), 0.0, far_m), at_s))[F] for at_s in (1.0, 1.02)]
    assert min(ways) > 3.0  # the same turn seen twice is one turn
    assert reach.update(view(with_beams(hall(), 0.1, far_m), 1.1))[F] == pytest.approx(
        1.3, abs=0.01
    )
    late = reach_of(CHAIR)
    late.update(view(with_beams(hall(), 0.0, far_m), 1.0))
    assert late.update(view(with_beams(hall(), 0.0, far_m), 2.0))[F] > 3.0


@given(st.floats(0.25, 0.70), st.floats(-25.0, 25.0))
@settings(max_examples=50, deadline=None)
def test_within_the_stop_zone_a_single_beam_counts(distance_m: float, deg: float) -> None:
    x = ORIGIN[0] + distance_m * math.cos(math.radians(deg))
    way = reach_of(CHAIR).update(view(with_beams(hall(), deg, distance_m)))[F]
    assert way <= max(0.0, x - 0.65)


def test_nothing_in_sight_is_free() -> None:
    nothing = ChairView(np.zeros((0, 2)), OPEN, ORIGIN, 1.0, codes.REAL)
    assert reach_of(CHAIR).update(nothing) == FREE


# -- views and several lidars ----------------------------------------------------------------------


def states(kind: int, *arcs: tuple[int, int]) -> np.ndarray:
    changed = OPEN.copy()
    for start, end in arcs:
        changed[start + 180 : end + 180] = kind
    return changed


def blank(view_states: np.ndarray = OPEN, origin: tuple[float, float] = ORIGIN) -> ChairView:
    return ChairView(points(hall()), view_states, origin, 1.0, codes.REAL)


def judged(merger: Evaluator, *views: ChairView) -> tuple[int, int]:
    reported = merger(views)
    return reported["blocked"], reported["unseen"]


@pytest.mark.parametrize(
    ("arc", "hit"),
    [
        ((-10, 10), bits(F, L, R)),  # a turning corner passes before the front
        ((-180, -170), bits(B, L, R)),
        ((100, 110), bits(L)),  # beside the front wheel: the front corner swings out there
        ((60, 62), bits(F, R)),
        ((20, 40), bits(F, L, R)),
    ],
)
def test_a_blind_arc_blocks_what_enters_it_and_a_masked_one_is_unseen(
    arc: tuple[int, int], hit: int
) -> None:
    evaluator = evaluator_of([ORIGIN])
    assert judged(evaluator, blank()) == (0, 0)
    assert judged(evaluator, blank(states(BLIND, arc))) == (hit, 0)
    assert judged(evaluator, blank(states(MASKED, arc))) == (0, hit)
    assert judged(evaluator, blank()) == (0, 0)  # back by itself


def test_the_prototypes_lidar_never_sees_behind() -> None:
    view = blank(states(MASKED, (124, 180), (-180, -124)))
    assert judged(evaluator_of([ORIGIN]), view) == (0, bits(B, L, R))


FRONT = states(MASKED, (90, 180), (-180, -90))
REAR = states(MASKED, (-80, 80))
LOST = states(BLIND, (-180, -80), (80, 180))
LOST[100:260] = MASKED


def test_a_second_lidar_sees_what_the_first_does_not() -> None:
    evaluator = evaluator_of([ORIGIN, (-0.4, 0.0)])
    blocked, unseen = judged(evaluator, blank(FRONT), blank(REAR, (-0.4, 0.0)))
    assert (blocked, unseen & bits(F, B)) == (0, 0)


def test_of_two_lidars_one_lost_blocks_what_only_it_sees() -> None:
    evaluator = evaluator_of([ORIGIN, (-0.4, 0.0)])
    lost = ChairView(np.zeros((0, 2)), LOST, (-0.4, 0.0), 0.0, codes.REAL)
    blocked, _ = judged(evaluator, blank(FRONT), lost)
    assert blocked == bits(B, L, R)
    assert judged(evaluator, blank(FRONT), blank(REAR, (-0.4, 0.0)))[0] == 0


def test_the_nearer_of_two_counts() -> None:
    evaluator = evaluator_of([ORIGIN, (-0.4, 0.0)])
    ahead = view(with_beams(hall(), 0.0, 1.0, 40))
    behind = ChairView(
        np.array([[-1.5, 0.0], [-1.5, 0.005], [-1.5, -0.005]]), OPEN, (-0.4, 0.0), 1.0, codes.REAL
    )
    for _ in range(2):
        reported = evaluator((ahead, behind))
    assert reported["forward_mm"] == pytest.approx(800, abs=45)
    assert reported["backward_mm"] == pytest.approx(1000, abs=41)


def walls(distance_m: float) -> ChairView:
    return view(with_beams(hall(), -2.0, distance_m + 0.2, 40))


def test_noise_does_not_move_what_is_said() -> None:
    evaluator = evaluator_of([ORIGIN])
    noise = np.random.default_rng(2).uniform(-0.015, 0.015, 200)
    reported = [evaluator((walls(1.0 + n),))["forward_mm"] for n in noise]
    assert len(set(reported[100:])) == 1
    assert max(reported[100:]) <= 1000
    nothing = evaluator((ChairView(np.zeros((0, 2)), OPEN, ORIGIN, 9.0, codes.REAL),))
    assert nothing["forward_mm"] == nothing["right_q4_deg"] == CLEAR_FAR


@given(st.lists(st.floats(0.1, 3.0), min_size=1, max_size=8))
@settings(max_examples=20, deadline=None)
def test_what_is_said_never_exceeds_what_is_seen(ways: list[float]) -> None:
    evaluator = evaluator_of([ORIGIN])
    before_mm = 0
    for way in ways:
        seen_mm = 1000.0 * reach_of(CHAIR).update(walls(way))[F]
        reported_mm = evaluator((walls(way),))["forward_mm"]
        assert reported_mm <= seen_mm
        assert reported_mm >= min(seen_mm, max(before_mm, seen_mm - 40.0)) - 1.001
        before_mm = reported_mm


# -- bends -----------------------------------------------------------------------------------------


def beside(gap_m: float, x: float = 0.3) -> ChairView:
    """A post at that distance beside the chair, seen by a lidar at its front corner."""
    y = 0.375 + gap_m
    post = np.column_stack((np.linspace(x - 0.02, x + 0.02, 9), np.full(9, y)))
    return ChairView(np.concatenate((post, points(hall()))), OPEN, ORIGIN, 1.0, codes.SIMULATED)


def test_backward_beside_an_obstacle_the_path_may_bend() -> None:
    margin_m = 0.1
    for gap_m in (0.025, 0.03):
        # Aside after d: 0.2 per metre * (0.3 m * d + d * d / 2); an edge may be 1 cm nearer.
        bend_m = math.sqrt(0.09 + 2.0 * (gap_m - 0.01) / BEND_PER_M) - 0.3
        ways = reach_of(CHAIR).update(beside(gap_m))
        assert ways[B] == pytest.approx(bend_m + margin_m, abs=0.05)
        assert ways[F] > 2.0  # the board holds the heading
    assert reach_of(CHAIR).update(beside(0.15))[B] > 2.0


def test_forward_an_obstacle_within_the_side_margin_leaves_creep() -> None:
    creeps_m = float(ZONE.of(F).permits_at[1])  # type: ignore[union-attr]
    for gap_m in (0.0, 0.005, 0.018):
        for x in (-0.4, 0.0, 0.6):
            reported = reach_of(CHAIR).update(beside(gap_m, x))[F]
            # The board wants 6 cm more before it goes on, and the evaluation keeps 4 cm back.
            assert creeps_m + 0.10 < reported < creeps_m + 0.12
    assert reach_of(CHAIR).update(beside(0.03))[F] > 2.0


def test_a_bend_longer_than_stopping_takes_limits_nothing() -> None:
    most_m = float(ZONE.of(B).permits_at.max())  # type: ignore[union-attr]
    for gap_m in np.linspace(0.01, 0.4, 40):
        reported = reach_of(CHAIR).update(beside(float(gap_m)))[B]
        assert reported <= most_m or reported > 2.5


def test_until_the_board_has_said_how_it_stops_a_bend_has_no_margin() -> None:
    with_margin = reach_of(CHAIR).update(beside(0.03))[B]
    assert LidarReach(CHAIR).update(beside(0.03))[B] == pytest.approx(with_margin - 0.1)


def test_a_single_beam_beside_the_chair_bends_the_path_too() -> None:
    alone = np.array([[0.3, 0.395]])
    view = ChairView(np.concatenate((alone, points(hall()))), OPEN, ORIGIN, 1.0, codes.SIMULATED)
    assert reach_of(CHAIR).update(view)[B] < 0.4
