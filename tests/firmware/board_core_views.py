# The board's decision per direction over time: a better view waits, an old one is used up.

from gazeboard.core import limits
from gazeboard.core.stopping import LEVELS
from gazelink import codes
from gazelink.messages import CLEAR_FAR
from obstaclerig import TURN_MS, Eyes, outputs


def test_a_better_view_counts_after_300_ms_and_by_a_band():
    for direction in range(4):
        for low in (-1, 0, 5, LEVELS - 1):
            for high in (low + 1, LEVELS):
                eyes = Eyes()
                s = eyes.stopping(direction)
                eyes.set(s.begin[low] if low >= 0 else s.begin[0] - 1, (direction,))
                eyes.run(40)
                # Better, but not by the band: never.
                eyes.set(s.begin[low + 1] + s.band - 1, (direction,))
                eyes.run(800)
                assert eyes.way(direction).level == low
                eyes.set(s.begin[high] + s.band, (direction,))
                eyes.run(limits.CLEAR_MS - TURN_MS)
                assert eyes.way(direction).level == low
                eyes.run(50)
                assert eyes.way(direction).level == high, (direction, low, high)


def test_a_worse_view_in_between_starts_the_wait_anew():
    eyes = Eyes()
    s = eyes.stopping(0)
    eyes.set(s.begin[3], (0,))
    eyes.run(40)
    for _ in range(8):
        eyes.set(CLEAR_FAR, (0,))
        eyes.run(240)
        eyes.set(s.begin[4] + s.band - 1, (0,))
        eyes.run(40)
        assert eyes.way(0).level == 3
    eyes.set(CLEAR_FAR, (0,))
    eyes.run(240)
    eyes.set(s.begin[2], (0,))
    eyes.run(20)
    eyes.set(CLEAR_FAR, (0,))
    eyes.run(200)
    assert eyes.way(0).level == 2


def test_noise_of_3_cm_makes_nothing_chatter():
    for place in range(150, 1300, 23):
        eyes = Eyes()
        state = 1
        seen = []
        for _ in range(120):
            state = (state * 75 + 74) % 65537
            eyes.set(place + state % 61 - 30, (0,))
            eyes.run(20)
            seen.append(eyes.decision(0))
        settled = seen[30:]
        assert settled == [settled[0]] * len(settled), place


def test_old_distances_are_shortened_by_what_the_chair_may_have_moved():
    for direction in range(4):
        for age_ms in (40, 100, 250):
            eyes = Eyes()
            eyes.age_ms = age_ms
            outputs(eyes, direction, 400)
            eyes.run(40)
            way = eyes.way(direction)
            moved = way.speed * age_ms // 1000
            eyes.frames = False
            eyes.set(way.stop + moved, (direction,))
            eyes.frame()
            eyes.tick()
            assert eyes.decision(direction) != codes.BLOCKED
            eyes.set(way.stop + moved - 1, (direction,))
            eyes.frame()
            eyes.tick()
            assert eyes.decision(direction) == codes.BLOCKED


def test_a_distance_that_is_not_renewed_is_used_up():
    for direction in range(4):
        eyes = Eyes()
        outputs(eyes, direction, 400)
        eyes.run(40)
        way = eyes.way(direction)
        eyes.frames = False
        eyes.set(way.stop + way.speed // 5, (direction,))  # 200 ms
        eyes.frame()
        ms = 0
        while eyes.decision(direction) != codes.BLOCKED:
            eyes.tick()
            ms += 1
            assert ms < 400
        assert 190 <= ms <= 225, ms


def test_an_age_saturates():
    eyes = Eyes()
    eyes.frames = False
    eyes.o._age_ms = limits.AGE_MAX_MS - 3
    eyes.run(40)
    assert eyes.o._age_ms == limits.AGE_MAX_MS


def test_a_clearance_in_every_tick_keeps_nothing_waiting():
    eyes = Eyes()
    s = eyes.stopping(0)
    eyes.frames = False
    eyes.set(s.begin[5], (0,))
    for _ in range(3 * TURN_MS):
        eyes.frame()
        eyes.tick()
    assert eyes.o.caps[0] == s.permille[5]
    eyes.set(0, (0,))
    eyes.frame()
    eyes.tick()
    assert eyes.decision(0) == codes.BLOCKED


def test_frequent_clearances_do_not_lengthen_a_bypass():
    eyes = Eyes()
    eyes.set(0)
    eyes.run(40)
    eyes.hold_bypass(1)
    ms = 0
    while ms < 30 or eyes.o.blocked == 0:
        if ms % 50 == 0:
            eyes.hold_bypass(1)
        eyes.frame()
        eyes.tick()
        ms += 1
        assert ms <= limits.BYPASS_MAX_MS
    assert limits.BYPASS_MAX_MS - 50 <= ms <= limits.BYPASS_MAX_MS


def test_a_single_near_clearance_blocks_for_300_ms_whatever_was_waited_before():
    eyes = Eyes()
    s = eyes.stopping(0)
    eyes.set(s.begin[3], (0,))
    eyes.run(40)
    eyes.set(CLEAR_FAR, (0,))
    eyes.run(280)  # nearly believed
    eyes.frames = False
    eyes.set(0, (0,))
    eyes.frame()
    eyes.tick()
    eyes.set(CLEAR_FAR, (0,))
    eyes.frame()
    eyes.frames = True
    eyes.run(limits.CLEAR_MS - TURN_MS)
    assert eyes.decision(0) == codes.BLOCKED
    eyes.run(60)
    assert eyes.decision(0) == codes.FREE


def test_each_rise_waits_anew():
    eyes = Eyes()
    s = eyes.stopping(0)
    eyes.set(s.begin[3], (0,))
    eyes.run(40)
    eyes.set(s.begin[5] + s.band, (0,))
    eyes.run(400)
    assert eyes.way(0).level == 5
    eyes.set(CLEAR_FAR, (0,))
    eyes.run(limits.CLEAR_MS - TURN_MS)
    assert eyes.way(0).level == 5


def test_without_any_clearance_a_moving_chair_is_blocked():
    eyes = Eyes(clear=False)
    eyes.frames = False
    eyes.set(10000)
    eyes.linear = 600
    eyes.turn = -600
    eyes.run(1000)
    assert eyes.o.blocked & 9 == 9


def test_what_the_chair_moved_meanwhile_is_exact():
    for direction in range(4):
        for speed, age_ms, moved in ((200, 250, 50), (999, 250, 249), (1000, 100, 100)):
            for short in (0, 1):
                eyes = Eyes()
                eyes.frames = False
                way = eyes.way(direction)
                way.speed = speed
                way.stop = 300
                eyes.age_ms = age_ms
                eyes.set(300 + moved - short, (direction,))
                eyes.frame()
                eyes.tick()
                assert eyes.o.blocked == short << direction
                # And the same by its turn.
                way.level = LEVELS
                way.judge(eyes.stopping(direction), 300 + moved - short, age_ms, LEVELS)
                assert (way.level < 0) == (short == 1)


def test_one_turn_of_a_worse_view_starts_the_wait_anew():
    eyes = Eyes()
    way = eyes.way(0)
    s = eyes.stopping(0)
    way.level = 5
    turns = limits.CLEAR_MS // TURN_MS
    for _ in range(turns):
        way.judge(s, CLEAR_FAR, 0, LEVELS)
    way.judge(s, s.begin[4], 0, LEVELS)
    for _ in range(turns):
        way.judge(s, CLEAR_FAR, 0, LEVELS)
        assert way.level == 4
    way.judge(s, CLEAR_FAR, 0, LEVELS)
    assert way.level == LEVELS


def test_the_count_of_clearances_wraps():
    eyes = Eyes()
    eyes.frames = False
    eyes.i.clearance_count = 0xFFFE
    eyes.frame()
    eyes.tick()
    eyes.tick()
    eyes.set(0, (0,))
    eyes.frame()
    assert eyes.i.clearance_count == 0
    eyes.tick()
    assert eyes.decision(0) == codes.BLOCKED


def test_a_view_that_is_better_yet_waits_anew_too():
    eyes = Eyes()
    way = eyes.way(0)
    s = eyes.stopping(0)
    way.level = 3
    for _ in range(limits.CLEAR_MS // TURN_MS + 1):
        assert way.level == 3
        way.judge(s, s.begin[5] + s.band, 0, LEVELS)
    assert way.level == 5
    way.judge(s, CLEAR_FAR, 0, LEVELS)
    assert way.level == 5


def test_ms_without_a_tick_age_the_clearance_and_use_up_the_bypass():
    eyes = Eyes()
    eyes.frames = False
    eyes.hold_bypass(1)
    eyes.run(TURN_MS)
    held_ms = eyes.o.bypass.left_ms
    age_ms = eyes.o._age_ms
    eyes.o.missed(57)
    assert eyes.o._age_ms == age_ms + 57
    eyes.run(TURN_MS)
    assert eyes.o.bypass.left_ms == held_ms - 57 - TURN_MS
    eyes.o.missed(1 << 20)
    assert eyes.o._age_ms == limits.AGE_MAX_MS
