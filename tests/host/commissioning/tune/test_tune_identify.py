"""From recorded headings to numbers: exact on the model's own data, close on the twin's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gazechair.commissioning.tune import beliefs, model
from gazechair.commissioning.tune.identify import identify
from gazechair.commissioning.tune.judge import judge
from gazechair.commissioning.tune.model import Pulses, angle_deg
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.recording import Recording
from gazemeasure.turn.board import settings_with
from gazemeasure.turn.cases import monte_carlo
from gazemeasure.turn.jobs import tune
from gazemeasure.turn.tuning import record, truth
from gazesim.chair import Chair
from gazesim.imu_model import Imu, ImuErrors
from gazesim.profiles import PROFILES, random_chair, undisturbed

pytestmark = pytest.mark.costly

PULSES = ((0.6, 0.4), (-0.6, 0.4), (1.0, 0.5), (-1.0, 0.6), (-0.5, 0.9), (0.3, 1.1), (1.0, 0.6))


def unknowns(numbers: TurnNumbers, caster_deg: float = 0.0, lie: float = 0.0) -> np.ndarray:
    """The model's own description of a chair, casters swinging over 20 degrees, and of PULSES on
    one even floor."""
    described = beliefs.unknowns(numbers, len(PULSES))
    described[[model.CASTER, model.CASTER_WAY, model.LIE]] = caster_deg, np.log(20.0), lie
    return described[None]


def recorded(described: np.ndarray) -> list[Recording]:
    """What the model itself would have recorded, in a sensor's sixteenths."""
    time_s = np.arange(0.0, 3.0, 0.01)
    turning = [Recording(u, s, time_s, np.ones_like(time_s), 0.0) for u, s in PULSES]
    pulses = Pulses.of(turning, [True] * len(turning))
    pulses = replace(pulses, away_rad=np.zeros_like(pulses.time_s))
    for _ in range(3):  # what the slope does hangs on the headings it leads to
        headings = model.headings(described, pulses)[0]
        starts = np.concatenate(([0.0], np.cumsum(headings[:, -1])[:-1]))
        pulses = replace(pulses, away_rad=np.radians(starts[:, None] + headings))
    headings = np.round(model.headings(described, pulses)[0] * 16) / 16
    headings[model.excess_dps(described, pulses)[0] > 0.0] = 0.0  # these do not break it loose
    return [Recording(u, s, time_s, h, 0.0) for (u, s), h in zip(PULSES, headings, strict=True)]


@pytest.mark.parametrize("caster_deg", [0.0, 9.0, -6.0])
@pytest.mark.parametrize(("lag_s", "breakaway_dps"), [(0.15, 0.0), (0.45, 0.0), (0.3, 6.0)])
def test_the_models_own_data_give_its_numbers_back(
    lag_s: float, breakaway_dps: float, caster_deg: float
) -> None:
    true = TurnNumbers(38.0, 31.0, 0.11, 0.2, lag_s, 40.0, 160.0, breakaway_dps)
    fit = identify(recorded(unknowns(true, caster_deg)), TurnNumbers.default("3.1"))
    assert fit.residual_deg < 0.1
    found = fit.numbers
    assert found.left_dps == pytest.approx(true.left_dps, rel=0.06)
    assert found.right_dps == pytest.approx(true.right_dps, rel=0.06)
    assert found.deadband == pytest.approx(true.deadband, abs=0.02)
    assert found.dead_time_s == pytest.approx(true.dead_time_s, abs=0.02)
    assert found.lag_s == pytest.approx(true.lag_s, rel=0.08)
    loose_dps = max(true.breakaway_dps, 0.4)  # its friction
    assert found.breakaway_dps == pytest.approx(loose_dps, abs=3.5)  # or dead time


def test_a_pulse_on_another_piece_of_floor_is_not_blamed_on_the_chair() -> None:
    true = TurnNumbers(38.0, 33.0, 0.11, 0.15, 0.3, 40.0, 160.0, 6.0)
    described = unknowns(true, 9.0)
    described[0, model.UNKNOWNS : -len(PULSES)] = 0.04, -0.04, -0.03, 0.05, 0.03, -0.04, 0.02
    fit = identify(recorded(described), TurnNumbers.default("3.1"))
    assert fit.residual_deg < 0.1
    found = fit.numbers
    assert found.left_dps == pytest.approx(true.left_dps, rel=0.06)
    assert found.right_dps == pytest.approx(true.right_dps, rel=0.06)
    assert found.brake_dps2 == pytest.approx(true.brake_dps2, rel=0.15)
    assert found.lag_s == pytest.approx(true.lag_s, rel=0.05)
    assert found.caster_deg == pytest.approx(9.0, abs=1.0)


def test_a_slope_that_changes_with_the_heading_is_not_blamed_on_the_chair() -> None:
    true = TurnNumbers(38.0, 33.0, 0.11, 0.15, 0.3, 40.0, 160.0, 6.0)
    described = unknowns(true)
    described[0, [model.SLOPE, model.BEND]] = 0.7, 1.2
    found = identify(recorded(described), TurnNumbers.default("3.1")).numbers
    assert found.left_dps == pytest.approx(true.left_dps, rel=0.06)
    assert found.right_dps == pytest.approx(true.right_dps, rel=0.06)
    assert found.brake_dps2 == pytest.approx(true.brake_dps2, rel=0.2)


@pytest.mark.parametrize("seed", [259, 604, 677])
def test_the_deepest_valley_is_found_among_many(seed: int) -> None:
    # Here wrong numbers explain the pulses nearly as well, and descents ended in them.
    drawn = monte_carlo(seed)[-1]
    true, found = truth(drawn.case.parameters), tune(drawn)
    assert found.left_dps == pytest.approx(true.left_dps, rel=0.1)
    assert found.right_dps == pytest.approx(true.right_dps, rel=0.1)
    assert found.brake_dps2 == pytest.approx(true.brake_dps2, rel=0.3)
    assert found.dead_time_s == pytest.approx(true.dead_time_s + 0.015, abs=0.04)


@pytest.mark.parametrize("seed", [348, 489, 831])
def test_a_pulse_whose_turn_the_casters_took_back_did_not_stick(seed: int) -> None:
    drawn = monte_carlo(seed)[-1]
    true, found = truth(drawn.case.parameters), tune(drawn)
    assert found.breakaway_dps == pytest.approx(true.breakaway_dps, abs=3.0)  # or deadband
    assert found.caster_deg == pytest.approx(drawn.case.parameters.disturbances.caster_deg, abs=1.0)
    assert found.right_dps == pytest.approx(true.right_dps, rel=0.1)


def test_doubtful_pulses_are_read_both_ways_unless_the_sensor_is_noisy() -> None:
    def turning(*most_deg: float) -> list[Recording]:
        return [Recording(1.0, 0.5, np.arange(2.0), np.array([0.0, m]), 0.0) for m in most_deg]

    assert model.readings(turning(5.0, -0.06, 0.4)) == [(True, False, True)]
    assert model.readings(turning(5.0, -0.13)) == [(True, False), (True, True)]
    assert len(model.readings(turning(5.0, 0.1, 0.2, 0.29))) == 8
    assert model.readings(turning(0.1, 0.2, 0.29, 0.2)) == [(False,) * 4]


def test_casters_that_take_back_most_of_a_turn_are_no_reversed_channel() -> None:
    # All pulses together turned this chair the other way.
    drawn = monte_carlo(1163)[-1]
    true, found = truth(drawn.case.parameters), tune(drawn)
    assert found.left_dps == pytest.approx(true.left_dps, rel=0.1)
    assert found.caster_deg == pytest.approx(drawn.case.parameters.disturbances.caster_deg, abs=1.0)


@pytest.mark.parametrize(("deflection", "pulse_s"), [(1.0, 0.3), (0.4, 0.8), (-1.0, 1.0)])
@pytest.mark.parametrize("friction_dps", [0.0, 0.4, 1.3])
def test_the_model_turns_as_the_twin_does(
    deflection: float, pulse_s: float, friction_dps: float
) -> None:
    parameters = undisturbed("3.1")
    parameters = replace(parameters, turn=replace(parameters.turn, friction=friction_dps))
    chair = Chair("3.1", 1, parameters)
    chair.step(0.001, (0.0, 0.0))
    headings = []
    for ms in range(3000):
        headings.append(chair.heading_deg)
        chair.step(0.001, (0.0, deflection if ms < 1000 * pulse_s else 0.0))
    time_s = np.arange(3000) / 1000
    recording = Recording(deflection, pulse_s, time_s, np.array(headings), 0.0)
    numbers = truth(undisturbed("3.1"))
    described = beliefs.unknowns(numbers, 1)[None]
    described[0, [model.LIE, model.FRICTION]] = 0.0, friction_dps
    reported = model.headings(described, Pulses.of([recording], [True]))[0, 0]
    assert np.abs(reported - recording.heading_deg).max() < 0.02
    off_deg = abs(angle_deg(numbers, deflection, pulse_s) - abs(headings[-1]))
    assert off_deg < 0.25 + 0.5 * friction_dps  # it knows none


@pytest.mark.parametrize("profile", PROFILES)
def test_undisturbed_chairs_are_found_within_a_few_percent(profile: str) -> None:
    parameters = undisturbed(profile)
    recordings = record(Chair(profile, 1, parameters), Imu(ImuErrors()), settings_with({}), profile)
    fit = identify(recordings, TurnNumbers.default(profile))
    judge(recordings, fit)
    true, found = truth(parameters), fit.numbers
    assert found.left_dps == pytest.approx(true.left_dps, rel=0.06)
    assert found.right_dps == pytest.approx(true.right_dps, rel=0.06)
    assert found.deadband == pytest.approx(true.deadband, abs=0.03)
    assert found.dead_time_s == pytest.approx(true.dead_time_s + 0.02, abs=0.015)
    assert found.lag_s == pytest.approx(true.lag_s, rel=0.10)


def test_most_chairs_on_bad_floors_with_swinging_casters_are_found_too() -> None:
    off = []
    for seed in range(1, 13):
        profile = tuple(PROFILES)[seed % 5]
        parameters = random_chair(profile, seed)
        imu = Imu(ImuErrors(noise_deg_s=0.1), seed)
        recordings = record(Chair(profile, seed, parameters), imu, settings_with({}), profile)
        found, true = identify(recordings, TurnNumbers.default(profile)).numbers, truth(parameters)
        off.append(
            (
                abs(found.left_dps / true.left_dps - 1),
                abs(found.right_dps / true.right_dps - 1),
                abs(found.lag_s / true.lag_s - 1),
                abs(found.dead_time_s - true.dead_time_s - 0.02),
            )
        )
    left, right, lag, dead_s = np.quantile(np.array(off), 0.75, axis=0)
    assert max(left, right) < 0.06
    assert lag < 0.05
    assert dead_s < 0.02
