# The profile check: believes the selected profile only after steady turning that fits it.

from gazeboard.core import limits
from gazeboard.core.profile_check import ProfileCheck
from gazeboard.core.shared import Inputs
from gazeboard.io.settings import Settings
from gazeboard.turning.chair_model import ChairModel
from gazelink import codes


class Turning:
    # The board believes profile `believed`; the chair turns as the model of `real` does.

    def __init__(self, believed, real):
        settings = Settings()
        settings.profile = believed
        self.model = ChairModel(settings)
        settings = Settings()
        settings.profile = real
        self.chair = ChairModel(settings)
        self.check = ProfileCheck(self.model)
        self.i = Inputs()
        self.ms = 0

    # `linear`: what is put out besides; `seen` False: no new heading comes.
    def run(self, permille, ms, linear=0, seen=True):
        for _ in range(ms):
            self.ms += 1
            self.model.step(permille)
            self.chair.step(permille)
            if self.ms % 10 == 0 and seen:
                self.i.heading_count = (self.i.heading_count + 1) & 0xFFFF
                self.i.rate_q4 = self.chair.seen_rate() >> 6
            self.check.step(self.i, linear, permille)
        return self.check.agreed


def test_it_trusts_nothing_at_first_and_nothing_at_rest():
    turning = Turning(2, 2)
    assert not turning.check.agreed
    assert not turning.run(0, 5000)


def test_steady_turning_as_the_profile_predicts_is_trusted():
    for profile in range(5):
        for permille in (500, -1000):
            turning = Turning(profile, profile)
            assert not turning.run(permille, 300), "too early"
            assert turning.run(permille, 3200), (profile, permille)
            assert turning.run(0, 1000), "rest contradicts nothing"


def test_another_profile_is_never_trusted():
    for believed, real, permille in ((0, 2, 500), (1, 3, -1000), (4, 0, -500), (3, 1, 1000)):
        turning = Turning(believed, real)
        for _ in range(20):
            assert not turning.run(permille, 100), (believed, real)


def test_ramps_alone_confirm_nothing():
    turning = Turning(4, 4)
    for _ in range(4):
        turning.run(1000, 250)
        assert not turning.run(0, 1000)


def test_a_change_of_profile_contradicts_a_trusted_one():
    turning = Turning(1, 1)
    assert turning.run(500, 2500)
    settings = Settings()
    settings.profile = 4
    turning.chair = ChairModel(settings)
    turning.run(0, 1000)
    assert turning.check.agreed
    assert not turning.run(1000, 2500)


def test_one_bad_sample_contradicts_nothing():
    turning = Turning(2, 2)
    turning.run(500, 2500)
    turning.i.rate_q4 = 3000
    turning.i.heading_count += 1
    turning.check.step(turning.i, 0, 500)
    turning.check.step(turning.i, 0, 500)
    assert turning.check.agreed


def test_a_faulty_heading_is_no_evidence():
    turning = Turning(2, 2)
    turning.i.heading_faults = 1 << codes.HEADING_FROZEN
    assert not turning.run(500, 3000)


def trusting(profile=1, permille=600):
    turning = Turning(profile, profile)
    assert turning.run(permille, 3000)
    return turning


# ms until it is no longer trusted
def lapses(turning, permille, limit_ms, linear=0, seen=True):
    for ms in range(limit_ms):
        if not turning.run(permille, 1, linear, seen):
            return ms + 1
    raise AssertionError("trusted for %d ms" % limit_ms)


def test_trust_lapses_when_the_chair_has_stood_for_some_seconds():
    for linear, permille in ((0, 0), (149, 0), (-149, -149), (0, 149)):
        turning = trusting()
        assert lapses(turning, permille, 5000, linear) == limits.TRUST_STANDING_MS == 3000
    turning = trusting()
    for _ in range(5):
        assert turning.run(0, 2900)
        assert turning.run(0, 1, 600)  # it drove in between
    assert lapses(turning, 0, 5000) == 3000


def test_trust_lapses_half_a_minute_after_the_last_turn_that_confirmed_it():
    for linear in (150, -600):
        for seen in (True, False):  # whether or not the heading sensor lives
            turning = trusting()
            ms = lapses(turning, 0, 31000, linear, seen)
            assert limits.TRUST_MS - 310 <= ms <= limits.TRUST_MS == 30000
    turning = trusting()
    for _ in range(3):
        assert turning.run(0, 25000, 600)
        assert turning.run(600, 2000, 600)
    assert lapses(turning, 0, 31000, 600) > 29000


def test_a_knob_turned_while_it_stands_or_drives_is_not_trusted_for_long():
    # Trusted in 1.2, then 5.1: the chair stands, or drives on straight ahead.
    for linear, within_ms in ((0, 3000), (600, 30000)):
        turning = trusting(0, 1000)
        settings = Settings()
        settings.profile = 4
        turning.chair = ChairModel(settings)
        assert lapses(turning, 0, within_ms + 1, linear) <= within_ms
        assert not turning.run(0, 40000, 600)


def test_a_turn_of_too_little_output_confirms_nothing():
    for permille, believed in ((449, False), (450, True), (-449, False), (-450, True)):
        assert Turning(3, 3).run(permille, 4000) == believed, permille


def test_agreement_is_of_one_turn():
    turning = Turning(3, 3)
    # 1.9 s until it is steady and seen to be, then a little less than it takes.
    steady_ms = 0
    while not turning.run(600, 1):
        steady_ms += 1
    for _ in range(4):
        turning = Turning(3, 3)
        for _ in range(4):
            assert not turning.run(600, steady_ms - 100)
            assert not turning.run(0, 2000)


def test_a_chair_that_stands_under_what_would_turn_a_quick_one_is_sluggish():
    for permille, sluggish in ((348, True), (-348, True), (300, True), (299, False)):
        turning = Turning(0, 0)
        turning.run(permille, 1400)
        assert not turning.check.sluggish
        turning.run(permille, 400)
        assert turning.check.sluggish == sluggish, permille
        assert not turning.check.agreed  # nothing is known of how fast it goes
        turning.run(0, 2900)
        assert turning.check.sluggish == sluggish
        turning.run(0, 200)
        assert not turning.check.sluggish
    for quick in (1, 2, 3, 4):
        turning = Turning(0, quick)
        turning.run(348, 4000)
        assert not turning.check.sluggish, quick
    turning = Turning(0, 0)
    turning.i.heading_faults = 1
    turning.run(348, 4000)
    assert not turning.check.sluggish
    # It was only stuck: what it turns then is no sluggish chair's.
    turning = Turning(0, 0)
    turning.run(348, 2000)
    settings = Settings()
    settings.profile = 4
    turning.chair = ChairModel(settings)
    assert turning.check.sluggish
    turning.run(558, 1200)
    assert not turning.check.sluggish
