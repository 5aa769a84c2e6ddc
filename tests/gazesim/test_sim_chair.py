"""The chair's model: profile speeds, dead time, deadband, ramps, coasting, and a lost joystick."""

import pytest

from gazesim import chair
from gazesim.chair import PROFILES, SPEEDS_KM_H, Chair

STEP_S = 0.001


def drive(model, stick, seconds):
    for _ in range(round(seconds / STEP_S)):
        model.step(STEP_S, stick)


def ready(profile="3.1", seed=1):
    model = Chair(profile, seed)
    model.step(STEP_S, (0.0, 0.0))
    return model


@pytest.mark.parametrize("profile", PROFILES)
def test_full_deflection_reaches_the_speeds_seen_on_the_chair(profile):
    forward, backward, left, right = SPEEDS_KM_H[profile]
    for stick, km_h in (((1, 0), forward), ((-1, 0), -backward)):
        model = ready(profile)
        drive(model, stick, 4.0)
        assert model.speed_m_s * 3.6 == pytest.approx(km_h, rel=0.15)
    for stick, km_h in (((0, 1), left), ((0, -1), -right)):
        model = ready(profile)
        drive(model, stick, 4.0)
        wheel_m_s = model.yaw_rate_deg_s * 3.14159 / 180 * chair.HALF_TRACK_M
        assert wheel_m_s * 3.6 == pytest.approx(km_h, rel=0.15)


def test_nothing_happens_within_the_dead_time():
    model = ready()
    dead_s = model.parameters.linear.dead_time_s
    drive(model, (1.0, 0.0), dead_s - 0.002)
    assert model.speed_m_s == 0.0
    drive(model, (1.0, 0.0), 0.05)
    assert model.speed_m_s > 0.0


def test_a_deflection_within_the_deadband_does_nothing():
    model = ready()
    drive(model, (0.07, -0.07), 2.0)
    assert (model.x_m, model.heading_deg) == (0.0, 0.0)


def test_it_speeds_up_no_faster_than_its_ramp():
    model = ready("5.1")
    before = 0.0
    for _ in range(2000):
        model.step(STEP_S, (1.0, 0.0))
        ramp = model.parameters.linear.accelerate * STEP_S
        assert model.speed_m_s - before < ramp * 1.2 + 0.01
        before = model.speed_m_s


def test_it_coasts_after_neutral_and_then_stands_still():
    model = ready("4.1")
    drive(model, (1.0, 0.0), 3.0)
    at_m = model.x_m
    drive(model, (0.0, 0.0), model.parameters.linear.dead_time_s)
    assert model.speed_m_s > 0.4  # the stop has not reached it yet
    drive(model, (0.0, 0.0), 4.0)
    assert model.speed_m_s == 0.0
    assert 0.15 < model.x_m - at_m < 0.6


def test_left_turns_counter_clockwise_and_forward_goes_where_it_looks():
    model = ready()
    drive(model, (0.0, 1.0), 2.0)
    assert model.heading_deg > 30.0
    model.place(0.0, 0.0, 90.0)
    drive(model, (0.0, 0.0), 2.0)
    model.place(0.0, 0.0, 90.0)
    drive(model, (1.0, 0.0), 2.0)
    assert model.y_m > 0.2
    assert abs(model.x_m) < 0.05


def test_a_lost_joystick_stops_it_shorter_than_neutral_does():
    ways = []
    for stick in ((0.0, 0.0), None):
        model = ready()
        drive(model, (1.0, 0.0), 3.0)
        at_m = model.x_m
        drive(model, stick, 3.0)
        assert model.speed_m_s == 0.0
        ways.append(model.x_m - at_m)
    assert ways[1] < ways[0]


def test_a_joystick_that_comes_back_deflected_is_refused_until_neutral():
    model = Chair()
    drive(model, None, 0.1)
    assert model.joystick == "absent"
    drive(model, (1.0, 0.0), 2.0)
    assert model.joystick == "not_neutral"
    assert model.x_m == 0.0
    drive(model, (0.0, 0.0), 0.1)
    assert model.joystick == "ok"
    drive(model, (1.0, 0.0), 2.0)
    assert model.x_m > 0.1


def test_equal_seeds_give_equal_ways_and_other_seeds_others():
    ways = []
    for seed in (1, 1, 2):
        model = ready(seed=seed)
        drive(model, (1.0, 0.2), 3.0)
        ways.append((model.x_m, model.y_m, model.heading_deg))
    assert ways[0] == ways[1] != ways[2]


def test_an_unknown_profile_is_refused_by_name():
    with pytest.raises(ValueError, match=r"no profile '9\.9'"):
        Chair("9.9")
