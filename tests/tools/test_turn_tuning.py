"""The benchmark's tuning: pulses begin at any time between two samples, as on a real line."""

from __future__ import annotations

from gazemeasure.turn_cases import Drawn
from gazemeasure.turn_jobs import tune
from gazemeasure.turn_model import Case
from gazemeasure.turn_tuning import truth
from gazesim.profiles import undisturbed


def test_the_dead_time_found_is_the_chairs_and_the_sensors() -> None:
    """A pulse that always began right after a sample made it 6 ms short: turns went too far."""
    parameters = undisturbed("4.1")
    drawn = Drawn("4.1", Case(parameters, 90.0, seed=5))
    real_s = truth(parameters).dead_time_s + drawn.imu().errors.latency_s
    assert abs(tune(drawn).dead_time_s - real_s) < 0.004
