"""`gazechair tune` on the real firmware and the twin in virtual time: found, bounded, abortable."""

from __future__ import annotations

import pytest

from gazechair.commissioning.tune import TuneError
from gazechair.commissioning.tune.identify import identify
from gazechair.commissioning.tune.judge import fits_profile, judge
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.recording import Recording
from gazechair.commissioning.tune.runner import Runner
from gazelink import codes
from gazemeasure.turn.tuning import truth
from tunerig import TuneRig, tune_rig

pytestmark = pytest.mark.costly

NEUTRAL = 170
SENSOR_S = 0.015  # the twin's heading sensor is that late, and a telemetry sample 0..10 ms old


def run(rig: TuneRig, abort_at_ms: int = 1 << 30) -> list[Recording]:
    """One run; somebody presses a key at that time."""
    return Runner(rig.hands(abort_at_ms)).run(TurnNumbers.default("3.1"), NEUTRAL)


def assert_ended(rig: TuneRig) -> None:
    """Assert that it is neutral and disarmed, and stays so."""
    assert rig.neutral(), rig.why()
    rig.comes_to_rest()
    rig.wait(0.5)
    assert rig.neutral()
    assert not rig.armed()


def test_the_chair_is_found_as_it_is() -> None:
    rig = tune_rig()
    began_ms = rig.now_ms
    recordings = run(rig)
    assert rig.now_ms - began_ms < 40_000
    assert sum(r.pulse_s for r in recordings) <= 10.0
    assert rig.farthest_deg < 25.0
    assert_ended(rig)
    assert abs(rig.world.chair.heading_deg - rig.start_deg) < 8.0  # back again
    fit = identify(recordings, TurnNumbers.default("3.1"))
    judge(recordings, fit)
    fits_profile(fit.numbers, "3.1")
    true, found = truth(rig.world.chair.parameters), fit.numbers
    assert found.left_dps == pytest.approx(true.left_dps, rel=0.05)
    # The board's full deflection is 84 counts, of the 85 that the chair knows to the right.
    assert found.right_dps == pytest.approx(true.right_dps * 84 / 85, rel=0.05)
    assert found.deadband == pytest.approx(true.deadband, abs=0.015)
    assert 0.0 < found.dead_time_s - true.dead_time_s < SENSOR_S + 0.020
    assert found.lag_s == pytest.approx(true.lag_s, rel=0.10)
    assert found.accelerate_dps2 == pytest.approx(true.accelerate_dps2, rel=0.10)
    assert found.brake_dps2 == pytest.approx(true.brake_dps2, rel=0.15)


# While arming, before a pulse, in pulses both ways, while it runs out, near the end.
@pytest.mark.parametrize("after_ms", [20, 120, 900, 1200, 2900, 3300, 6000, 7300])
def test_any_key_stops_it_at_once(after_ms: int) -> None:
    rig = tune_rig()
    pressed_ms = rig.now_ms + after_ms
    with pytest.raises(TuneError, match="stopped; nothing was changed"):
        run(rig, pressed_ms)
    assert_ended(rig)


@pytest.mark.parametrize("after_ms", [20, 900, 1200, 3300, 7300])
def test_a_tool_that_dies_stops_it_too(after_ms: int) -> None:
    rig = tune_rig()
    rig.dies_at_ms = rig.now_ms + after_ms
    with pytest.raises(TuneError, match=r"fallen silent|does not arm"):
        run(rig)
    assert rig.moved_after_death_ms <= 300  # the hold's time to live; the host's silence is sooner
    assert_ended(rig)


def test_an_obstacle_ends_it_with_its_reason() -> None:
    rig = tune_rig()
    rig.blocked_at_ms = rig.now_ms + 1200
    with pytest.raises(TuneError, match="the board stopped the pulse: obstacle_"):
        run(rig)
    assert_ended(rig)


def test_without_obstacle_data_nothing_moves() -> None:
    rig = tune_rig()
    rig.sees = False
    rig.wait(0.5)
    with pytest.raises(TuneError, match="not ready: obstacle_data_old"):
        run(rig)
    assert rig.farthest_deg == 0.0


@pytest.mark.parametrize(
    ("fault", "reason"), [("imu_freeze", "heading"), ("emergency", "emergency"), ("tilt", "tilt")]
)
def test_every_fault_of_the_board_ends_it_with_its_reason(fault: str, reason: str) -> None:
    rig = tune_rig()
    rig.strikes = (rig.now_ms + 1150, fault)
    with pytest.raises(TuneError, match=reason):
        run(rig)
    assert_ended(rig)


def test_a_driver_who_is_driving_is_not_interrupted() -> None:
    rig = tune_rig()
    rig.link.order(codes.ARM, codes.DRIVER)
    rig.wait(0.5)
    with pytest.raises(TuneError, match="driving is on"):
        run(rig)
