# The caretaker's bypass: held, at most 20 s a press, each press once.

from gazeboard.core import limits
from gazeboard.core.bypass import Bypass
from gazeboard.core.shared import Inputs

PERIOD_MS = 8
EARLY_MS = 32
MOST_MS = limits.BYPASS_MAX_MS - EARLY_MS


class Held:
    # A bypass and its inputs; `number` is said once a turn with `ttl_ms`.

    def __init__(self):
        self.i = Inputs()
        self.i.session_count = 1
        self.bypass = Bypass()
        self.armed = True

    def turn(self, number=None, ttl_ms=300):
        if number is not None:
            self.i.bypass_number = number
            self.i.bypass_ttl_ms = ttl_ms
            self.i.bypass_count = (self.i.bypass_count + 1) & 0xFFFF
        self.bypass.step(self.i, self.armed, PERIOD_MS)
        return self.bypass.left_ms

    def rest(self, ms):
        for _ in range((ms + PERIOD_MS - 1) // PERIOD_MS):
            assert self.turn() == 0


def test_without_a_frame_there_is_no_bypass():
    held = Held()
    assert [held.turn() for _ in range(5)] == [0] * 5


def test_a_press_lasts_20_s_and_never_comes_back():
    held = Held()
    assert held.turn(7) == MOST_MS
    turns = 0
    while held.turn(7):
        turns += 1
        assert turns < 3000
    assert (turns + 1) * PERIOD_MS - MOST_MS in range(PERIOD_MS)
    for _ in range(2000):
        assert held.turn(7) == 0
    assert held.turn(8) == MOST_MS  # a new press


def test_it_ends_when_its_frames_stop():
    for ttl_ms, lasts_ms in ((300, 268), (60000, 268), (100, 68), (41, 9), (40, 8), (33, 1)):
        held = Held()
        assert held.turn(1, ttl_ms) == MOST_MS
        turns = 1
        while held.turn():
            turns += 1
            assert turns < 100
        assert (turns - 1) * PERIOD_MS < lasts_ms <= turns * PERIOD_MS, ttl_ms
        assert held.turn(1) == 0  # the same press said again is over
    for ttl_ms in (0, 1, EARLY_MS):
        assert Held().turn(1, ttl_ms) == 0


def test_refreshed_it_continues_and_its_time_runs():
    held = Held()
    held.turn(1)
    for turn in range(1, 100):
        assert held.turn(1 if turn % 10 == 0 else None) == MOST_MS - turn * PERIOD_MS


def test_releasing_the_button_ends_it():
    held = Held()
    held.turn(1)
    assert held.turn(1, 0) == 0
    assert held.turn(1) == 0


def test_an_old_number_never_counts():
    for newest, old in ((9, 8), (9, 137), (2, 255), (200, 73)):
        held = Held()
        held.turn(newest)
        held.turn(newest, 0)
        assert held.turn(old) == 0
        assert held.turn(newest) == 0
    for newest, ahead in ((8, 9), (9, 136), (255, 1), (250, 3)):
        held = Held()
        held.turn(newest)
        held.turn(newest, 0)
        held.rest(limits.BYPASS_PAUSE_MS)
        assert held.turn(ahead) == MOST_MS, (newest, ahead)


def test_an_old_number_does_not_refresh_a_running_press():
    held = Held()
    held.turn(9)
    turns = 0
    while held.turn(8):
        turns += 1
        assert turns < 100
    assert turns * PERIOD_MS < 300


def test_any_number_may_be_the_first():
    for number in (1, 127, 128, 129, 254, 255):
        held = Held()
        held.turn()
        assert held.turn(0) == 0  # as with the driver's presses: 0 is none
        assert held.turn(number) == MOST_MS
        assert held.turn(0) == MOST_MS - PERIOD_MS
        while held.turn():
            pass
        held.rest(1000)
        assert held.turn(0) == 0
        assert held.turn(number) == 0


def test_a_press_that_began_disarmed_or_was_disarmed_never_counts():
    held = Held()
    held.armed = False
    assert held.turn(3) == 0
    held.armed = True
    assert held.turn(3) == 0
    assert held.turn(4) == MOST_MS
    held.armed = False
    assert held.turn(4) == 0
    held.armed = True
    assert held.turn(4) == 0
    held.rest(2000)
    assert held.turn(4) == 0


def test_a_new_session_ends_it_and_numbers_begin_anew():
    held = Held()
    held.turn(100)
    held.i.session_count = 2
    assert held.turn() == 0
    assert held.turn(98) == 0  # no session makes time: the pause is the board's
    held.rest(2000)
    assert held.turn(99) == MOST_MS
    held.i.session_count = 1  # its count wraps
    assert held.turn() == 0
    held.rest(2000)
    assert held.turn(99) == MOST_MS  # a number of that session, its first


def test_the_last_millisecond_passes_too():
    held = Held()
    held.turn(1)
    held.i.bypass_count += 1
    held.bypass.step(held.i, True, MOST_MS - 1)
    assert held.bypass.left_ms == 1
    assert held.turn(1) == 0


def test_the_count_of_its_frames_wraps():
    held = Held()
    held.i.bypass_count = 0xFFF0
    for _ in range(100):
        left_ms = held.turn(1)
    assert left_ms == MOST_MS - 99 * PERIOD_MS


def test_no_frame_holds_it_longer_than_a_command_may_live():
    held = Held()
    held.turn(1, 60000)
    assert held.bypass._ttl_ms == limits.COMMAND_TTL_MS - EARLY_MS == 268


def test_a_new_number_makes_no_new_time():
    # A host that invents a press each turn, or each 20 s less a little, gets 20 s and a pause.
    for every in (1, 10, 2400):
        held = Held()
        number = 0
        creeping = turns = 0
        while turns < 60_000 // PERIOD_MS:
            if turns % every == 0:
                number = number % 255 + 1
            if held.turn(number):
                creeping += 1
            turns += 1
        assert creeping * PERIOD_MS <= 2 * 20_000 + 5_000, every
        # And while it insists, a pause is no less than half of what it had.
    held = Held()
    assert held.turn(1) == MOST_MS
    assert held.turn(2) == MOST_MS - PERIOD_MS
    assert held.turn(3) == MOST_MS - 2 * PERIOD_MS
    assert held.turn(2) == MOST_MS - 3 * PERIOD_MS


def test_the_pause_is_half_as_long_as_the_bypass_was_and_at_least_a_second():
    for held_ms, pause_ms in ((8, 1000), (1600, 1000), (2400, 1200), (8000, 4000), (30000, 9984)):
        held = Held()
        for _ in range(held_ms // PERIOD_MS):
            held.turn(1)
        held.turn(1, 0)
        paused = 0
        while True:
            paused += PERIOD_MS
            again = Held()
            again.bypass._pause_ms = held.bypass._pause_ms
            again.bypass._number = 1
            if again.turn(2):
                break
            assert held.turn() == 0
            assert paused < 20_000
        # What was left of it when it had run out by itself is part of the pause.
        most = pause_ms + 2 * PERIOD_MS
        assert (held_ms == 30000 and paused <= most) or pause_ms <= paused <= most


def test_a_press_in_the_pause_is_spent():
    held = Held()
    held.turn(1)
    held.turn(1, 0)
    assert held.turn(2) == 0
    for _ in range(300):
        assert held.turn(2) == 0  # held on, it does not begin by itself
    assert held.turn(3) == MOST_MS


# Whether a new press counts so many turns of elapsed_ms after a short one was let go.
def counts_after(turns, elapsed_ms):
    held = Held()
    held.turn(1)
    assert held.turn(1, 0) == 0
    for turn in range(turns):
        if turn == turns - 1:
            held.i.bypass_number = 2
            held.i.bypass_ttl_ms = 300
            held.i.bypass_count += 1
        held.bypass.step(held.i, True, elapsed_ms)
    return held.bypass.left_ms == MOST_MS


def test_the_pause_ends_in_its_millisecond():
    assert not counts_after(124, 8)
    assert counts_after(125, 8)
    assert not counts_after(111, 9)
    for later in (112, 113, 500):
        assert counts_after(later, 9)


def test_a_number_is_ahead_by_at_most_half_of_them():
    for ahead, counts in ((127, True), (128, False), (129, False), (255, False)):
        held = Held()
        held.turn(10)
        held.turn(10, 0)
        held.rest(1000)
        assert (held.turn((10 + ahead) & 255) == MOST_MS) is counts, ahead
