# P21: the chair turns otherwise than it is told, seen by the gyro. False alarms against the twin
# are in test_obedience_twin.py.

from gazeboard.core import limits
from gazeboard.core.obedience import Obedience
from gazeboard.core.shared import Inputs
from gazeboard.io.settings import Settings

FULL_Q4 = 910  # of the fastest profile
MOVING = limits.OBEY_MOVING_Q4_DPS
STANDING = limits.OBEY_STANDING_Q4_DPS


class Watched:
    # One ms a step, a heading sample every ten.

    def __init__(self, settings=None):
        self.i = Inputs()
        self.watch = Obedience(settings or Settings())
        self.armed = True
        self.ms = 0

    # ms until it trips; None: not within `ms`.
    def run(self, ms, rate_q4=0, turn=0, linear=0):
        for passed in range(ms):
            self.ms += 1
            if self.ms % 10 == 0:
                self.i.heading_count = (self.i.heading_count + 1) & 0xFFFF
                self.i.rate_q4 = rate_q4
            if self.watch.step(self.i, linear, turn, self.armed):
                return passed + 1
        return None


def test_turning_on_with_neutral_put_out_trips():
    for sign in (1, -1):
        watched = Watched()
        assert watched.run(3000, sign * FULL_Q4, sign * 1000) is None
        ms = watched.run(4000, sign * FULL_Q4)
        assert 1000 < ms <= limits.OBEYS_MS
        # As slow as a slow profile turns: once it must have coasted out.
        watched = Watched()
        assert watched.run(3000, sign * 273, sign * 1000) is None
        ms = watched.run(4000, sign * 273)
        assert 1500 < ms <= limits.OBEYS_MS
        watched = Watched()
        assert watched.run(3000, 0, sign * 1000) is None
        ms = watched.run(4000, sign * (STANDING + 1))
        assert limits.OBEY_COAST_MS < ms <= limits.OBEYS_MS
        watched = Watched()
        assert watched.run(10000, sign * STANDING) is None


def test_turning_against_the_command_trips():
    for sign in (1, -1):
        watched = Watched()
        ms = watched.run(3000, sign * FULL_Q4, -sign * 500)
        assert limits.OBEY_MS < ms <= limits.OBEYS_MS
        assert Watched().run(10000, sign * MOVING, -sign * 500) is None
        assert Watched().run(3000, sign * (MOVING + 1), -sign * 500) is not None
        # A reversal: it may go on as it went for as long as a chair coasts.
        watched = Watched()
        watched.run(2000, sign * FULL_Q4, sign * 1000)
        ms = watched.run(4000, sign * FULL_Q4, -sign * 1000)
        assert 1000 < ms <= limits.OBEYS_MS


def test_turning_while_it_drives_straight_on_trips():
    for linear in (600, -600):
        watched = Watched()
        assert watched.run(5000, MOVING, 0, linear) is None
        assert limits.OBEY_MS < watched.run(1000, FULL_Q4, 0, linear) <= limits.OBEY_MS + 30


def test_turning_as_commanded_is_obedience():
    for turn in (1000, 500, 300, -300, -1000):
        for linear in (0, 600):
            watched = Watched()
            assert watched.run(20000, FULL_Q4 * 5 // 4 * turn // 1000, turn, linear) is None


def test_coasting_is_obedience():
    # Down from full in 1.5 s after 0.3 s, and the moving limit above that.
    watched = Watched()
    watched.run(2000, FULL_Q4, 1000)
    rate = FULL_Q4 * 5 // 4
    for k in range(300):
        fallen = max(0, k * 10 - limits.OBEY_HOLD_MS) * rate // limits.OBEY_FALL_MS
        assert watched.run(10, max(STANDING, rate - fallen), 0) is None
    # A small output before it stands does not start that again from full.
    watched = Watched()
    watched.run(2000, FULL_Q4, 1000)
    watched.run(1000, FULL_Q4, 0)
    ms = watched.run(3000, FULL_Q4, 200)
    assert ms <= 1000


def test_a_short_or_alternating_turn_is_no_disobedience():
    watched = Watched()
    for _ in range(40):
        assert watched.run(490, 1500) is None  # a bump
        assert watched.run(20, 0) is None
        assert watched.run(490, 1500) is None  # a spasm that shakes the chair
        assert watched.run(490, -1500) is None


def test_disarmed_nothing_counts():
    watched = Watched()
    watched.armed = False
    assert watched.run(20000, 2000) is None
    watched.armed = True
    # By hand until now: it may take as long as coasting to stand.
    assert watched.run(limits.OBEY_COAST_MS, MOVING) is None
    assert watched.run(600, MOVING) is not None


def test_a_faulty_heading_is_no_evidence():
    watched = Watched()
    watched.i.heading_faults = 1
    assert watched.run(20000, 2000) is None
    watched.i.heading_faults = 0
    assert limits.OBEY_MS - 10 <= watched.run(2000, 2000) <= limits.OBEY_MS + 20


def test_a_faster_chair_may_turn_faster():
    settings = Settings()
    settings.p2_1_right_q4_dps = 1800
    watched = Watched(settings)
    assert watched.run(5000, 1800 * 5 // 4, 1000) is None
    watched = Watched(settings)
    settings.p2_1_right_q4_dps = 80
    watched.watch.configure(settings)
    assert watched.run(5000, FULL_Q4 * 5 // 4 + MOVING, 1000) is None
    assert watched.run(5000, FULL_Q4 * 5 // 4 + MOVING + 1, 1000) is not None


def wiper_trips_at(pattern, limit):
    watch = Obedience(Settings())
    for k in range(limit):
        verified = pattern[k % len(pattern)] == "g"
        if (not verified or watch.wiper_debt) and watch.wipers_written(verified):
            return k + 1
    return None


def test_two_of_three_writes_that_fail_for_a_second_are_a_fault():
    assert 800 <= wiper_trips_at("bbg", 2000) <= 1000
    assert 800 <= wiper_trips_at("bgb", 2000) <= 1000
    assert wiper_trips_at("bg", 20000) is None
    assert wiper_trips_at("bbggg", 20000) is None
    assert wiper_trips_at("g", 2000) is None
    assert wiper_trips_at("bbg" * 200 + "g" * 400, 20000) is None
