"""The heading sensor's error model: sample rate, latency, scale, drift, noise, steps of 1/16."""

import random
import statistics

import pytest

from gazesim.imu_model import Imu, ImuErrors

STEP_S = 0.001


def run(imu, rate, seconds, step_s=STEP_S):
    return sum(imu.step(step_s, rate) for _ in range(round(seconds / step_s)))


@pytest.mark.parametrize("step_s", [0.001, 0.002, 0.005])
def test_100_samples_a_second_whatever_the_step(step_s):
    assert run(Imu(ImuErrors()), 10.0, 1.0, step_s) == 100


def test_what_it_shows_is_that_old():
    imu = Imu(ImuErrors(latency_s=0.02))
    run(imu, 50.0, 1.0)
    assert imu.heading_deg == pytest.approx(50.0 - 50.0 * 0.02)
    run(imu, 0.0, 0.01)
    assert imu.rate_deg_s == 50.0  # it stands, but the output is delayed
    run(imu, 0.0, 0.02)
    assert imu.rate_deg_s == 0.0
    assert imu.heading_deg == pytest.approx(50.0)


def test_scale_and_drift_are_those_told():
    imu = Imu(ImuErrors(scale=1.01, drift_deg_s=0.1, latency_s=0.0))
    run(imu, 20.0, 10.0)
    assert imu.heading_deg == pytest.approx(10.0 * (20.0 * 1.01 + 0.1))
    assert imu.rate_deg_s == pytest.approx(20.2)


def test_noise_is_in_the_rate_and_not_in_the_heading():
    imu = Imu(ImuErrors(noise_deg_s=0.1), seed=2)
    rates = []
    for _ in range(500):
        run(imu, 0.0, 0.01)
        rates.append(imu.rate_deg_s)
    assert 0.08 < statistics.pstdev(rates) < 0.12
    assert imu.heading_deg == 0.0


def test_it_counts_in_sixteenths_and_jumps_when_told():
    imu = Imu(ImuErrors(latency_s=0.0))
    run(imu, -1.0, 1.0)
    assert (imu.heading_q4, imu.rate_q4) == (-16, -16)
    imu.jump(5.0)
    run(imu, 0.0, 0.01)
    assert imu.heading_q4 == 64
    imu.restart()
    assert imu.heading_q4 == 0


def test_sensors_drawn_lie_within_what_the_data_sheet_allows():
    for seed in range(100):
        errors = ImuErrors.drawn(random.Random(seed))
        assert abs(errors.scale - 1.0) <= 0.005
        assert abs(errors.drift_deg_s) * 60 <= 0.3
        assert 0.010 <= errors.latency_s <= 0.020
