"""From recorded headings to numbers: exact on the model's own data, close on the twin's."""

from __future__ import annotations

import numpy as np
import pytest

from gazechair.tune import model
from gazechair.tune.identify import identify
from gazechair.tune.judge import judge
from gazechair.tune.model import Pulses, angle_deg
from gazechair.tune.numbers import TurnNumbers
from gazechair.tune.recording import Recording
from gazemeasure.turn_board import settings_with
from gazemeasure.turn_tuning import record
from gazesim.chair import Chair
from gazesim.imu_model import Imu, ImuErrors
from gazesim.profiles import PROFILES, random_chair, undisturbed
from tunerig import truth

PULSES = ((0.6, 0.4), (-0.6, 0.4), (1.0, 0.5), (-1.0, 0.6), (-0.5, 0.9), (0.3, 1.1), (1.0, 0.6))


def unknowns(numbers: TurnNumbers, caster_deg: float = 0.0, lie: float = 0.0) -> np.ndarray:
    """The model's own description of a chair, casters swinging over 20 degrees."""
    n = numbers
    sizes = np.log([n.left_dps, n.right_dps])
    rates = np.log([n.lag_s, n.accelerate_dps2, n.brake_dps2])
    casters = [caster_deg, np.log(20.0), lie]
    return np.array([[*sizes, n.deadband, n.dead_time_s, *rates, n.breakaway_dps, *casters, 0.0]])


def recorded(described: np.ndarray) -> list[Recording]:
    """What the model itself would have recorded, in a sensor's sixteenths."""
    time_s = np.arange(0.0, 3.0, 0.01)
    turning = [Recording(u, s, time_s, np.ones_like(time_s), 0.0) for u, s in PULSES]
    pulses = Pulses.of(turning)
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
    assert found.breakaway_dps == pytest.approx(true.breakaway_dps, abs=3.0)  # or dead time


@pytest.mark.parametrize(("deflection", "pulse_s"), [(1.0, 0.3), (0.4, 0.8), (-1.0, 1.0)])
def test_the_model_turns_as_the_twin_does(deflection: float, pulse_s: float) -> None:
    chair = Chair("3.1", 1, undisturbed("3.1"))
    chair.step(0.001, (0.0, 0.0))
    headings = []
    for ms in range(3000):
        headings.append(chair.heading_deg)
        chair.step(0.001, (0.0, deflection if ms < 1000 * pulse_s else 0.0))
    time_s = np.arange(3000) / 1000
    recording = Recording(deflection, pulse_s, time_s, np.array(headings), 0.0)
    numbers = truth(undisturbed("3.1"))
    described = unknowns(numbers)
    told = model.headings(described, Pulses.of([recording]))[0, 0]
    assert np.abs(told - recording.heading_deg).max() < 0.4  # it knows no friction
    assert abs(angle_deg(numbers, deflection, pulse_s) - abs(headings[-1])) < 0.4


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
    assert max(left, right) < 0.12
    assert lag < 0.15
    assert dead_s < 0.03
