# Small corrections from rest: what the effect of one makes of the next.

from gazeboard.turning.small_moves import SmallMoves


# A move that the model ends after planned_ms: how long it lasts, ms.
def lasts_ms(moves, planned_ms):
    ms = 1
    while not moves.ends(ms >= planned_ms):
        ms += 1
        assert ms < 5000
    return ms


# Whether the next move has to do half of what is left only.
def is_careful(moves):
    for left_q8 in (0, 1, 101, 800):
        aim_q8 = moves.aim_q8(left_q8)
        assert aim_q8 == left_q8 or aim_q8 == left_q8 >> 1
    return aim_q8 != 800


# A move for 400 that took 100 ms, to `side`, after which left_q8 were left to that side.
def after_one(side, left_q8, asked_q8=400, bounded=1):
    moves = SmallMoves()
    moves.begin(side * asked_q8, side, bounded)
    assert lasts_ms(moves, 100) == 100
    moves.begin(side * left_q8, side if left_q8 >= 0 else -side, 1)
    return moves


def test_the_first_of_a_turn_ends_as_planned():
    for bounded in (0, 1):
        for planned_ms in (1, 2, 50, 4000):
            moves = SmallMoves()
            moves.begin(400, 1, bounded)
            assert lasts_ms(moves, planned_ms) == planned_ms
            assert not is_careful(moves)


def test_one_with_less_than_half_its_effect_is_followed_by_a_longer_one():
    for side in (1, -1):
        for asked_q8 in (400, 401):
            for left_q8, longer in ((asked_q8 - 200, False), (asked_q8 - 199, True), (500, True)):
                for planned_ms in (1, 129, 130, 150, 190, 191, 3000):
                    moves = after_one(side, left_q8, asked_q8)
                    assert not is_careful(moves)
                    ms = max(130, min(190, planned_ms)) if longer else planned_ms
                    assert lasts_ms(moves, planned_ms) == ms, (side, left_q8, planned_ms)


def test_it_grows_with_each_that_has_no_effect():
    for side in (1, -1):
        moves = after_one(side, 400)
        for ms in (130, 160, 190):
            assert lasts_ms(moves, 1) == ms
            moves.begin(side * 400, side, 1)


def test_even_one_of_a_millisecond_counts():
    moves = SmallMoves()
    moves.begin(400, 1, 1)
    assert lasts_ms(moves, 1) == 1
    moves.begin(400, 1, 1)
    assert lasts_ms(moves, 1) == 31


def test_to_the_other_side_nothing_of_it_counts():
    for side in (1, -1):
        moves = after_one(side, 400)
        assert lasts_ms(moves, 1) == 130
        for towards in (-side, side):
            moves.begin(towards * 400, towards, 1)
            assert lasts_ms(moves, 1) == 1


def test_one_with_half_as_much_again_is_followed_by_one_for_half():
    for side in (1, -1):
        for asked_q8, left_q8, careful in (
            (400, -200, False),
            (400, -201, True),
            (401, -200, False),
        ):
            moves = after_one(side, left_q8, asked_q8)
            assert is_careful(moves) == careful
            assert lasts_ms(moves, 20) == 20
            moves.begin(0, side, 0)
            assert not is_careful(moves), "the second did what it should"
        moves = after_one(side, -201)
        moves.begin(side * 100, side, 0)
        assert not is_careful(moves), "the second did what it should"
        moves = after_one(side, -201)
        moves.begin(side * 101, side, 0)
        assert is_careful(moves), "the second, for 201, did 302"
        moves.begin(side * 50, side, 1)
        assert is_careful(moves), "the third was none of these"
        assert lasts_ms(moves, 10) == 10
        moves.begin(0, 1, 1)
        assert not is_careful(moves)


def test_a_move_that_is_not_small_or_not_from_rest_limits_nothing():
    for side in (1, -1):
        for left_q8 in (400, -400):
            moves = after_one(side, left_q8, bounded=0)
            assert not is_careful(moves)
            assert lasts_ms(moves, 1) == 1
        moves = after_one(side, 400)
        assert lasts_ms(moves, 1) == 130
        moves.begin(side * 400, side, 0)
        assert lasts_ms(moves, 1) == 1, "nor is it limited"


def test_the_next_turn_knows_nothing_of_it():
    for side in (1, -1):
        for left_q8 in (400, -400):
            moves = after_one(side, left_q8)
            moves.start()
            assert not is_careful(moves)
            moves.begin(side * 400, side, 1)
            assert not is_careful(moves)
            assert lasts_ms(moves, 1) == 1
