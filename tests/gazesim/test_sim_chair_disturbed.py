"""Friction, load, floor and casters of the chair's twin; other chairs; steps of 1 to 5 ms agree."""

import random
from dataclasses import replace

import pytest

from gazesim.chair import Chair, Disturbances
from gazesim.profiles import PROFILES, random_chair, undisturbed

STEP_S = 0.001
QUIET = undisturbed("4.1")


def chair_with(turn=None, **disturbances):
    axis = replace(QUIET.turn, **(turn or {}))
    numbers = replace(QUIET, turn=axis, disturbances=Disturbances(**disturbances))
    model = Chair("4.1", 1, numbers)
    model.step(STEP_S, (0.0, 0.0))
    return model


def drive(model, stick, seconds, step_s=STEP_S):
    for _ in range(round(seconds / step_s)):
        model.step(step_s, stick)


def test_the_undisturbed_chair_of_each_profile_repeats_itself_whatever_the_seed():
    for profile in PROFILES:
        ways = []
        for seed in (1, 2):
            model = Chair(profile, seed, undisturbed(profile))
            model.step(STEP_S, (0.0, 0.0))
            drive(model, (0.5, 0.5), 2.0)
            ways.append((model.x_m, model.y_m, model.heading_deg))
        assert ways[0] == ways[1]


def test_stiction_holds_a_standing_chair_but_not_a_moving_one():
    turn = {"deadband": 0.0, "friction": 0.0, "stiction": 0.2 * QUIET.turn.positive}
    model = chair_with(turn)
    drive(model, (0.0, 0.15), 2.0)
    assert model.heading_deg == 0.0
    drive(model, (0.0, 0.4), 1.0)
    drive(model, (0.0, 0.15), 3.0)
    assert model.yaw_rate_deg_s > 0.1 * QUIET.turn.positive


def test_a_turn_against_the_motion_sticks_where_it_turns_round():
    model = chair_with({"deadband": 0.0, "stiction": 0.2 * QUIET.turn.positive})
    drive(model, (0.0, 0.5), 2.0)
    drive(model, (0.0, -0.1), 4.0)
    assert model.yaw_rate_deg_s == 0.0


def test_friction_costs_speed_except_at_full_deflection():
    free, rubbing = chair_with({"friction": 0.0}), chair_with({"friction": 5.0, "stiction": 0.0})
    for model in (free, rubbing):
        drive(model, (0.0, 0.4), 4.0)
    assert rubbing.yaw_rate_deg_s < free.yaw_rate_deg_s - 2.0
    drive(rubbing, (0.0, 1.0), 4.0)
    assert rubbing.yaw_rate_deg_s == pytest.approx(QUIET.turn.positive, rel=0.01)


def test_gain_changes_speed_and_load_changes_how_long_it_takes():
    for gain in (0.7, 1.3):
        model = chair_with(gain=gain)
        drive(model, (1.0, 0.0), 6.0)
        assert model.speed_m_s == pytest.approx(gain * QUIET.linear.positive, rel=0.01)
    heavy, light = chair_with(load=2.0), chair_with(load=0.5)
    for model in (heavy, light):
        drive(model, (0.0, 1.0), 0.6)
    assert heavy.yaw_rate_deg_s < light.yaw_rate_deg_s
    for model in (heavy, light):
        drive(model, (0.0, 1.0), 8.0)
        assert model.yaw_rate_deg_s == pytest.approx(QUIET.turn.positive, rel=0.01)


def test_a_sloping_floor_turns_the_moving_chair_downhill_and_leaves_a_standing_one():
    model = chair_with(slope_deg_s=2.0, downhill_deg=90.0)
    drive(model, (0.0, 0.0), 2.0)
    assert model.heading_deg == 0.0
    drive(model, (0.5, 0.0), 4.0)
    assert 4.0 < model.heading_deg < 8.5
    model = chair_with(slope_deg_s=2.0, downhill_deg=-90.0)
    drive(model, (0.5, 0.0), 4.0)
    assert -8.5 < model.heading_deg < -4.0


def straight(model, stick, seconds):
    """Change of the heading meanwhile, deg."""
    before = model.heading_deg
    drive(model, (stick, 0.0), seconds)
    return model.heading_deg - before


@pytest.mark.parametrize("caster_deg", [12.0, -12.0])
def test_casters_turn_the_chair_once_after_each_reversal(caster_deg):
    model = chair_with(caster_deg=caster_deg, caster_s=0.5)
    straight(model, 1.0, 5.0)  # the casters' first position is arbitrary
    assert straight(model, 1.0, 3.0) == pytest.approx(0.0, abs=0.01)
    assert straight(model, -1.0, 5.0) == pytest.approx(-caster_deg, abs=0.1)
    assert straight(model, -1.0, 2.0) == pytest.approx(0.0, abs=0.01)
    assert straight(model, 1.0, 5.0) == pytest.approx(caster_deg, abs=0.1)


def test_casters_take_their_time_at_full_speed():
    model = chair_with(caster_deg=10.0, caster_s=0.4)
    drive(model, (-0.2, 0.0), 6.0)
    drive(model, (1.0, 0.0), 0.4)
    turning_s = 0.0
    for _ in range(4000):
        model.step(STEP_S, (1.0, 0.0))
        turning_s += STEP_S if model.yaw_rate_deg_s else 0.0
    assert 0.3 < turning_s < 1.5


def test_equal_seeds_draw_equal_disturbances_and_chairs_within_their_ranges():
    assert Disturbances.drawn(random.Random(3)) == Disturbances.drawn(random.Random(3))
    assert random_chair("2.1", 5) == random_chair("2.1", 5) != random_chair("2.1", 6)
    chairs = [random_chair("2.1", seed) for seed in range(300)]
    for values, low, high in (
        ([c.turn.dead_time_s for c in chairs], 0.08, 0.25),
        ([c.turn.lag_s for c in chairs], 0.15, 0.45),
        ([c.turn.deadband for c in chairs], 0.05, 0.15),
        ([c.disturbances.gain for c in chairs], 0.7, 1.3),
        ([abs(c.disturbances.caster_deg) for c in chairs], 5.0, 15.0),
        ([c.disturbances.caster_s for c in chairs], 0.3, 0.8),
    ):
        assert low <= min(values) < low + 0.1 * (high - low)
        assert high - 0.1 * (high - low) < max(values) <= high


def test_a_disturbed_chair_is_the_same_for_the_same_seed():
    ways = []
    for seed in (1, 1, 2):
        model = Chair("3.1", seed, random_chair("3.1", 8))
        model.step(STEP_S, (0.0, 0.0))
        drive(model, (0.4, 0.5), 2.0)
        drive(model, (-0.4, -0.5), 2.0)
        ways.append((model.x_m, model.y_m, model.heading_deg))
    assert ways[0] == ways[1] != ways[2]


@pytest.mark.parametrize(
    "numbers", [undisturbed("4.1"), undisturbed("1.2"), random_chair("4.1", 3)]
)
def test_steps_of_1_to_5_ms_go_the_same_way(numbers):
    ends = []
    for step_s in (0.001, 0.002, 0.005):
        model = Chair("4.1", 1, numbers)
        model.step(step_s, (0.0, 0.0))
        for stick in ((0.3, 0.6), (0.0, -0.5), (0.5, 0.0), (0.0, 0.0)):
            drive(model, stick, 1.5, step_s)
        ends.append((model.heading_deg, model.x_m, model.y_m))
    for heading, x, y in ends[1:]:
        assert heading == pytest.approx(ends[0][0], abs=0.5)
        assert (x, y) == pytest.approx(ends[0][1:], abs=0.01)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"deadband": 1.0}, "deadband 1.0 must be a share"),
        ({"lag_s": 0.0}, "must be above 0"),
        ({"friction": -1.0}, "0 or more"),
        ({"dead_time_s": -0.1}, "the dead time 0 or more"),
        ({"stiction": 80.0}, "below the full speed"),
    ],
)
def test_numbers_no_chair_has_are_refused(change, reason):
    with pytest.raises(ValueError, match=reason):
        replace(QUIET.turn, **change)
    with pytest.raises(ValueError, match="above 0"):
        Disturbances(gain=0.0)


def test_numbers_can_be_changed_while_it_moves_and_a_side_may_be_stuck():
    model = chair_with()
    drive(model, (0.0, 1.0), 2.0)
    model.parameters = replace(QUIET, turn=replace(QUIET.turn, positive=0.0))
    drive(model, (0.0, 1.0), 3.0)
    assert model.yaw_rate_deg_s == 0.0
    drive(model, (0.0, -1.0), 3.0)
    assert model.yaw_rate_deg_s < -30.0


def test_a_chair_that_rolls_does_not_stick_in_its_turning():
    model = chair_with({"deadband": 0.0, "friction": 2.0, "stiction": 0.2 * QUIET.turn.positive})
    drive(model, (0.5, 0.0), 2.0)
    drive(model, (0.5, 0.05), 2.0)
    assert model.yaw_rate_deg_s == pytest.approx(0.05 * QUIET.turn.positive, rel=0.02)
