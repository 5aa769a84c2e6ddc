# The turn controller on a chair that turns as its model says, and on one that does not.

from gazeboard.core.angle import wrapped
from gazeboard.turning.turn import turn_controller
from gazelink.settings_table import NO_CASTERS_Q4_DEG, PROFILES, profile_row
from turnbench import Bench, pulses, settings_of


def test_turns_land_both_ways_on_every_profile_and_across_north():
    for profile in range(len(PROFILES)):
        for degrees in (5, -10, 45):
            bench = Bench(profile, heading_q4=5700 if degrees > 0 else 50)
            error_deg, ms = bench.by(degrees)
            assert -0.5 <= error_deg <= 0.5, (profile, degrees, error_deg)
            assert bench.flips() == 1, "one counter-deflection, no correction"
            assert ms < 2200 or abs(degrees) > 10, ms


def test_it_ends_at_rest_and_stays_there():
    bench = Bench()
    bench.by(10)
    for _ in range(500):
        bench.one_ms(0)
        assert abs(wrapped(bench.heading_q4 - 160)) <= 12
        assert abs(bench.rate_q4) <= 16


def test_a_chair_that_is_not_as_believed_is_corrected_a_few_times_at_most():
    for values in (
        {"left_q4_dps": 510},
        {"left_q4_dps": 940},
        {"dead_time_ms": 90},
        {"dead_time_ms": 250},
        {"lag_ms": 150},
        {"lag_ms": 450},
        {"deadband_permille": 150},
    ):
        for degrees in (10, 45):
            bench = Bench(2, values)
            error_deg, _ = bench.by(degrees)
            assert -1.0 <= error_deg <= 1.0, (values, degrees, error_deg)
            assert bench.pushes() <= 7, values


def test_a_turn_may_begin_while_the_chair_still_turns():
    for out in (500, -500):
        bench = Bench()
        for _ in range(1000):
            bench.one_ms(out)
        error_deg, _ = bench.by(20)
        assert -1.0 <= error_deg <= 1.0


def test_a_chair_that_does_not_move_is_given_up():
    bench = Bench()
    bench.stuck = True
    _, ms = bench.by(10)
    assert ms < 6000
    assert bench.turn.missed
    assert not bench.turn.arrived


def test_a_sloping_floor_is_learned_within_the_turn():
    for slope_dps in (-1.4, 1.4):
        for degrees in (5, 10, 20, -20):
            bench = Bench()
            bench.slope_dps = slope_dps
            error_deg, ms = bench.by(degrees)
            assert -0.9 <= error_deg <= 0.9, (slope_dps, degrees, error_deg)
            assert ms < 5000, (slope_dps, degrees, ms)
            assert bench.pushes() <= 4, (slope_dps, degrees)


def test_a_pulse_that_did_nothing_is_followed_by_a_longer_one():
    # Breaks loose at 17.5 degrees/s where 9.7 are believed: the first small corrections do nothing.
    bench = Bench(2, {"breakaway_q4_dps": 280, "lag_ms": 430})
    error_deg, _ = bench.by(20)
    assert -1.0 <= error_deg <= 1.0
    last = pulses(bench.outs)[2:]
    assert len(last) >= 2, last
    for k in range(1, len(last)):
        assert last[k] * last[k - 1] < 0 or abs(last[k]) >= abs(last[k - 1]) + 30, last


def test_a_chair_that_nobody_has_tuned_sets_out_back_once_at_most():
    for values in (
        {"left_q4_dps": 1000, "right_q4_dps": 1000, "brake_dps2": 50},
        {"lag_ms": 700, "dead_time_ms": 300},
        {"breakaway_q4_dps": 300, "lag_ms": 600},
    ):
        for degrees in (10, 45):
            bench = Bench(2, values, tuned=0)
            bench.by(degrees)
            # A counter-deflection follows its own move at once; what sets out comes after a rest.
            back = 0
            towards = True
            for k in range(len(bench.outs)):
                begins = bench.outs[k] != 0 and (k == 0 or bench.outs[k - 1] == 0)
                if begins and (bench.outs[k] > 0) != towards:
                    towards = not towards
                    back += 1
            assert back <= 1, (values, degrees, pulses(bench.outs))
            assert bench.turn.arrived or bench.turn.missed


def test_asked_to_settle_it_begins_no_more_corrections_and_reports_its_result():
    for left_q4_dps, at_ms in ((510, 0), (510, 2500), (350, 0)):
        bench = Bench(2, {"left_q4_dps": left_q4_dps, "right_q4_dps": left_q4_dps, "lag_ms": 600})
        bench.turn.start(20 * 16, 0)
        while not bench.turn.arrived and not bench.turn.missed:
            if bench.ms == max(at_ms, 1):
                bench.turn.settle()
                pushes = max(1, bench.pushes())
            bench.one_ms(bench.turn.update(bench.heading_q4, bench.rate_q4, bench.count))
        assert bench.pushes() == pushes
        off_q4 = abs(wrapped(20 * 16 - bench.heading_q4))
        assert bench.turn.arrived == (off_q4 <= 32), off_q4
    again = Bench(2, {"left_q4_dps": 510})
    again.turn.settle()
    error_deg, _ = again.by(20)
    assert -1.0 <= error_deg <= 1.0, "the next turn corrects again"


def test_near_the_edge_of_the_cutoff_it_waits_for_what_the_floor_does():
    waited = []
    for lag_ms in range(300, 440, 10):
        bench = Bench(2, {"lag_ms": lag_ms})
        bench.turn.start(10 * 16, 0)
        rested_ms = 0
        while not bench.turn.arrived:
            rested_ms = rested_ms + 1 if abs(bench.rate_q4) <= 16 else 0
            bench.one_ms(bench.turn.update(bench.heading_q4, bench.rate_q4, bench.count))
        waited.append((abs(10 * 16 - bench.heading_q4), rested_ms))
    edge = [rested_ms for off_q4, rested_ms in waited if off_q4 > 8]
    within = [rested_ms for off_q4, rested_ms in waited if off_q4 < 7]
    assert len(edge) >= 2 and min(edge) >= 390, waited
    assert max(within) < 300, waited


def test_a_small_correction_waits_for_rest_or_catches_a_chair_that_turns_fast():
    quick = {"breakaway_q4_dps": 40, "lag_ms": 200, "dead_time_ms": 90}
    rested = 0
    for brake_dps2, slope_dps in ((90, 1.0), (150, 0.0), (150, 1.0), (300, 1.0)):
        for degrees in (5, 10, 20):
            bench = Bench(2, dict(quick, brake_dps2=brake_dps2))
            bench.slope_dps = slope_dps
            bench.turn.start(degrees * 16, 0)
            out = rest_ms = changes = 0
            pushed_left = degrees < 0  # by the first counter-deflection
            while not bench.turn.arrived and not bench.turn.missed:
                before = out
                rate_q4 = abs(bench.rate_q4)
                rest_ms = rest_ms + 1 if rate_q4 <= 16 else 0
                out = bench.turn.update(bench.heading_q4, bench.rate_q4, bench.count)
                if out and not before and bench.turn._gentle:
                    assert rate_q4 >= 48 or rest_ms >= 90, (brake_dps2, slope_dps, degrees)
                    rested += rate_q4 < 48
                if out and not before and bench.ms > 20 and (out > 0) != pushed_left:
                    pushed_left = not pushed_left
                    changes += 1
                bench.one_ms(out)
            assert changes == bench.turn._returns
    assert rested >= 5


def test_wide_turns_land_nearer_by_what_the_sensor_may_be_off():
    for values in ({"lag_ms": 450}, {"dead_time_ms": 250}, {"left_q4_dps": 600}):
        error_deg, _ = Bench(2, values).by(90)
        assert -0.63 <= error_deg <= 0.63, (values, error_deg)


def test_a_chair_of_another_full_speed_turns_wide_in_one_move():
    # Its ramp back from there goes by the square of the speed: the rate alone told half of it.
    for values in (
        {"left_q4_dps": 699, "right_q4_dps": 699},
        {"left_q4_dps": 757, "right_q4_dps": 757},
    ):
        for degrees in (90, -90):
            bench = Bench(2, values)
            error_deg, _ = bench.by(degrees)
            assert bench.pushes() == 1, (values, degrees, pulses(bench.outs))
            assert -0.6 <= error_deg <= 0.6, (values, degrees, error_deg)


def test_before_full_speed_another_rate_is_no_other_full_speed():
    bench = Bench(2, {"accelerate_dps2": 45})
    bench.turn.start(10 * 16, 0)
    while not bench.turn.arrived and not bench.turn.missed:
        bench.one_ms(bench.turn.update(bench.heading_q4, bench.rate_q4, bench.count))
        assert bench.turn._faster_q8 == 0


def test_it_is_at_rest_at_once_when_it_is_there_already():
    bench = Bench()
    error_deg, _ = bench.by(0)
    assert error_deg == 0


def test_known_casters_are_counted_in():
    for size in (-128, 128):
        bench = Bench()
        row = profile_row(2, "caster_q4_deg")
        settings = settings_of(2, {})
        setattr(settings, row, NO_CASTERS_Q4_DEG + size)
        bench.turn = turn_controller(settings)
        # They have swung round to the left's end long ago: nothing is added to a left turn.
        for _ in range(2000):
            bench.one_ms(500)
        for _ in range(1500):
            bench.one_ms(0)
        bench.outs = []
        error_deg, _ = bench.by(20)
        assert -0.7 <= error_deg <= 0.7
        assert bench.flips() == 1
