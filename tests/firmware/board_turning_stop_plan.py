# The end of a turn, against the motion that it plans: ramp and lag of a chair, in floats.

import math
from array import array

from gazeboard.turning.stop_plan import StopPlan, counter_areas

# Speeds ahead and against in 1/16 degree/s, ramps in degrees/s^2, lag in ms.
_PLANS = (
    (728, 728, 36, 150, 350),
    (400, 900, 60, 90, 250),
    (1000, 272, 20, 300, 700),
    (850, 850, 36, 150, 350),
)
_EXACT = (512, 512, 64, 128, 1000)  # of which all numbers are powers of two
_HALF_TURN = 180 << 16


# A ChairModel's state: ramp and rate in 1/64 degree/s, all else of no meaning here.
def state_of(ramp, rate, angle_q16=0):
    return array("i", [-77777, ramp << 10, rate << 4, 55555, angle_q16, 33333, 22222, 1111])


# Value of a table at `at` cells, between them by a straight line.
def between(table, at):
    k = int(at)
    return table[k] + (table[k + 1] - table[k]) * (at - k)


# Rate before the counter-lobe of so many degrees that ends at rest.
def rate_of_lobe(area, full, accelerate, brake, lag_s):
    peak = math.sqrt(2 * area / (1 / accelerate + 1 / brake))
    hold_s = 0.0
    if peak > full:
        peak = full
        hold_s = (area - peak * peak * 0.5 * (1 / accelerate + 1 / brake)) / peak
    up_s = peak / accelerate
    all_s = up_s + hold_s + peak / brake
    # The rate at its end is z e^(-all / T) - (integral of ramp e^((t - all) / T) dt / T).
    steps = 400
    z = 0.0
    for k in range(steps):
        t = (k + 0.5) * all_s / steps
        ramp = min(peak, accelerate * t, (all_s - t) * brake)
        z += ramp * math.exp(t / lag_s) * all_s / steps / lag_s
    return z


def test_each_counter_lobe_ends_at_rest():
    for _, against_q4, accelerate, brake, lag_ms in _PLANS:
        full = against_q4 / 16
        for cell in (0.5, 2.0, 4.0):
            areas = counter_areas(cell, 34, full, accelerate, brake, lag_ms / 1000)
            assert len(areas) == 34
            assert areas[0] == 0
            for k in (1, 2, 5, 12, 20, 33):
                # Down to 1/256 degree.
                low = rate_of_lobe((areas[k] - 2) / 256, full, accelerate, brake, lag_ms / 1000)
                high = rate_of_lobe((areas[k] + 3) / 256, full, accelerate, brake, lag_ms / 1000)
                assert low <= k * cell <= high, (full, cell, k, low, high)


def test_lobes_between_two_steps_of_the_peak_divide_it_evenly():
    # At 20 ms of lag the first step of the peak is past all cells already.
    step = 150.0 / 64
    area = step * step * 0.5 * (1 / 20 + 1 / 600)
    z = rate_of_lobe(area, 150.0, 20, 600, 0.02)
    areas = counter_areas(z / 34, 34, 150.0, 20, 600, 0.02)
    for k in range(34):
        assert abs(areas[k] - 256 * area * k / 34) <= 1


def test_its_tables_hold_a_quarter_more_than_full_speed():
    speeds_q4 = [80, 2400]
    for cell in (16, 32, 64, 128, 256):
        for cells in (31, 32, 33, 34):
            speeds_q4 += [cells * cell // 5, cells * cell // 5 + 1]
    for q4_dps in speeds_q4:
        for values in ((q4_dps, 80), (80, q4_dps)):
            shift = StopPlan(values[0], values[1], 36, 150, 350)._words[3]
            # Of the 34 cells the one after is needed, too; as fine as that allows.
            assert q4_dps * 5 >> shift < 32 <= q4_dps * 5 >> shift - 1


def test_what_is_left_of_a_rate_is_rounded():
    for values in _PLANS:
        words = StopPlan(*values)._words
        for k in range(34):
            left = 16384 * math.exp(-k * cell_of(values) / (values[3] * values[4] * 0.064))
            assert abs(words[4 + k] - left) <= 0.50001, (values, k)


def test_from_full_speed_the_ramp_turns_it_by_so_much():
    # 60 degrees/s at 90 degrees/s^2 are 20 degrees.
    assert StopPlan(960, 80, 36, 90, 350).brakes_q8 == 20 * 256
    assert StopPlan(80, 960, 36, 90, 350).brakes_q8 == 80 * 80 // 180


def test_released_it_turns_on_by_its_ramp_and_its_lag():
    plan = StopPlan(*_EXACT)
    for counters in (0, 1):
        for side in (1, -1):
            for ramp in (0, 1, 63, 64, 65, 127, 640, 2047, 2048):
                for rate in (-2000, -1, 0, 1, 777, 2048):
                    if counters == 0:
                        # r^2 / (2 b) and a second: 1/64 degree/s to 1/256 degree.
                        on_q8 = plan.ahead_q8(state_of(side * ramp, side * rate), 0, side, 0)
                        assert on_q8 == ((ramp * ramp) >> 12) + 4 * rate, (ramp, rate)
                    # A ramp to the other side takes back, and is countered by nothing.
                    on_q8 = plan.ahead_q8(state_of(-side * ramp, side * rate), 0, side, counters)
                    assert on_q8 == 4 * rate - ((ramp * ramp) >> 12), (ramp, rate)


def test_what_is_within_the_dead_time_counts_across_half_a_turn():
    plan = StopPlan(*_EXACT)
    for angle_q16, seen_q16, way_q16 in (
        (0, 0, 0),
        (256, 0, 256),
        (0, 256, -256),
        (_HALF_TURN - 1, 0, _HALF_TURN - 1),
        (_HALF_TURN - 1, -1, -_HALF_TURN),
        (-_HALF_TURN, 0, -_HALF_TURN),
        (-_HALF_TURN, 1, _HALF_TURN - 1),
        (-_HALF_TURN, _HALF_TURN - 512, 512),
        (_HALF_TURN - 512, -_HALF_TURN, -512),
    ):
        for side in (1, -1):
            on_q8 = plan.ahead_q8(state_of(0, 0, angle_q16), seen_q16, side, 0)
            assert on_q8 == side * (way_q16 >> 8)


# What the lag leaves of a rate while the ramp goes back to zero, from a table.
def decayed(brake_lag, cell, ramp):
    return between([math.exp(-k * cell / brake_lag) for k in range(34)], ramp / cell)


# What counter-deflection saves, 1/256 degree, from ramp and rate in 1/64 degree/s.
def saved_q8(values, areas, cell, ramp, rate):
    brake_lag = values[3] * values[4] * 0.064
    z = (rate - ramp - brake_lag) * decayed(brake_lag, cell, ramp) + brake_lag
    return between(areas + areas[-1:], min(33, z / cell)) if z > 0 else 0


# The width of a table's cell, 1/64 degree/s: with it a quarter more than full speed has a place.
def cell_of(values):
    cell = 4
    while max(values[:2]) * 5 // cell >= 32:
        cell *= 2
    return cell


def test_countered_it_turns_on_by_so_much_less():
    for values in (_EXACT,) + _PLANS:
        plan = StopPlan(*values)
        cell = cell_of(values)
        most = max(values[:2]) * 5
        areas = counter_areas(cell / 64, 34, values[1] / 16, values[2], values[3], values[4] / 1000)
        for ramp in range(1, most, most // 11):
            for rate in range(-most // 4, cell * 36, most // 9):
                expected_q8 = saved_q8(values, areas, cell, ramp, rate)
                for side in (1, -1):
                    state = state_of(side * ramp, side * rate)
                    free_q8 = plan.ahead_q8(state, 0, side, 0)
                    found_q8 = free_q8 - plan.ahead_q8(state, 0, side, 1)
                    assert abs(found_q8 - expected_q8) <= 2 + values[4] / 250, (
                        values,
                        ramp,
                        rate,
                        side,
                    )


def test_it_counters_from_the_first_bit_on():
    # A second of lag: 1/64 degree/s of rate is 4/256 degree of a small lobe, within one rounding.
    plan = StopPlan(*_EXACT)
    before_q8 = 0
    for rate in range(64):
        state = state_of(1, rate)
        saved = plan.ahead_q8(state, 0, 1, 0) - plan.ahead_q8(state, 0, 1, 1)
        assert before_q8 <= saved <= before_q8 + 5, rate
        before_q8 = saved
    assert before_q8 > 200


def test_it_counters_until_ramp_and_rate_come_to_rest_together():
    for values in (_EXACT,) + _PLANS:
        plan = StopPlan(*values)
        brake_lag = values[3] * values[4] * 0.064
        most = max(values[:2]) * 5
        for side in (1, -1):
            assert plan.counters(state_of(side, 0), side) == 2
            assert plan.counters(state_of(side * most, -side * most), side) == 2
            assert plan.counters(state_of(0, side), side) == 1
            assert plan.counters(state_of(0, 0), side) == 0
            for ramp in range(0, most, most // 23):
                decay = decayed(brake_lag, cell_of(values), ramp)
                rate = brake_lag / decay - brake_lag - ramp
                if rate < 4 * most:
                    off = 2 / decay + brake_lag / (decay * decay * 16384)
                    above = state_of(-side * ramp, side * int(rate + off + 1))
                    below = state_of(-side * ramp, side * int(rate - off))
                    assert plan.counters(above, side) == 1, (values, ramp, rate)
                    assert plan.counters(below, side) == 0, (values, ramp, rate)


def test_every_bit_of_the_ramp_to_the_other_side_stops_more():
    plan = StopPlan(100, 100, 36, 20, 100)
    stops = 0
    for ramp in range(200, 500):
        assert plan.counters(state_of(-ramp, stops), 1) == 0
        while plan.counters(state_of(-ramp, stops), 1) == 0:
            stops += 1
