# The turn controller's parts: chair model, casters, stop plan, holding a heading.

import math

from boardtest import no_allocation
from gazeboard.io.settings import Settings
from gazeboard.turning.casters import Casters
from gazeboard.turning.chair_model import ChairModel
from gazeboard.turning.stop_plan import StopPlan
from gazeboard.turning.turn import turn_controller
from gazelink.settings_table import TABLE
from turnbench import Bench, settings_of


def test_it_sets_out_backwards_a_few_times_at_most():
    for tuned in (0, 1):
        turn = Bench(2, tuned=tuned).turn
        for returns in range(5):
            for pushed in (-1, 1):  # its last push, towards or back
                for left_q8 in (-520, -500, -10, 10):
                    turn._sign = 1
                    turn._pushed = pushed
                    turn._returns = returns
                    turn._time_is_up = False
                    on = left_q8 > 0
                    as_pushed = pushed < 0  # by the counter-deflection: that is no change of sides
                    few = returns < 2 or left_q8 < -512
                    allowed = on or as_pushed or (tuned and few)
                    assert turn._may_go(left_q8) == bool(allowed), (tuned, returns, pushed, left_q8)
                    turn._time_is_up = True
                    assert not turn._may_go(left_q8)


def test_the_plan_knows_what_the_ramp_turns_back_from_full_speed():
    for speed_dps, brake_dps2 in ((45, 150), (60, 90), (17, 300)):
        plan = StopPlan(speed_dps * 16, 100 * 16, 36, brake_dps2, 350)
        assert abs(plan.brakes_q8 - 256 * speed_dps * speed_dps / (2 * brake_dps2)) < 1


def test_a_model_of_a_chair_that_stands_is_halted():
    model = ChairModel(settings_of(2, {}))
    for _ in range(600):
        model.step(1000)
    assert not model.let_go()
    for _ in range(500):
        model.step(0)
    assert model.let_go()
    assert model.seen_rate() > 0
    model.halt()
    stands_q16 = model.seen_angle()
    for _ in range(600):
        model.step(0)
        assert model.seen_rate() == 0
        assert model.seen_angle() == stands_q16


def test_casters_stay_where_the_wheels_have_not_turned():
    casters = Casters(-160, 376)
    casters.advance(5 << 16)
    casters.mark()
    ahead_q8 = casters.swing_q8(-(8 << 8))
    casters.advance(12 << 16)
    assert casters.swing_q8(-(8 << 8)) != ahead_q8
    casters.skip(12 << 16)
    assert casters.swing_q8(-(8 << 8)) == ahead_q8
    casters.advance(13 << 16)
    casters.advance(12 << 16)
    assert casters.swing_q8(-(8 << 8)) == ahead_q8


def test_model_rotation_during_standstill_counts_alike_in_both_directions():
    for side in (1, -1):
        turn = Bench().turn
        turn.start(160, 0)
        turn._moves = 1
        for _ in range(100):
            turn._before_q16 = turn._seen_q16
            turn._seen_q16 += side * 700  # a degree/s: less than a step of the sensor a sample
            turn._watch_rest(0)
        assert turn._idle_q16 == side * 70000


def test_the_casters_position_is_learned_in_spite_of_a_slope():
    # Turning right at 20 degrees/s; they lie as after a left turn, and the floor turns it left.
    for lay_left in (True, False):
        casters = Casters(-160, 376)  # 10 degrees against the turn over 23.5
        casters.watch(0)
        for cs in range(1, 80):
            way_deg = 0.2 * cs
            casters.advance(-int(way_deg * 65536))
            swung_deg = 5.0 * (1.0 - math.cos(math.pi * way_deg / 23.5)) if lay_left else 0.0
            casters.learn(int(256 * (swung_deg - 0.014 * cs)))
        ahead_q8 = casters.swing_q8(-(8 << 8))
        assert ahead_q8 > 512 if lay_left else ahead_q8 == 0


def test_the_plan_predicts_where_a_stop_ends():
    # Full deflection for a while, then counter-deflection for as long as the plan says.
    settings = settings_of(2, {})
    for go_ms in (100, 300, 900):
        model = ChairModel(settings)
        plan = StopPlan(728, 728, 36, 150, 350)
        for _ in range(go_ms):
            model.step(1000)
        planned_q8 = plan.ahead_q8(model.state, 0, 1, 1)
        while plan.counters(model.state, 1):
            model.step(-1000)
        for _ in range(3000):
            model.step(0)
        assert abs(planned_q8 - (model.seen_angle() >> 8)) <= 64, go_ms


def test_holding_a_heading_is_bounded_and_does_not_chatter():
    turn = turn_controller(Settings())
    turn.keep(5759)
    assert turn.hold(3, 0) == 0  # a quarter degree beside: nothing
    assert turn.hold(5759 - 16, 0) > 0
    assert turn.hold(16, 0) < 0
    assert turn.hold(5759 - 5, 0) > 0  # on until nearly there
    assert turn.hold(5759, 0) == 0


def test_extreme_settings_stay_within_31_bits():
    for pick in (2, 3):
        values = {row[0][5:]: row[pick] for row in TABLE if row[0].startswith("p3_1_")}
        values = {name: value for name, value in values.items() if name != "tuned"}
        turn = turn_controller(settings_of(2, values))
        turn.start(2879, 0)
        state = [0]

        def tick():
            state[0] = (state[0] + 1) & 1023
            out = turn.update(state[0] * 5, 30000 if state[0] & 1 else -30000, state[0] >> 3)
            turn.follow(out)
            turn.hold(state[0] * 5, 30000)

        for _ in range(1500):
            tick()
        no_allocation(tick, 20)
