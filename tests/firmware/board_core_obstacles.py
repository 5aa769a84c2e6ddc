# The board's decision per direction: free, slow, blocked, and the most output each may have.

from gazeboard.core import limits
from gazeboard.core.obstacles import Obstacles
from gazeboard.core.shared import Inputs
from gazeboard.core.stopping import LEVELS
from gazeboard.io.settings import Settings
from gazelink import arcs, codes
from gazelink.messages import CLEAR_FAR

NAMES = ("clearance_forward_mm", "clearance_backward_mm", "clearance_left_q4", "clearance_right_q4")
TURN_MS = 8


class Eyes:
    # Obstacles with inputs set by hand; a clearance every 20 ms, `age_ms` old when it comes.

    def __init__(self, settings=None, clear=True):
        self.o = Obstacles(settings or Settings())
        self.i = Inputs()
        self.i.session_count = 1
        self.age_ms = 0
        self.linear = 0
        self.turn = 0
        self.armed = True
        self.trusted = False
        self.frames = True
        self.now_ms = 0
        self.i.clearance_arcs = bytearray(arcs.ALL_FAR)
        self.set(CLEAR_FAR)
        if clear:
            self.run(400)

    def set(self, distance, directions=(0, 1, 2, 3)):
        for direction in directions:
            setattr(self.i, NAMES[direction], distance)

    def frame(self):
        self.i.clearance_age_ms = self.age_ms
        self.i.clearance_count = (self.i.clearance_count + 1) & 0xFFFF

    def tick(self):
        if self.frames and self.now_ms % 20 == 0:
            self.frame()
        self.now_ms += 1
        self.o.step(self.i, self.linear, self.turn, self.armed, self.trusted)

    def run(self, ms):
        for _ in range(ms):
            self.tick()

    def hold_bypass(self, number):
        self.i.bypass_number = number
        self.i.bypass_ttl_ms = 300
        self.i.bypass_count = (self.i.bypass_count + 1) & 0xFFFF

    def stopping(self, direction):
        return self.o._stopping[direction + 4 if self.trusted else direction]

    def decision(self, direction):
        decision = self.o.decisions >> (2 * direction) & 3
        blocked = self.o.blocked >> direction & 1
        assert (decision == codes.BLOCKED) == (blocked == 1) == (self.o.caps[direction] == 0)
        return decision

    def way(self, direction):
        return self.o._ways[direction]


def outputs(eyes, direction, permille):
    eyes.linear = (permille, -permille, 0, 0)[direction]
    eyes.turn = (0, 0, permille, -permille)[direction]


def test_before_anything_was_seen_every_way_is_blocked():
    eyes = Eyes(clear=False)
    assert (eyes.o.blocked, eyes.o.decisions, eyes.o.caps) == (15, 0xAA, [0, 0, 0, 0])
    eyes.run(limits.CLEAR_MS - TURN_MS)
    assert (eyes.o.blocked, eyes.o.decisions, eyes.o.caps) == (15, 0xAA, [0, 0, 0, 0])
    eyes.run(60)
    assert (eyes.o.blocked, eyes.o.decisions, eyes.o.caps) == (0, 0, [1000] * 4)


def test_at_rest_each_level_of_a_way_has_its_cap():
    for trusted in (False, True):
        for direction in range(4):
            eyes = Eyes()
            eyes.trusted = trusted
            s = eyes.stopping(direction)
            for k in range(LEVELS, 0, -1):
                eyes.set(s.begin[k], (direction,))
                eyes.run(40)
                assert eyes.o.caps[direction] == s.permille[k]
                assert eyes.decision(direction) == (codes.FREE if k == LEVELS else codes.SLOW)
                eyes.set(s.begin[k] - 1, (direction,))
                eyes.run(40)
                assert eyes.o.caps[direction] == s.permille[k - 1]
                assert eyes.decision(direction) == codes.SLOW
            eyes.set(s.begin[0] - 1, (direction,))
            eyes.run(40)
            assert eyes.decision(direction) == codes.BLOCKED
            for other in range(4):
                assert other == direction or eyes.o.caps[other] == 1000


def test_a_fall_over_many_levels_is_at_once():
    for direction in range(4):
        s = Eyes().stopping(direction)
        for k in range(LEVELS):
            eyes = Eyes()
            eyes.set(s.begin[k], (direction,))
            eyes.run(2 * TURN_MS)
            assert eyes.o.caps[direction] == s.permille[k]
        eyes = Eyes()
        eyes.set(0, (direction,))
        eyes.run(2 * TURN_MS)
        assert eyes.decision(direction) == codes.BLOCKED


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


def test_the_faster_the_longer_the_way_to_stop():
    for direction in range(4):
        for permille in range(250, 1001, 50):
            eyes = Eyes()
            outputs(eyes, direction, permille)
            eyes.run(20)
            s = eyes.stopping(direction)
            speed = s.speed(permille)
            assert eyes.way(direction).speed == speed
            assert eyes.way(direction).stop == s.stop(eyes.way(direction).speed)
            for other in range(4):
                assert other == direction or eyes.way(other).stop == eyes.stopping(other).margin
            # Blocked below it, in the tick that sees it; not at it.
            eyes.set(eyes.way(direction).stop, (direction,))
            eyes.frame()
            eyes.tick()
            assert eyes.decision(direction) != codes.BLOCKED
            eyes.set(eyes.way(direction).stop - 1, (direction,))
            eyes.frame()
            eyes.tick()
            assert eyes.decision(direction) == codes.BLOCKED
            assert eyes.o.caps[direction] == 0


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


def test_a_measured_turn_rate_counts_where_it_is_the_higher():
    for direction, sign in ((codes.DIR_LEFT, 1), (codes.DIR_RIGHT, -1)):
        eyes = Eyes()
        other = codes.DIR_LEFT + codes.DIR_RIGHT - direction
        eyes.i.rate_q4 = sign * 500
        eyes.run(20)
        assert eyes.way(direction).speed == 500
        assert eyes.way(other).speed == 0
        assert eyes.way(0).speed == eyes.way(1).speed == 0
        outputs(eyes, direction, 1000)
        eyes.run(20)
        assert eyes.way(direction).speed == 910
    assert eyes.o.speed_mm_s() == 0


def test_the_highest_output_since_the_last_turn_counts():
    for direction in range(4):
        for ahead_ms in range(TURN_MS):
            eyes = Eyes()
            eyes.run(ahead_ms)
            outputs(eyes, direction, 500)
            eyes.tick()
            outputs(eyes, direction, 100)
            eyes.tick()
            outputs(eyes, direction, 0)
            eyes.run(10)
            s = eyes.stopping(direction)
            assert eyes.way(direction).speed == s.speed(500)
            assert sum([eyes.way(d).speed for d in range(4)]) == eyes.way(direction).speed


def test_the_speed_that_is_told():
    eyes = Eyes()
    eyes.linear = 600
    eyes.run(20)
    assert eyes.o.speed_mm_s() == 334
    eyes.linear = -1000
    eyes.run(20)
    assert eyes.o.speed_mm_s() == 472
    eyes.linear = 0
    eyes.run(5000)
    assert eyes.o.speed_mm_s() == 0


def test_blocked_bits_block_whatever_the_distance():
    for blocked in range(16):
        eyes = Eyes()
        eyes.i.clearance_blocked = blocked | 0xF0
        eyes.frame()
        eyes.tick()
        assert eyes.o.blocked == blocked
        eyes.run(700)
        assert eyes.o.blocked == blocked
        eyes.i.clearance_blocked = 0
        eyes.run(limits.CLEAR_MS - TURN_MS)
        assert eyes.o.blocked == blocked
        eyes.run(60)
        assert eyes.o.blocked == 0


def test_unseen_bits_allow_creep():
    for direction in range(4):
        eyes = Eyes()
        eyes.i.clearance_unseen = 1 << direction
        eyes.run(2 * TURN_MS)
        assert eyes.decision(direction) == codes.SLOW
        assert eyes.o.caps[direction] == eyes.stopping(direction).permille[0]
        assert sum(eyes.o.caps) == 3000 + eyes.o.caps[direction]
        eyes.set(0, (direction,))
        eyes.run(2 * TURN_MS)
        assert eyes.decision(direction) == codes.BLOCKED
        eyes.set(CLEAR_FAR, (direction,))
        eyes.run(400)
        assert eyes.decision(direction) == codes.SLOW  # up again, to creep and no further
        assert eyes.way(direction).level == 0


def test_bypass_creeps_past_what_blocks_for_20_s():
    for direction in range(4):
        eyes = Eyes()
        eyes.set(0, (direction,))
        eyes.run(40)
        eyes.hold_bypass(1)
        eyes.run(3 * TURN_MS)
        ms = 3 * TURN_MS
        while eyes.o.bypass.left_ms:
            assert eyes.o.caps == [eyes.stopping(d).permille[0] for d in range(4)]
            assert eyes.o.decisions == 0x55 * codes.SLOW
            if ms % 50 == 0:
                eyes.hold_bypass(1)
            eyes.tick()
            ms += 1
            assert ms < limits.BYPASS_MAX_MS
        eyes.run(2 * TURN_MS)
        assert limits.BYPASS_MAX_MS - 50 <= ms + 2 * TURN_MS <= limits.BYPASS_MAX_MS
        assert eyes.decision(direction) == codes.BLOCKED
        assert eyes.decision(1 - direction if direction < 2 else 0) == codes.FREE


def test_bypass_lets_blocked_bits_pass_too_and_ends_with_the_button():
    eyes = Eyes()
    eyes.i.clearance_blocked = 15
    eyes.run(40)
    eyes.hold_bypass(1)
    eyes.run(20)
    assert eyes.o.blocked == 0
    eyes.run(limits.COMMAND_TTL_MS + 2 * TURN_MS)
    assert eyes.o.blocked == 15


def test_bypass_does_not_let_a_fast_chair_pass():
    for direction in range(4):
        eyes = Eyes()
        s = eyes.stopping(direction)
        twice = 2 * s.creep
        for speed, passes in ((twice, True), (twice + 1, False)):
            eyes.way(direction).speed = speed
            eyes.way(direction).level = -1
            eyes.o.bypass.left_ms = 1000
            eyes.o._decide(direction, eyes.way(direction), s)
            assert (eyes.decision(direction) == codes.SLOW) == passes
    eyes = Eyes()
    outputs(eyes, 0, 600)
    eyes.run(20)
    eyes.hold_bypass(1)
    eyes.set(0, (0,))
    eyes.run(20)
    assert eyes.decision(0) == codes.BLOCKED


def test_bypass_ends_when_disarmed():
    eyes = Eyes()
    eyes.set(0)
    eyes.hold_bypass(1)
    eyes.run(40)
    assert eyes.o.blocked == 0
    eyes.armed = False
    eyes.run(2 * TURN_MS)
    assert eyes.o.blocked == 15


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


def test_new_settings_count():
    eyes = Eyes()
    settings = Settings()
    settings.stop_margin_mm = 500
    eyes.set(500, (0,))
    eyes.run(40)
    assert eyes.decision(0) == codes.SLOW
    eyes.o.configure(settings)
    eyes.run(40)
    assert eyes.decision(0) == codes.BLOCKED


def test_looking_often_does_not_lengthen_a_bypass():
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


def test_a_fast_chair_stays_blocked_by_what_a_slow_one_might_pass():
    for direction in range(4):
        eyes = Eyes()
        way = eyes.way(direction)
        s = eyes.stopping(direction)
        way.stop = s.stop(s.full)
        assert s.begin[0] + s.band < way.stop
        for distance, level in ((way.stop + s.band - 1, -1), (way.stop + s.band, 1)):
            way.level = -1
            for _ in range(100):
                way.judge(s, distance, 0, LEVELS)
            assert way.level == -1 if level < 0 else way.level > 0


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


def test_the_smallest_output_counts():
    for direction in range(4):
        eyes = Eyes()
        outputs(eyes, direction, 1)
        eyes.run(20)
        assert [eyes.way(d).speed for d in range(4)] == [int(d == direction) for d in range(4)]


def test_from_blocked_to_creep():
    for direction in range(4):
        eyes = Eyes()
        s = eyes.stopping(direction)
        eyes.set(0, (direction,))
        eyes.run(40)
        eyes.set(s.begin[0] + s.band, (direction,))
        eyes.run(400)
        assert eyes.way(direction).level == 0


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


def test_a_trusted_profile_creeps_as_itself():
    # 120 mm/s of the 361 of 3.1, which turns like the selected 2.1, or of the fastest one's 556.
    for trusted, permille in ((True, 332), (False, 215)):
        settings = Settings()
        settings.profile = 1
        eyes = Eyes(settings)
        eyes.trusted = trusted
        eyes.i.clearance_unseen = 1
        eyes.run(40)
        assert eyes.o.caps[0] == permille


def test_a_way_that_is_only_open_to_creep_is_blocked_when_that_would_be_too_fast():
    # What starts this chair straight on, 330 permille, is 264 mm/s of what it may be.
    settings = Settings()
    settings.p3_1_deadband_permille = 300
    settings.p3_1_forward_mm_s = 800
    eyes = Eyes(settings)
    ahead = 1 << codes.DIR_FORWARD
    assert not eyes.o.blocked & (17 * ahead)
    eyes.i.clearance_unseen = ahead
    eyes.run(40)
    assert eyes.o.caps[codes.DIR_FORWARD] == 0
    assert eyes.o.blocked & (17 * ahead) == 17 * ahead  # blocked, and why
    assert eyes.decision(codes.DIR_FORWARD) == codes.BLOCKED
    eyes.i.clearance_blocked = ahead  # now something is there
    eyes.run(40)
    assert eyes.o.blocked & (17 * ahead) == ahead
    eyes.hold_bypass(1)
    eyes.run(40)
    assert eyes.o.blocked & (17 * ahead) == 17 * ahead  # nor does a bypass let it pass
    eyes.i.clearance_blocked = eyes.i.clearance_unseen = 0
    eyes.run(800)
    assert not eyes.o.blocked & (17 * ahead)


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


def test_a_sluggish_chair_gets_what_starts_its_turns_and_nothing_more():
    settings = Settings()
    settings.profile = 0
    eyes = Eyes(settings)
    eyes.i.clearance_unseen = 15
    eyes.run(40)
    doubted = list(eyes.o.caps)
    assert doubted[2:] == [348, 348]
    eyes.trusted = True
    eyes.run(40)
    trusted = list(eyes.o.caps)
    assert trusted[2:] == [558, 725]
    eyes.trusted = False
    for _ in range(40):
        eyes.o.step(eyes.i, 0, 0, True, False, True)
    assert list(eyes.o.caps) == doubted[:2] + trusted[2:]
