"""The turn benchmark measures what it says: its bound, its model, its judge, its wipers."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gazemeasure.turn import jobs
from gazemeasure.turn import stops as turn_stops
from gazemeasure.turn.bound import bounds
from gazemeasure.turn.cases import grid, monte_carlo
from gazemeasure.turn.jobs import DEFAULTS, TUNED, Job
from gazemeasure.turn.judge import Turn, judge
from gazemeasure.turn.model import Case, Model, Switches, outcome
from gazesim.chair import Chair
from gazesim.profiles import Parameters, random_chair, undisturbed

pytestmark = pytest.mark.costly


def slow(parameters: Parameters) -> Parameters:
    """That chair with more dead time and lag."""
    return replace(parameters, turn=replace(parameters.turn, lag_s=0.45, dead_time_s=0.25))


@pytest.mark.parametrize("parameters", [undisturbed("3.1"), slow(undisturbed("2.1"))])
@pytest.mark.parametrize("angle_deg", [5.0, -20.0])
def test_no_three_switches_of_a_fine_grid_beat_the_bound(
    parameters: Parameters, angle_deg: float
) -> None:
    case = Case(parameters, angle_deg)
    best_s = float(bounds([case])[0])
    model = Model.of([case])
    guess = model.angle[0, 0] / model.forward[0, 0]
    t1, t2, t3 = (
        each.reshape(1, -1)
        for each in np.meshgrid(
            np.arange(0.5 * guess, guess + 0.9, 0.012),
            np.arange(0.0, 0.8, 0.04),
            np.arange(0.0, 0.25, 0.06),
        )
    )
    settled, _ = outcome(model, Switches(t1, t2, t3))
    brute_s = float(settled.min() + model.dead[0, 0])
    assert best_s <= 1.02 * brute_s  # a chair that sticks gains a little by a third
    assert best_s >= brute_s - 0.08  # the grid is coarse, the search is not magic


@pytest.mark.parametrize("seed", [2, 9, 31])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_vectorised_model_turns_as_the_twin_does(seed: int, side: float) -> None:
    profile = ("1.2", "3.1", "5.1")[seed % 3]
    parameters = random_chair(profile, seed)
    case = Case(parameters, side * 20.0, seed, 0.05)
    t1, t2 = 0.5, 0.25
    chair = Chair(profile, seed, parameters)
    headings = []
    for ms in range(3500):
        since = ms - 50
        stick = side if 0 <= since < 500 else -side if 500 <= since < 750 else 0.0
        chair.step(0.001, (0.0, stick))
        headings.append(chair.heading_deg)
    _, end = outcome(Model.of([case]), Switches.two(np.array([[t1]]), np.array([[t2]])))
    assert side * end[0, 0] == pytest.approx(headings[-1], abs=0.3)


def test_the_search_repeats_and_grows_with_angle_and_disturbance() -> None:
    plain = [Case(undisturbed("2.1"), angle) for angle in (5.0, 20.0)]
    first, again = bounds(plain), bounds(plain)
    assert np.array_equal(first, again)
    assert np.all(np.diff(first) > 0)
    drawn = [each.case for each in monte_carlo(5)]
    assert np.all(np.isfinite(bounds(drawn)))


def turn(heading: np.ndarray, count: np.ndarray | None = None) -> Turn:
    """A turn of 10 degrees with that heading each ms."""
    rate = np.gradient(heading) * 1000
    counts = np.full(len(heading), 170, np.int16) if count is None else count
    return Turn(10.0, heading, rate, counts)


TIME_S = np.arange(6000) / 1000


def test_settling_begins_with_the_second_that_keeps_to_the_definition() -> None:
    heading = np.minimum(10.0 * TIME_S / 2.0, 9.5)  # 5 deg/s, then still
    verdict = judge(turn(heading))
    assert verdict.settled_s == pytest.approx(1.9, abs=0.01)
    assert verdict.overshoot_deg == 0.0
    assert verdict.end_error_deg == pytest.approx(0.5)
    assert verdict.stands
    assert not verdict.oscillates


def test_a_creeping_chair_has_not_settled() -> None:
    verdict = judge(turn(np.minimum(9.0 + 1.2 * TIME_S, 11.0)))
    assert verdict.settled_s > 1.6


def test_a_turn_short_of_the_band_never_settles() -> None:
    verdict = judge(turn(np.minimum(5.0 * TIME_S, 8.9)))
    assert math.isnan(verdict.settled_s)


@pytest.mark.parametrize(
    ("decay", "oscillates", "unstable"),
    [(3.0, False, False), (0.3, True, False), (-0.1, True, True)],
)
def test_oscillation_and_instability_are_told_apart(
    decay: float, oscillates: bool, unstable: bool
) -> None:
    heading = 10.0 - 10.0 * np.exp(-decay * TIME_S) * np.cos(6.0 * TIME_S)
    verdict = judge(turn(heading))
    assert verdict.oscillates == oscillates
    assert verdict.unstable == unstable


def test_a_wiper_that_changes_sides_too_often_oscillates() -> None:
    count = np.full(len(TIME_S), 170, np.int16)
    for k in range(4):
        count[3000 + 200 * k : 3100 + 200 * k] = 180 if k % 2 else 160
    assert judge(turn(np.full(len(TIME_S), 10.0), count)).oscillates


def test_leaving_the_band_after_settling_is_seen() -> None:
    heading = np.where(TIME_S < 4.0, 10.0, 10.0 + 2.0 * (TIME_S - 4.0))
    verdict = judge(turn(heading))
    assert verdict.settled_s == 0.0
    assert verdict.left_again


def test_tuned_turns_land_and_defaults_stop() -> None:
    drawn = grid()[22]
    tuned = jobs.run(Job(TUNED, drawn))
    assert tuned.refused == ""
    assert tuned.verdict.settled_s < 3.0
    assert jobs.run(Job(DEFAULTS, monte_carlo(3)[2])).verdict.stands


def test_jobs_repeat_exactly() -> None:
    drawn = monte_carlo(5)[4]
    assert jobs.run(Job(TUNED, drawn)) == jobs.run(Job(TUNED, drawn))


def test_stop_paths_find_what_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(turn_stops, "CAUSES", {"stop": turn_stops.CAUSES["stop"]})
    stops = turn_stops.stop_paths(250, True)
    assert (stops.paths, stops.not_neutral, stops.never) == (1, 0, 0)
    assert stops.worst_stop_ticks == 1
    monkeypatch.setattr(turn_stops, "CAUSES", {"nothing": lambda chair: None})
    monkeypatch.setattr(turn_stops, "_WAIT_MS", 20)
    assert turn_stops.stop_paths(250, True).never == 1
