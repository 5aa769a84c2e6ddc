# The profile check: believes the selected profile only after steady turning that fits it.

from gazeboard.chair_model import ChairModel
from gazeboard.profile_check import ProfileCheck
from gazeboard.settings import Settings
from gazeboard.shared import Inputs
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

    def run(self, permille, ms):
        for _ in range(ms):
            self.ms += 1
            self.model.step(permille)
            self.chair.step(permille)
            if self.ms % 10 == 0:
                self.i.heading_count = (self.i.heading_count + 1) & 0xFFFF
                self.i.rate_q4 = self.chair.seen_rate() >> 6
            self.check.step(self.i)
        return self.check.agreed


def test_it_believes_nothing_at_first_and_nothing_at_rest():
    turning = Turning(2, 2)
    assert not turning.check.agreed
    assert not turning.run(0, 5000)


def test_steady_turning_as_the_profile_says_is_believed():
    for profile in range(5):
        for permille in (500, -1000):
            turning = Turning(profile, profile)
            assert not turning.run(permille, 300), "too early"
            assert turning.run(permille, 3200), (profile, permille)
            assert turning.run(0, 1000), "rest contradicts nothing"


def test_another_profile_is_never_believed():
    for believed, real, permille in ((0, 2, 500), (1, 3, -1000), (4, 0, -500), (3, 1, 1000)):
        turning = Turning(believed, real)
        for _ in range(20):
            assert not turning.run(permille, 100), (believed, real)


def test_ramps_alone_say_nothing():
    turning = Turning(4, 4)
    for _ in range(4):
        turning.run(1000, 250)
        assert not turning.run(0, 1000)


def test_what_was_believed_is_contradicted_by_a_change_of_profile():
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
    turning.check.step(turning.i)
    turning.check.step(turning.i)
    assert turning.check.agreed


def test_a_faulty_heading_is_no_evidence():
    turning = Turning(2, 2)
    turning.i.heading_faults = 1 << codes.HEADING_FROZEN
    assert not turning.run(500, 3000)
