# The turn controller's looks at a sample, its parts scripted: what it tells and asks them.

from turnrig import COAST, COUNTER, GO, HALF_TURN, LIMIT, START, Rig


def test_before_its_first_turn_nothing_moves():
    rig = Rig()
    assert not rig.turn.arrived and not rig.turn.missed
    assert [rig.turn.update(0, 0, count) for count in (-1, -1, 0, 0, 0, 0, 0, 0)] == [0] * 8
    assert rig.turn._phase == COAST


def test_what_it_is_made_of_holds_before_the_first_sample():
    rig = Rig()
    assert rig.turn.model is rig.model
    assert rig.turn._limit == LIMIT
    assert rig.turn._looked_at[0] is rig.model.state


def test_it_follows_the_output_with_model_and_casters():
    for fitted in (False, True):
        rig = Rig(fitted)
        for permille in (0, 500, -1000):
            rig.casters.calls = []
            rig.turn.follow(permille)
            assert rig.model.stepped == permille
            assert rig.casters.calls == ([("advance", 4321)] if fitted else [])


def test_a_turn_begins_in_the_fourth_tick():
    for begins_at in (0, 1, 7):
        for side in (1, -1):
            for sample in (begins_at, begins_at + 1):
                rig = Rig(True)
                rig.casters.adds_q8 = {256: 0, -256: 0}
                turn = rig.turn
                rig.model.angle_q16 = side * 5 << 16
                turn._moves = 9
                turn._returns = 3
                turn._stands = 4
                turn._idle_q16 = 5
                turn._plan = rig.left
                rig.left.free_q8 = 345
                turn.start(side * 160 - 5760, begins_at)
                assert rig.slope.calls == [("start",)]
                rig.casters.calls = []
                assert turn._setpoint_q4 == (160 if side > 0 else 5600)
                outs = [turn.update(0, 0, sample)]
                if sample == begins_at:
                    assert not rig.casters.calls, "the first tick has enough to do"
                    outs.append(turn.update(0, 0, sample))
                assert rig.casters.calls == [("advance", side * 5 << 16)]
                assert turn._moves == 9
                outs.append(turn.update(0, 0, sample))
                assert (turn._moves, turn._returns, turn._stands, turn._idle_q16) == (0, 0, 0, 0)
                assert rig.small.calls == [("start",)]
                assert rig.slope.calls == [("start",), ("look_ahead", 345)]
                outs.append(turn.update(0, 0, sample))
                assert outs[-1] == side * LIMIT
                assert not any(outs[:-1])
                assert rig.casters.calls[1:] == [("watch", -side * 5 << 8)]
                assert turn._phase == GO
                assert turn._from_q16 == side * 5 << 16
                assert rig.small.calls[1:] == [("begin", side * 160 << 4, side, False)]
                for _ in range(4):
                    turn.update(0, 0, sample + 1)
                assert turn._moves == 1 and len(rig.small.calls) == 2, "that was the beginning"


def test_a_sample_before_the_begin_is_looked_at_anew():
    rig = Rig()
    rig.turn.start(160, 7)
    for heading_q4 in (10, 20):
        for _ in range(2 if heading_q4 == 10 else 3):
            out = rig.turn.update(heading_q4, 0, heading_q4)
    assert out == LIMIT
    assert rig.turn._left_q8 == 140 << 4


def test_the_next_turn_knows_nothing_of_what_became_of_the_last():
    rig = Rig()
    turn = rig.turn
    turn.settle()
    turn.arrived = turn.missed = True
    turn._out = 700
    turn._to_do = 2
    turn._looked = True
    turn._stalled_ms = 790
    turn.start(0, 3)
    assert not turn.arrived and not turn.missed
    assert turn._may_go(1)
    assert [turn.update(0, 0, 3) for _ in range(3)] == [0, 0, 0]
    assert turn._phase == START
    rig.model.rate_q10 = 9000
    turn.update(0, 0, 4)
    assert not turn.missed


def test_nearer_than_this_has_arrived():
    # The cutoff less half a step of the sensor and 0.4 % of the turn; half a degree at the least.
    for degrees, there_q8 in ((1, 247), (16, 232), (90, 158), (119, 129), (120, 128), (180, 128)):
        for side in (1, -1):
            rig = Rig()
            rig.turn.start(side * degrees * 16, 0)
            assert [rig.turn.update(0, 0, 1) for _ in range(3)][-1]
            assert rig.turn._there_q8 == there_q8, degrees


def test_another_count_is_another_sample():
    turn = Rig().within(GO)
    for count in (1, 2, 30, 0):
        turn.update(count, 0, count)
        assert turn._left_q8 == -count << 4
        turn.update(999, 0, count)
        assert turn._left_q8 == -count << 4


def test_a_sample_is_worked_on_in_four_ticks():
    rig = Rig()
    for phase, out in ((GO, LIMIT), (COUNTER, -LIMIT), (COAST, 0)):
        turn = rig.within(phase, 1, 800)
        turn._looked = False
        turn._fresh = False
        turn._stands = 5
        rig.casters.calls = []
        rig.slope.calls = []
        rig.left.free_q8 = 99
        rig.left.countered_q8 = 9999
        rig.model.angle_q16 = 8 << 16
        assert turn.update(0, 0, 50) == out
        assert turn._seen_q16 == 8 << 16
        assert not rig.casters.calls and not rig.slope.calls
        assert turn.update(0, 0, 50) == out
        assert [call[0] for call in rig.casters.calls] == ["skip"]
        assert turn.update(0, 0, 50) == out
        assert [call[0] for call in rig.casters.calls] == ["skip", "learn"]
        assert [call[0] for call in rig.slope.calls] == ["learn"]
        assert not turn._looked
        assert turn.update(0, 0, 50) == out
        assert rig.slope.calls[1:] == [("look_ahead", 99)]
        assert rig.left.asked == (rig.model.state, 8 << 16, 1)
        assert turn._looked and turn._moves == 1
        assert turn._phase == phase, "decided in the tick after"


def test_at_full_speed_another_rate_is_another_full_speed():
    for gain_q8, steady, faster_q8 in (
        (256, True, 0),
        (384, True, 500),
        (192, True, -250),
        (384, False, 0),
    ):
        rig = Rig()
        turn = rig.within(GO)
        rig.left.brakes_q8 = 1000
        rig.model.is_steady = steady
        turn._faster_q8 = 7
        turn._to_do = 1
        turn._gain_q8 = gain_q8
        rig.tick()
        assert turn._faster_q8 == faster_q8


def test_a_look_says_how_far_it_is_and_how_far_beside_the_model():
    rig = Rig()
    turn = rig.within(GO)
    turn._seen_q16 = 777
    for setpoint_q4, heading_q4, left_q4 in (
        (160, 0, 160),
        (0, 160, -160),
        (5759, 1, -2),
        (1, 5759, 2),
        (2879, 0, 2879),
        (2880, 0, -2880),
    ):
        for model_q4, beside_q4 in ((0, heading_q4), (10, heading_q4 - 10), (-10, heading_q4 + 10)):
            rig.model.angle_q16 = (model_q4 << 12) + 4095
            before_q16 = turn._seen_q16
            turn._setpoint_q4 = setpoint_q4
            turn._look(heading_q4, 0)
            assert turn._left_q8 == left_q4 << 4
            assert turn._before_q16 == before_q16
            assert turn._seen_q16 == (model_q4 << 12) + 4095
            assert (turn._beside_q8 - (beside_q4 << 4)) % (5760 << 4) == 0
            assert -2880 << 4 <= turn._beside_q8 < 2880 << 4
    assert not rig.casters.calls


def test_the_gain_is_the_measured_rate_by_the_models():
    # Both with 8 degrees/s more, because at rest the measurement tells nothing.
    for model_dps, rate_q4, drift_q8, gain_q8 in (
        (24, 24 * 16, 0, 256),
        (24, 8 * 16, 0, 128),
        (24, 40 * 16, 0, 384),
        (24, 24 * 16 + 1, 0, 256),
        (24, 24 * 16 + 2, 0, 257),
        (24, 24 * 16 - 1, 0, 255),
        (24, 0, 0, 64),
        (24, -1, 0, 64),
        (24, 56 * 16, 0, 512),
        (24, 57 * 16, 0, 512),
        (24, 24 * 16, 1024, 224),
        (24, 24 * 16, -1024, 288),
        (24, 24 * 16, 15, 256),
        (0, 0, 0, 256),
        (0, 16, 0, 288),
        (0, -16, 0, 224),
        (0, 0, 256, 224),
    ):
        for side in (1, -1):
            if model_dps or side > 0:
                rig = Rig()
                turn = rig.within(GO)
                rig.model.rate_q10 = side * model_dps << 10
                rig.slope.drift_q8 = side * drift_q8 if drift_q8 != 15 else 15
                turn._look(0, side * rate_q4)
                assert turn._gain_q8 == gain_q8, (model_dps, rate_q4, drift_q8, side)
    rig.slope.drift_q8 = 0
    for rate_q10 in (1, -1):
        rig.model.rate_q10 = rate_q10
        turn._look(0, rate_q10 * 16)
        assert turn._gain_q8 == 287, "9 degrees/s by a bit more than 8"


def test_the_casters_share_of_the_rate_is_the_models():
    for side in (1, -1):
        for adds_q8, model_dps in ((0, 24), (128, 36), (-128, 12), (-64, 18)):
            rig = Rig(True)
            turn = rig.within(GO)
            rig.model.angle_q16 = 12345
            rig.model.rate_q10 = side * 24 << 10
            rig.casters.adds_q8 = {side * 256: side * adds_q8}
            rig.casters.calls = []
            turn._look(0, side * model_dps * 16)
            assert turn._gain_q8 == 256, adds_q8
            assert rig.casters.calls == [("advance", 12345)]
            turn._look(0, side * (model_dps * 16 - 1))
            assert turn._gain_q8 == 255, "not a bit less"
    for rate_q10, way_q8 in ((0, 256), (-1, -256)):
        rig.model.rate_q10 = rate_q10
        rig.casters.adds_q8 = {way_q8: 0}
        turn._look(0, 0)
        assert 255 <= turn._gain_q8 <= 256


def test_standing_for_most_of_a_second_where_it_should_turn_it_has_missed():
    for rate_q10, rate_q4, stalls in (
        (8193, 0, True),
        (8193, 16, True),
        (8193, -16, True),
        (-8193, 0, True),
        (8192, 0, False),
        (8193, 17, False),
        (8193, -17, False),
    ):
        rig = Rig()
        turn = rig.within(GO)
        for samples in range(1, 82):
            rig.model.rate_q10 = rate_q10
            turn._look(0, rate_q4)
            assert turn.missed == (stalls and samples >= 80)
        rig.model.rate_q10 = 8192  # no longer so fast
        turn._look(0, 0)
        rig.model.rate_q10 = 8193
        for samples in range(1, 82):
            turn._look(0, 0)
            assert turn.missed == (samples >= 80)


def test_at_rest_the_models_rotation_counts_for_nothing():
    # Rate of the model, of the sensor, moves so far: whether it is idle.
    for rate_q10, rate_q4, moves, idle in (
        (0, 0, 1, True),
        (1535, 16, 1, True),
        (-1535, -16, 1, True),
        (1536, 0, 1, False),
        (-1536, 0, 1, False),
        (0, 17, 1, False),
        (0, -17, 1, False),
        (0, 0, 0, False),
    ):
        for before_q16, seen_q16, by_q16 in (
            (0, 700, 700),
            (700, 0, -700),
            (HALF_TURN - 100, -HALF_TURN + 100, 200),
            (-HALF_TURN + 100, HALF_TURN - 100, -200),
            (0, HALF_TURN, HALF_TURN),
            (-1, HALF_TURN, -HALF_TURN + 1),
            (HALF_TURN, 0, -HALF_TURN),
            (HALF_TURN, -1, HALF_TURN - 1),
        ):
            rig = Rig()
            turn = rig.within(GO, moves=moves)
            turn._before_q16 = before_q16
            turn._seen_q16 = rig.model.angle_q16 = seen_q16
            rig.model.rate_q10 = rate_q10
            turn._idle_q16 = 10
            turn._from_q16 = 20
            rig.casters.calls = []
            turn._watch_rest(rate_q4)
            if idle:
                assert (turn._idle_q16, turn._from_q16) == (10 + by_q16, 20 + by_q16)
                assert rig.casters.calls == [("skip", seen_q16)]
            else:
                assert (turn._idle_q16, turn._from_q16) == (10, 20)
                assert rig.casters.calls == [("mark",)]


def test_a_released_chair_that_stands_longer_than_the_dead_time_stays():
    # Halted in the 17th sample: 140 ms after the first three.
    for rate_q4 in (0, 8, -8):
        rig = Rig()
        turn = rig.within(COAST)
        turn._stands = 0
        turn._before_q16 = turn._seen_q16 = rig.model.angle_q16 = 10 << 16
        turn._beside_q8 = 1000
        rig.model.halts_at = 12 << 16
        rig.model.rate_q10 = 1700
        for samples in range(1, 18):
            assert turn._seen_q16 == 10 << 16
            assert turn._beside_q8 == 1000
            turn._watch_rest(rate_q4)
            assert turn._stands == samples
        assert rig.model.slower_than == 2048
        assert turn._seen_q16 == 12 << 16
        assert turn._beside_q8 == 1000 - (2 << 8)
        assert turn._idle_q16 == 2 << 16, "what it moved then counts for nothing either"
        rig.model.halts_at = 11 << 16
        turn._watch_rest(rate_q4)
        assert turn._beside_q8 == 1000 - (1 << 8)


def test_a_chair_that_may_still_move_is_not_halted():
    for phase, rate_q4, let_go, slower, out, stands in (
        (GO, 0, True, True, 0, True),
        (COUNTER, 0, True, True, 0, True),
        (COAST, 9, True, True, 0, False),
        (COAST, -9, True, True, 0, False),
        (COAST, 0, False, True, 0, False),
        (COAST, 0, True, False, 0, True),
        (COAST, 0, True, True, 1, False),
    ):
        rig = Rig()
        turn = rig.within(phase)
        turn._out = out
        turn._stands = 30
        rig.model.is_let_go = let_go
        rig.model.is_slower = slower
        rig.model.halts_at = 12 << 16
        turn._watch_rest(rate_q4)
        assert rig.model.angle_q16 == 0
        assert turn._stands == (31 if stands else 0)


def test_what_neither_model_nor_casters_explain_is_the_slopes():
    for from_q16, seen_q16, way_q4 in (
        (0, 10 << 16, 160),
        (10 << 16, 0, -160),
        (170 << 16, -170 << 16, 320),
        (0, 4095, 0),
        (0, -1, -1),
    ):
        rig = Rig()
        turn = rig.within(COAST)
        turn._beside_q8 = 300
        turn._idle_q16 = -515
        turn._from_q16 = from_q16
        turn._seen_q16 = seen_q16
        rig.model.rate_q10 = 999
        rig.casters.rest_q8 = 55
        rig.slope.calls = []
        rig.casters.calls = []
        turn._learn_slope()
        assert rig.casters.calls == [("learn", 300 - 3)]
        assert rig.slope.calls == [("learn", 55, way_q4, 999)]
        turn._moves = 0
        turn._learn_slope()
        assert len(rig.slope.calls) == 1, "before the first move nothing is to be explained"
