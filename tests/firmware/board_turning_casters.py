# The casters: where they are, what they add to a turn, and which end the heading tells.

import math

from gazeboard.turning.casters import Casters

_LOW = 0  # words of either end's position
_HIGH = 1
_WAY_Q4 = 1024  # 64 degrees
_WAY_Q8 = 16384
_UNIT_Q4 = 1024  # of 64 degrees: one of 16384 parts is 1/256 degree
_HALF_TURN = 180 << 16
_TURN = 360 << 16
# (1 - cos) / 2 of 16384, in 256 straight pieces.
_ENDS = [int(8192 * (1 - math.cos(math.pi * k / 256)) + 0.5) for k in range(257)] + [16384]


def positions(casters):
    return (casters._words[_LOW], casters._words[_HIGH])


def clamped(at, way_q8):
    return max(0, min(way_q8, at))


# How far they have turned the chair, of 16384, where they are `at` of their way.
def turned(at, way_q8=_WAY_Q8):
    to = at * ((1 << 24) // way_q8) >> 8
    end = _ENDS[to >> 8]
    return end + ((_ENDS[(to >> 8) + 1] - end) * (to & 255) >> 8)


# Both ends at `at`: known, because the chair has turned left for longer than that takes.
def known(at, size_q4=_UNIT_Q4, way_q4=_WAY_Q4):
    casters = Casters(size_q4, way_q4)
    to_go_q8 = way_q4 * 16
    angle_q8 = 0
    while to_go_q8 > 0:
        angle_q8 += 1000
        to_go_q8 -= 1000
        casters.advance(wrapped_q16(angle_q8))
    casters.advance(wrapped_q16(angle_q8 + at - way_q4 * 16))
    assert positions(casters) == (at, at)
    return casters


def wrapped_q16(angle_q8):
    return ((angle_q8 << 8) + _HALF_TURN) % _TURN - _HALF_TURN


def test_they_begin_at_either_end():
    assert positions(Casters(-160, 376)) == (0, 376 * 16)
    assert Casters(-160, 376).any
    assert Casters(1, 376).any
    assert not Casters(0, 376).any


def test_they_follow_the_wheels_through_whole_turns():
    way_q8 = 3 * 92160
    for side in (1, -1):
        for step_q16 in (255, 256, 257, 5900000, 5898240, _HALF_TURN - 256):
            casters = Casters(-160, 17280)
            angle_q16 = 0
            for _ in range(40):
                angle_q16 += side * step_q16
                casters.advance((angle_q16 + _HALF_TURN) % _TURN - _HALF_TURN)
                by_q8 = angle_q16 >> 8
                if side > 0:
                    assert positions(casters) == (clamped(by_q8, way_q8), way_q8)
                else:
                    assert positions(casters) == (0, clamped(way_q8 + by_q8, way_q8))


def test_half_a_turn_at_once_is_to_the_right():
    way_q8 = 3 * 92160
    for seen_q16, angle_q16, by_q8 in (
        (0, _HALF_TURN - 1, 46079),
        (-256, _HALF_TURN - 256, -46080),
        (-256, _HALF_TURN - 257, 46079),
        (0, -_HALF_TURN, -46080),
        (256, -_HALF_TURN, 46079),
        (256, -_HALF_TURN + 256, -46080),
        (256, -_HALF_TURN + 255, 46079),
    ):
        casters = Casters(-160, 17280)
        casters.advance(seen_q16)
        low, high = positions(casters)
        casters.advance(angle_q16)
        assert positions(casters) == (clamped(low + by_q8, way_q8), clamped(high + by_q8, way_q8))


def test_what_they_add_is_half_a_cosine_of_their_way():
    for size_q4, way_q4 in ((320, 376), (-320, 376), (1024, 2000), (-1024, 80)):
        way_q8 = way_q4 * 16
        for at in range(0, way_q8 + 1, way_q8 // 7):
            casters = known(at, size_q4, way_q4)
            for by in range(-way_q8 - 9, way_q8 + 9, way_q8 // 13):
                end = clamped(at + by, way_q8)
                added = math.cos(math.pi * at / way_q8) - math.cos(math.pi * end / way_q8)
                off_q8 = casters.swing_q8(by) - size_q4 * 8 * added
                assert abs(off_q8) <= 2 + abs(size_q4) * way_q8 / (1 << 20), (
                    size_q4,
                    way_q4,
                    at,
                    by,
                )


def test_what_they_add_is_exact_between_the_pieces():
    for way_q4 in (_WAY_Q4, 2000):
        way_q8 = way_q4 * 16
        for at in range(0, way_q8 + 1, way_q8 // 7 - 1):
            casters = known(at, _UNIT_Q4, way_q4)
            for by in range(-at, way_q8 - at + 1, 77):
                added_q8 = turned(at + by, way_q8) - turned(at, way_q8)
                assert casters.swing_q8(by) == added_q8, (way_q4, at, by)


def test_while_nobody_knows_it_is_the_end_that_turns_farther():
    for size_q4 in (_UNIT_Q4, -_UNIT_Q4):
        for by in (1, 100, 3000, 16384, 20000):
            casters = Casters(size_q4, _WAY_Q4)
            one = turned(clamped(by, _WAY_Q8))
            # Left: from the right's end they swing, at the left's they lie. Right: the other way.
            assert casters.swing_q8(by) == max(0, one if size_q4 > 0 else -one)
            # To the right.
            back = turned(_WAY_Q8 - clamped(by, _WAY_Q8)) - 16384
            assert casters.swing_q8(-by) == min(0, back if size_q4 > 0 else -back)
        # Neither at an end.
        casters.advance(40 << 16)
        casters.advance(10 << 16)
        low, high = positions(casters)
        assert low == 10 << 8 and high == 34 << 8
        for by in (2000, -2000):
            either = [turned(at + by) - turned(at) for at in (low, high)]
            if size_q4 < 0:
                either = [-one for one in either]
            assert casters.swing_q8(by) == (max(either) if by > 0 else min(either))
    casters = Casters(_UNIT_Q4, _WAY_Q4)
    casters.advance(32 << 16)
    assert casters.swing_q8(1) == turned(8193) - turned(8192) > 0
    assert casters.swing_q8(0) == 0
    assert casters.swing_q8(-1) == turned(8191) - turned(8192) < turned(16383) - 16384


def test_wheels_that_have_not_turned_leave_them_where_they_were():
    casters = Casters(_UNIT_Q4, _WAY_Q4)
    casters.skip(99 << 8)
    assert positions(casters) == (0, _WAY_Q8), "marked at the beginning"
    casters.advance(199 << 8)
    assert positions(casters) == (100, _WAY_Q8), "seen to have turned to 99 before"
    casters.advance(99 << 8)
    assert positions(casters) == (0, _WAY_Q8 - 100)
    casters.mark()
    casters.advance(599 << 8)
    assert positions(casters) == (500, _WAY_Q8)
    casters.skip(599 << 8)
    assert positions(casters) == (0, _WAY_Q8 - 100)
    casters.advance(649 << 8)
    assert positions(casters) == (50, _WAY_Q8 - 50)
    casters.mark()
    casters.advance(0)
    casters.skip(0)
    assert positions(casters) == (50, _WAY_Q8 - 50)


_ways = {}


# The way, to the left from the right's end or back, on which they turn the chair by `units`.
def way_for(units, side=1):
    if (units, side) not in _ways:
        at = 0
        while (turned(at) if side > 0 else 16384 - turned(_WAY_Q8 - at)) < units:
            at += 1
        _ways[units, side] = at
    return _ways[units, side]


# Watched from beside_q8 on, the wheels have turned so far that casters at one end have turned the
# chair by `units`: to the left from the right's, to the right from the left's.
def watched(units, side=1, beside_q8=0, size_q4=_UNIT_Q4):
    casters = Casters(size_q4, _WAY_Q4)
    casters.watch(beside_q8)
    casters.advance(side * way_for(units, side) << 8)
    return casters


# Which end it believes, by what they add to a turn of 10 degrees either way.
def believed(casters):
    low, high = positions(casters)
    added = (casters.swing_q8(-2560), casters.swing_q8(2560))
    either = [
        tuple([turned(clamped(at + by, _WAY_Q8)) - turned(at) for by in (-2560, 2560)])
        for at in (low, high)
    ]
    if low == high:
        assert added == either[0]
        return "certain"
    if added == either[0]:
        return "low"
    if added == either[1]:
        return "high"
    assert added == (min(either[0][0], either[1][0]), max(either[0][1], either[1][1]))
    return "either"


def test_the_heading_tells_which_end_it_was():
    for units in (192, 300, 384, 385, 1000, 1001, 6000):
        for beside_q8 in (0, -1234, 5000):
            for by_q8 in (-400, -1, 0, 1, 308, 350, 499, 500, 501, 692, 693, units - 1, units + 50):
                # Without casters that turned it is off by all of it, with them by so much less.
                low_q8 = by_q8 - units
                worse_q8 = abs(low_q8) - abs(by_q8)
                casters = watched(units, 1, beside_q8)
                low, high = positions(casters)
                rest_q8 = casters.learn(beside_q8 + by_q8)
                if worse_q8 < 0:
                    assert rest_q8 == low_q8, (units, by_q8)
                    at, end = low, "low"
                else:
                    assert rest_q8 == by_q8, (units, by_q8)
                    at, end = high, "high"
                if abs(worse_q8) > 384:
                    assert positions(casters) == (at, at), (units, by_q8)
                    assert believed(casters) == "certain"
                else:
                    assert positions(casters) == (low, high)
                    assert believed(casters) == end, (units, by_q8)
                # The same to the right, mirrored; there it is the left's end that they leave.
                casters = watched(units, -1, beside_q8)
                rest_q8 = casters.learn(beside_q8 - by_q8)
                assert rest_q8 == (-low_q8 if worse_q8 <= 0 else -by_q8), (units, by_q8)


def test_it_compares_anywhere_on_the_way():
    for at in range(6000, 32000, 1777):
        casters = Casters(_UNIT_Q4, 2000)
        casters.watch(0)
        casters.advance(at << 8)
        assert casters.learn(turned(at, 32000)) == 0


def test_once_it_is_certain_both_follow_that_one():
    for side in (1, -1):
        for swung in (True, False):
            casters = watched(1000, side, 77)
            assert casters.learn(77 + side * (1000 if swung else 0)) == 0
            casters.advance(side * way_for(6000, side) << 8)
            low, high = positions(casters)
            assert low == high
            for by_q8 in (7000, 12, -10000, 16000):
                rest_q8 = side * (by_q8 - 6000 if swung else by_q8)
                assert casters.learn(77 + side * by_q8) == rest_q8, (side, swung, by_q8)
            assert positions(casters) == (low, high)


def test_too_little_between_the_two_tells_nothing():
    for size_q4, sign in ((_UNIT_Q4, 1), (-_UNIT_Q4, -1)):
        for side in (1, -1):
            for units, tells in ((0, False), (191, False), (192, True)):
                casters = watched(units, side, 0, size_q4)
                rest_q8 = casters.learn(side * sign * units)
                if tells:
                    assert rest_q8 == 0
                else:
                    assert rest_q8 == (side * sign * units) >> 1, "the mean of both"


def test_a_belief_ends_when_the_two_are_alike_again():
    casters = watched(300)
    casters.learn(300)
    assert believed(casters) == "low"
    casters.learn(100)
    assert believed(casters) == "high"
    casters.advance(way_for(100) << 8)
    casters.learn(0)
    assert believed(casters) == "either"
    # But not when they are one: skip() may part them again.
    casters.mark()
    casters.advance(way_for(1000) << 8)
    casters.learn(1000)
    casters.learn(1000)
    assert believed(casters) == "certain"
    casters.skip(way_for(100) << 8)
    assert believed(casters) == "low"


def test_what_was_believed_is_certain_for_the_next_turn():
    for by_q8, at in ((0, _WAY_Q8), (300, way_for(300))):
        casters = watched(300)
        casters.learn(by_q8)
        casters.watch(77)
        assert positions(casters) == (at, at)
        assert casters.learn(77) == 0
        casters.advance(way_for(6000) << 8)
        assert casters.learn(77) == turned(at) - turned(positions(casters)[0])
    casters = watched(300)
    low, high = positions(casters)
    casters.watch(77)
    assert positions(casters) == (low, high), "nobody knew"
    casters.advance(way_for(6000) << 8)
    assert casters.learn(77 + 6000 - 300) == 0
    assert positions(casters) == (way_for(6000), way_for(6000))


def test_watching_marks_where_they_are():
    for side in (1, -1):
        casters = watched(300, side)
        where = positions(casters)
        casters.watch(0)
        casters.advance(side * way_for(6000, side) << 8)
        casters.skip(side * way_for(6000, side) << 8)
        assert positions(casters) == where
