# The turn controller's decisions, its parts scripted: moves, their ends, rest; holding a heading.

from gazeboard.turning.casters import Casters
from gazeboard.turning.stop_plan import StopPlan
from gazeboard.turning.turn import turn_controller
from turnbench import settings_of
from turnrig import COAST, COUNTER, CUTOFF_Q8, DEADBAND, GO, LIMIT, Rig


def test_a_move_is_full_deflection_to_its_side():
    rig = Rig()
    turn = rig.turn
    for left_q8, side in ((1, 1), (0, 1), (-1, -1), (900, 1)):
        turn._moves = 0
        turn._returns = 0
        turn._faster_q8 = 5
        turn._rest_ms = 300
        turn._begin(left_q8)
        assert (turn._sign, turn._out, turn._phase) == (side, side * LIMIT, GO)
        assert turn._plan is (rig.left if side > 0 else rig.right)
        assert (turn._faster_q8, turn._rest_ms, turn._moves) == (0, 0, 1)
        assert (turn._pushed, turn._returns) == (-side, 0), "the counter-deflection comes"
        assert rig.small.calls[-1] == ("begin", left_q8, side, False)


def test_pushes_that_change_sides_are_counted():
    turn = Rig().turn
    turn._begin(5000)  # and pushes back at its end
    for left_q8, returns in ((-1, 0), (-1, 0), (1, 1), (0, 1), (-1, 2), (1, 3)):
        turn._begin(left_q8)
        assert turn._returns == returns
        assert turn._pushed == (1 if left_q8 >= 0 else -1)
    assert turn._moves == 7


def test_a_correction_by_less_than_three_degrees_is_gentle():
    for left_q8, gentle in ((799, True), (800, False), (-799, True), (-800, False)):
        for moves in (0, 1, 2):
            for rest_ms, from_rest in ((90, False), (100, True), (200, True)):
                rig = Rig()
                turn = rig.turn
                turn._moves = moves
                turn._rest_ms = rest_ms
                turn._begin(left_q8)
                assert turn._gentle == (gentle and moves > 0)
                bounded = gentle and moves > 0 and from_rest
                side = 1 if left_q8 > 0 else -1
                assert rig.small.calls[-1] == ("begin", left_q8, side, bounded)


def test_what_it_still_turns_is_the_models_way_by_the_gain_and_the_slope():
    for side in (1, -1):
        for counters, way_q8, slides_q8 in ((False, 1000, 30), (True, 400, 7), (False, -600, 30)):
            for fitted, adds_q8 in ((False, 0), (True, 24), (True, -50)):
                rig = Rig(fitted)
                turn = rig.within(GO, side)
                plan = rig.left if side > 0 else rig.right
                plan.free_q8 = way_q8
                plan.countered_q8 = way_q8
                turn._gain_q8 = 384
                turn._seen_q16 = 4567
                rig.slope.slides_q8 = 30
                rig.slope.slides_braked_q8 = 7
                rig.casters.adds_q8 = {side * way_q8: side * adds_q8}
                turns_q8 = turn._turns_q8(counters)
                assert turns_q8 == ((way_q8 + adds_q8) * 384 >> 8) + side * slides_q8
                assert turn._way_q8 == way_q8
                assert plan.asked == (rig.model.state, 4567, side)


def test_a_large_move_ends_by_counter_deflection():
    for side in (1, -1):
        for left_q8, faster_q8, ends in ((501, 0, False), (500, 0, True), (501, 1, True)):
            rig = Rig()
            turn = rig.within(GO, side, side * left_q8)
            turn._faster_q8 = faster_q8
            for plan in (rig.left, rig.right):
                plan.countered_q8 = 500
                plan.free_q8 = 900
            assert rig.tick() == (-side * LIMIT if ends else side * LIMIT)
            assert turn._phase == (COUNTER if ends else GO)


def test_a_gentle_one_runs_out():
    for side in (1, -1):
        for left_q8, as_planned in ((601, False), (600, True), (599, True)):
            for ends in (False, True):
                rig = Rig()
                turn = rig.within(GO, side, side * left_q8, 2)
                turn._gentle = True
                rig.small.ends_it = ends
                for plan in (rig.left, rig.right):
                    plan.countered_q8 = 9000
                    plan.free_q8 = 500
                # 100 of what is left are not aimed at here.
                assert rig.tick() == (0 if ends else side * LIMIT)
                assert rig.small.calls == [("ends", as_planned)]
                assert turn._phase == (COAST if ends else GO)


def test_counter_deflection_ends_at_rest_or_a_quarter_degree_short():
    for side in (1, -1):
        for more, left_q8, ends in (
            (2, 900, False),
            (1, 563, False),
            (1, 564, True),
            (1, 565, True),
            (0, -900, True),
        ):
            rig = Rig()
            turn = rig.within(COUNTER, side, side * left_q8)
            for plan in (rig.left, rig.right):
                plan.more = more
                plan.countered_q8 = 9000
                plan.free_q8 = 500
            assert rig.tick() == (0 if ends else -side * LIMIT)
            assert turn._phase == (COAST if ends else COUNTER)
            if not ends and more == 2:
                assert (rig.left if side > 0 else rig.right).asked == (rig.model.state, side)


def test_coasting_it_decides_once_a_sample():
    rig = Rig()
    turn = rig.within(COAST, 1, 5000)
    turn._out = 5
    turn._looked = False
    assert rig.tick() == 0
    turn._looked = True
    turn._out = 0
    turn._moves = 9
    assert rig.tick() == 0
    assert not turn._looked
    turn._looked = True
    turn._moves = 1
    assert rig.tick() == LIMIT
    assert not turn._looked


def test_it_may_go_on_always_and_back_a_few_times():
    for tuned, returns, side, as_pushed in [
        (tuned, returns, side, as_pushed)
        for tuned in (0, 1)
        for returns in range(4)
        for side in (1, -1)
        for as_pushed in (False, True)
    ]:
        turn = Rig(tuned=tuned).turn
        turn._sign = side
        turn._pushed = -side if as_pushed else side  # back already, by the counter-deflection
        turn._returns = returns
        for left_q8 in (-513, -512, -1, 0, 1):  # to that side
            turn._time_is_up = False
            back = tuned and (returns < 2 or left_q8 < -512)
            may_go = bool(left_q8 > 0 or as_pushed or back)
            assert turn._may_go(left_q8) is may_go, (tuned, returns, side, as_pushed, left_q8)
            turn.settle()
            assert turn._may_go(left_q8) is False


# A neutral output, `left_q8` from there, the model still turning by way_q8, at this rate: the
# correction that begins, or else for how long it has been at rest, then whether it has arrived.
def coasts(side, left_q8, way_q8=0, rate_q4=0, rest_ms=50, moves=1, there_q8=128, time_is_up=False):
    rig = Rig()
    turn = rig.within(COAST, side, side * left_q8, moves)
    for plan in (rig.left, rig.right):
        plan.free_q8 = way_q8
    turn._rest_ms = rest_ms
    turn._there_q8 = there_q8
    turn._time_is_up = time_is_up
    turn._coast(rate_q4)
    begins_q8 = [side * call[1] for call in rig.small.calls]
    if begins_q8:
        assert turn._rest_ms == 0 and not turn.arrived and not turn.missed
        return begins_q8[0]
    assert turn._there_q8 == (CUTOFF_Q8 if moves >= 5 and turn._rest_ms >= 100 else there_q8)
    assert turn.arrived or turn.missed or turn._phase == COAST
    word = "arrived" if turn.arrived else "missed" if turn.missed else ""
    return (turn._rest_ms, word)


def test_a_small_correction_waits_for_the_models_rest():
    for side in (1, -1):
        for rate_q4 in (0, 47, -47):
            for way_q8 in (65, -65):
                for error_q8 in (799, -799):
                    assert coasts(side, error_q8 + way_q8, way_q8, rate_q4) == (0, "")
                for error_q8 in (800, -800):
                    assert coasts(side, error_q8 + way_q8, way_q8, rate_q4) == error_q8
        for rate_q4 in (48, -48):
            assert coasts(side, 799 + 65, 65, rate_q4) == 799, "it still turns fast"
        for way_q8 in (64, -64, 0):
            assert coasts(side, 700 + way_q8, way_q8) == (60, "")
            assert coasts(side, 800 + way_q8, way_q8) == 800


def test_a_correction_is_for_more_than_the_doubt():
    for side in (1, -1):
        for way_q8 in (400, 403, -400, -403):
            for there_q8, doubt_q8 in ((128, 228), (200, 300)):
                for sign in (1, -1):
                    for error_q8, goes in ((doubt_q8, False), (doubt_q8 + 1, True)):
                        left_q8 = way_q8 + sign * error_q8
                        found = coasts(side, left_q8, way_q8, 48, there_q8=there_q8)
                        assert found == (sign * error_q8 if goes else (0, "")), (way_q8, error_q8)
        for moves, goes in ((1, True), (3, True), (4, False), (5, False)):
            assert coasts(side, 1400, 400, 48, moves=moves) == (1000 if goes else (0, ""))
        assert coasts(side, 1400, 400, 48, time_is_up=True) == (0, "")


def test_it_is_at_rest_when_model_and_sensor_say_so():
    for side in (1, -1):
        for rate_q4, rests in ((16, True), (-16, True), (17, False), (-17, False)):
            assert coasts(side, 100, 0, rate_q4) == (60 if rests else 0, "")
        for way_q8, rests in ((64, True), (-64, True), (65, False), (-65, False)):
            found = coasts(side, 1400, way_q8, 0, moves=9)
            assert found == (60 if rests else 0, ""), "too far for a small one, and no move left"


def test_settled_it_has_arrived_or_sets_out_again():
    for side in (1, -1):
        for sign in (1, -1):
            assert coasts(side, sign * 129, rest_ms=80) == (90, "")
            assert coasts(side, sign * 129, rest_ms=90) == sign * 129
            assert coasts(side, sign * 128, rest_ms=90) == (100, "")
            assert coasts(side, sign * 65, rest_ms=90) == (100, "")
            assert coasts(side, sign * 64, rest_ms=90) == (100, "arrived")
            assert coasts(side, sign * 64, rest_ms=80) == (90, "")
            assert coasts(side, sign * 128, rest_ms=380) == (390, "")
            assert coasts(side, sign * 128, rest_ms=390) == (400, "arrived")
            assert coasts(side, sign * 128, rest_ms=500) == (510, "arrived")


def test_after_enough_moves_it_bears_the_cutoff_and_then_all():
    for side in (1, -1):
        for sign in (1, -1):
            assert coasts(side, sign * 129, rest_ms=90, moves=4) == sign * 129
            for moves in (5, 8):
                assert coasts(side, sign * 129, rest_ms=90, moves=moves) == (100, "")
                assert coasts(side, sign * 128, rest_ms=90, moves=moves) == (100, "arrived")
                assert coasts(side, sign * 256, rest_ms=90, moves=moves) == (100, "")
                assert coasts(side, sign * 257, rest_ms=90, moves=moves) == sign * 257
            for rest_ms, word in ((90, ""), (390, "arrived")):
                assert coasts(side, sign * 512, rest_ms=rest_ms, moves=9) == (rest_ms + 10, word)
            for values in ({"moves": 9}, {"moves": 10}, {"moves": 6, "time_is_up": True}):
                assert coasts(side, sign * 512, rest_ms=390, **values) == (400, "arrived")
                assert coasts(side, sign * 513, rest_ms=390, **values) == (400, "missed")


def test_a_heading_is_held_from_16_permille_on_until_below_6():
    for sign in (1, -1):
        rig = Rig()
        turn = rig.turn
        turn.keep(100)
        rate_q4 = 0
        for size, holds in ((15, 0), (16, 1), (6, 1), (5, 0), (6, 0), (15, 0), (200, 1), (0, 0)):
            rig.hold.out = sign * size
            rate_q4 += 1
            expected = sign * (size + DEADBAND) if holds else 0
            assert turn.hold(90, rate_q4) == expected, size
            assert turn.hold(90, rate_q4) == expected


def test_holding_is_worked_out_once_a_sample():
    rig = Rig()
    turn = rig.turn
    turn.keep(100)
    rig.hold.out = 50
    for heading_q4, rate_q4, asked in (
        (90, 0, (10, 0, 1)),
        (90, 0, None),
        (91, 0, (9, 0, 1)),
        (91, 1, (9, 1, 1)),
        (91, 1, None),
        (5759, 1, (101, 1, 1)),
        (5759, -1, (101, -1, 1)),
        (3000, -1, (2860, -1, 1)),
        (2900, -1, (-2800, -1, 1)),
    ):
        rig.hold.asked = []
        assert turn.hold(heading_q4, rate_q4) == 50 + DEADBAND
        assert rig.hold.asked == ([asked] if asked else [])
    turn.hold(1, -1)
    turn.keep(1)
    rig.hold.out = 15
    assert turn.hold(1, -1) == 0, "another heading to keep is another hold"


def test_even_the_first_heading_of_all_is_worked_out():
    for heading_q4 in (0, 1, 5759):
        for out, held in ((50, 50 + DEADBAND), (15, 0)):
            rig = Rig()
            rig.hold.out = out
            assert rig.turn.hold(heading_q4, 0) == held


def test_the_selected_profile_makes_the_parts():
    values = {
        "left_q4_dps": 600,
        "right_q4_dps": 500,
        "accelerate_dps2": 40,
        "brake_dps2": 120,
        "lag_ms": 300,
        "deadband_permille": 70,
        "dead_time_ms": 150,
        "caster_way_q4_deg": 400,
    }
    for tuned in (0, 1):
        for size_q4 in (-5, 0, 5):
            settings = settings_of(1, dict(values, tuned=tuned, caster_q4_deg=320 + size_q4))
            settings.turn_cutoff_q4_deg = 20
            settings.step_turn_permille = 800
            settings.hold_kp_q4 = 640
            settings.hold_kd_q4 = 160
            turn = turn_controller(settings)
            for plan, ahead, against in ((turn._left, 600, 500), (turn._right, 500, 600)):
                same = StopPlan(ahead, against, 40, 120, 300)
                assert list(plan._words) == list(same._words)
                assert plan.brakes_q8 == same.brakes_q8
            assert list(turn._casters._words) == list(Casters(size_q4, 400)._words)
            assert (turn.model.dead_ms, turn.model.lag_ms) == (150, 300)
            turn.keep(160)
            assert turn.hold(0, 0) == 400 + 70, "10 degrees, 40 permille each"
            assert turn.hold(0, 160) == 300 + 70, "10 degrees/s, 10 permille each"
            assert (turn._cutoff_q8, turn._limit, turn._tuned) == (320, 800, tuned)
