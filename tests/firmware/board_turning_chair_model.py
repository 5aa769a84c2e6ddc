# The model of the chair, millisecond by millisecond: what each of its parts does to the next.

import math

from gazeboard.turning.chair_model import ChairModel

_ASKED = 0  # words of the state
_RAMP = 1
_RATE = 2
_RATE_REST = 3
_ANGLE = 4
_ANGLE_REST = 5
_HALF_TURN = 180 << 16

# Of which the model's numbers are whole: 4096 and 2048 a permille, 8192 and 16384 a ms.
_VALUES = {
    "deadband_permille": 488,
    "dead_time_ms": 140,
    "lag_ms": 350,
    "left_q4_dps": 512,
    "right_q4_dps": 256,
    "accelerate_dps2": 125,
    "brake_dps2": 250,
    "breakaway_q4_dps": 160,
}
_BREAKAWAY = 160 << 12


class Profile:
    def __init__(self, values):
        self._values = values

    def of_profile(self, name):
        return self._values[name]


def model_of(**values):
    return ChairModel(Profile(dict(_VALUES, **values)))


# A model with these words of its state, all else as at rest.
def model_at(words, **values):
    model = model_of(**values)
    for k in words:
        model.state[k] = words[k]
    return model


def test_it_begins_at_rest():
    model = model_of()
    assert (model.dead_ms, model.lag_ms) == (140, 350)
    for _ in range(300):
        assert model.step(0) == 0
        assert list(model.state[:_ANGLE_REST]) == [0, 0, 0, 0, 0]
        assert model.seen_angle() == model.seen_rate() == 0
        assert model.let_go()


def test_beyond_the_deadband_each_permille_asks_for_as_much():
    model = model_of()
    for permille, asked in (
        (1000, 512 * 4096),
        (490, 2 * 4096),
        (489, 4096),
        (488, 0),
        (1, 0),
        (0, 0),
        (-1, 0),
        (-488, 0),
        (-489, -2048),
        (-1000, -512 * 2048),
        (488, 0),
        (1000, 512 * 4096),
    ):
        for _ in range(3):
            model.step(permille)
            assert model.state[_ASKED] == asked, permille
    model = model_of(deadband_permille=0)
    for permille, asked in ((1, 2097), (-1, -1048), (0, 0)):
        model.step(permille)
        assert model.state[_ASKED] == asked, "512 and 256 / 16 degrees/s, a thousandth"


def test_the_ramp_goes_up_with_one_slope_and_back_with_the_other():
    left = 512 * 4096
    right = -512 * 2048
    for ramp, permille, then in (
        (0, 1000, 8192),
        (1, 1000, 8193),
        (-1, 1000, 16383),
        (left - 8193, 1000, left - 1),
        (left - 8192, 1000, left),
        (left - 1, 1000, left),
        (left, 1000, left),
        (left + 1, 1000, left),
        (left + 16384, 1000, left),
        (left + 16385, 1000, left + 1),
        (0, -1000, -8192),
        (-1, -1000, -8193),
        (1, -1000, -16383),
        (right + 8193, -1000, right + 1),
        (right + 8192, -1000, right),
        (right, -1000, right),
        (right - 1, -1000, right),
        (right - 16384, -1000, right),
        (right - 16385, -1000, right - 1),
        (16385, 0, 1),
        (16384, 0, 0),
        (1, 0, 0),
        (0, 0, 0),
        (-1, 0, 0),
        (-16384, 0, 0),
        (-16385, 0, -1),
    ):
        model = model_at({_RAMP: ramp})
        model.step(permille)
        assert model.state[_RAMP] == then, (ramp, permille)


def test_the_lag_lets_a_share_through_and_loses_nothing():
    for lag_ms in (20, 35, 100, 350, 800):
        share = (2 << 16) // (2 * lag_ms + 1)
        exact = 65536 * (1 - math.exp(-1 / lag_ms))
        assert exact * 0.9997 - 1 <= share <= exact * 1.0003
        for start, side in ((_BREAKAWAY, 1), (30 << 16, 1), (_BREAKAWAY, -1), (30 << 16, -1)):
            model = model_at({_RAMP: side * start, _ASKED: side * start}, lag_ms=lag_ms)
            behind = 0
            for _ in range(200):
                before = model.state[_RATE]
                model.step(0)
                behind += side * (start >> 6) - before
                rate = model.state[_RATE]
                # All that it was behind, times the share, is in rate and rest.
                assert (rate << 16) + model.state[_RATE_REST] == behind * share
                assert 0 <= model.state[_RATE_REST] < 65536
                assert 0 <= side * rate <= start >> 6
                assert model.state[_RAMP] == side * start, "no other output, no other ramp"


def test_a_ramp_below_breaking_loose_leaves_a_standing_chair_standing():
    for side in (1, -1):
        for ramp, sticks in ((_BREAKAWAY - 1, True), (_BREAKAWAY, False), (_BREAKAWAY + 1, False)):
            words = {_RAMP: side * ramp, _ASKED: side * ramp, _RATE_REST: 300}
            model = model_at(words, lag_ms=20)
            model.step(0)
            assert (model.state[_RATE] == 0) == sticks, (side, ramp)
            assert (model.state[_RATE_REST] == 0) == sticks
            # A chair that still turns goes on doing so.
            model = model_at(words, lag_ms=20)
            model.state[_RATE] = side * 2
            model.step(0)
            assert side * model.state[_RATE] > 2
            assert model.state[_RATE_REST] > 0


def test_turning_round_it_sticks_below_breaking_loose():
    # At 20 ms of lag 3196 / 65536 of the difference go a ms.
    model = model_of(lag_ms=20)
    by_itself = set()
    for side in (1, -1):
        for before in (1, 10):
            for ramp_q10 in list(range(4, 460, 4)) + [10239, 10240]:
                model.state[_RATE] = side * before
                model.state[_RATE_REST] = 0
                model.state[_RAMP] = model.state[_ASKED] = -side * ramp_q10 << 6
                model.step(0)
                share = (-side * ramp_q10 - side * before) * 3196
                rate = side * before + (share >> 16)
                rest = share & 65535
                if side * rate < 0 and ramp_q10 < 10240:
                    rate = rest = 0
                else:
                    by_itself.add(rate)
                assert (model.state[_RATE], model.state[_RATE_REST]) == (rate, rest), ramp_q10
    assert 0 in by_itself and max(by_itself) > 400 and min(by_itself) < -400


def test_at_a_standstill_the_brakes_hold_it():
    # At 800 ms of lag 81 / 65536 of the difference go a ms; the rest keeps it where it is.
    for rate, rest, after in (
        (512, 512 * 81, 512),
        (512, 512 * 81 - 1, 0),
        (511, 511 * 81, 0),
        (4, 400, 0),
        (-4, 0, 0),
        (-511, 0, 0),
        (-512, 0, -512),
        (-513, 65535, -512),
    ):
        model = model_at({_RATE: rate, _RATE_REST: rest}, lag_ms=800)
        model.step(0)
        assert model.state[_RATE] == after, rate
    for words, permille in (({_RAMP: 65536, _ASKED: 65536}, 0), ({_RAMP: 1}, 0), ({}, 489)):
        model = model_at(words, lag_ms=800)
        model.state[_RATE] = 300
        model.step(permille)
        held = model.state[_RAMP] == 0 and permille == 0
        assert (model.state[_RATE] == 0) == held, "neither ramp nor what is asked for may be left"


def test_the_angle_is_the_sum_of_the_rates():
    for rate_q10 in (4, 1027, -1027, 40960, 153600, -153600):
        model = model_at({_RATE: rate_q10, _RAMP: rate_q10 << 6, _ASKED: rate_q10 << 6})
        turned = 0
        angle = 0
        for _ in range(1000):
            before = model.state[_ANGLE]
            model.step(0)
            assert model.state[_RATE] == rate_q10 or abs(rate_q10) < 10240
            rate = model.state[_RATE]
            turned += (rate >> 2) * 8389  # 2^23 / 1000 of a quarter of it
            by = model.state[_ANGLE] - before
            angle += by + (_HALF_TURN * 2 if by < -_HALF_TURN else 0)
            angle -= _HALF_TURN * 2 if by > _HALF_TURN else 0
            assert (angle << 15) + model.state[_ANGLE_REST] == turned
            assert 0 <= model.state[_ANGLE_REST] < 32768
            assert -_HALF_TURN <= model.state[_ANGLE] < _HALF_TURN
        if abs(rate_q10) >= 10240:
            assert abs(angle - rate_q10 * 64) <= abs(rate_q10) * 64 / 10000 + 1000


def test_it_wraps_at_half_a_turn():
    # 4 / 1024 degree/s add 8389 of 32768 parts.
    for angle, rate, rest, then in (
        (_HALF_TURN - 1, 0, 0, _HALF_TURN - 1),
        (_HALF_TURN - 1, 512, 32767, -_HALF_TURN + 32),
        (_HALF_TURN - 1, 4, 32768 - 8389, -_HALF_TURN),
        (-_HALF_TURN, 0, 0, -_HALF_TURN),
        (-_HALF_TURN, -4, 0, _HALF_TURN - 1),
        (-_HALF_TURN + 1, -4, 0, -_HALF_TURN),
    ):
        words = {_ANGLE: angle, _RATE: rate, _ANGLE_REST: rest, _RAMP: rate << 6, _ASKED: rate << 6}
        model = model_at(words, breakaway_q4_dps=0)
        model.step(0)
        assert model.state[_RATE] == rate
        assert model.state[_ANGLE] == then, (angle, rate)


def test_what_is_seen_is_as_old_as_the_dead_time():
    for dead_ms in (20, 140, 400):
        model = model_of(dead_time_ms=dead_ms)
        angles = [0] * dead_ms
        rates = [0] * dead_ms
        for ms in range(1300):
            seen = model.step(1000 if ms < 600 else -1000)
            angles.append(model.state[_ANGLE])
            rates.append(model.state[_RATE])
            assert seen == model.seen_angle() == angles[ms]
            assert model.seen_rate() == rates[ms]
    assert len(set(angles)) > 1000 and len(set(rates)) > 700


def test_halted_it_has_stood_here_for_as_long_as_anybody_sees():
    for dead_ms in (20, 400):
        model = model_of(dead_time_ms=dead_ms)
        for _ in range(777):
            model.step(1000)
        rest = list(model.state[5:16])
        model.halt()
        angle = model.state[_ANGLE]
        assert list(model.state[5:16]) == rest
        assert list(model.state[16:]) == [angle, 0] * 512
        assert angle
        assert model.state[_RATE] == model.state[_RATE_REST] == 0
        model.state[_RAMP] = model.state[_ASKED] = 0
        for _ in range(600):
            assert model.seen_angle() == angle
            assert model.seen_rate() == 0
            model.step(0)


def test_it_is_let_go_when_nothing_is_asked_and_the_ramp_is_back():
    for asked in (-1, 0, 1):
        for ramp in (-1, 0, 1):
            model = model_at({_ASKED: asked, _RAMP: ramp})
            assert model.let_go() == (asked == 0 and ramp == 0)


def test_slower_is_slower_either_way():
    for rate in range(-3, 4):
        model = model_at({_RATE: rate})
        for bound in (1, 2, 3):
            assert model.slower(bound) == (abs(rate) < bound)


def test_steady_is_within_an_eighth_of_what_is_asked():
    for asked_q10 in (1, 7, 8, 15, 800, 4097, -1, -7, -8, -15, -800):
        model = model_at({_ASKED: asked_q10 << 6})
        for around in (asked_q10 * 7 // 8, asked_q10, asked_q10 * 9 // 8, 0, -asked_q10):
            for rate_q10 in range(around - 2, around + 3):
                model.state[_RATE] = rate_q10
                off = abs(asked_q10 - rate_q10)
                assert model.steady() == (off <= abs(asked_q10) // 8), (asked_q10, rate_q10)
    for rate_q10 in (-1, 0, 1):
        assert not model_at({_ASKED: 0, _RATE: rate_q10}).steady()
