# The profile check at its edges: a model whose rate is set by hand, one heading sample in ten ms.

from gazeboard.core import limits
from gazeboard.core.profile_check import ProfileCheck
from gazeboard.core.shared import Inputs

JUDGED = 5  # the tick, from the sample's own on, in which a sample is judged
ON = 400  # q4: what the model turns
AGREED = 30  # samples


class Model:
    def __init__(self, dead_ms=0):
        self.dead_ms = dead_ms
        self.rate_q10 = ON << 6
        self.is_steady = True

    def seen_rate(self):
        return self.rate_q10

    def steady(self):
        return self.is_steady


class Bench:
    def __init__(self, dead_ms=0, count=0):
        self.model = Model(dead_ms)
        self.check = ProfileCheck(self.model)
        self.i = Inputs()
        self.i.heading_count = count
        self.turn = 500
        self.linear = 600

    def ticks(self, count):
        for _ in range(count):
            self.check.step(self.i, self.linear, self.turn)

    # Heading samples; ends with the tick in which the last one is judged.
    def samples(self, count, rate_q4=ON):
        for _ in range(count):
            self.ticks(10 - JUDGED)
            self.i.rate_q4 = rate_q4
            self.i.heading_count = (self.i.heading_count + 1) & 0xFFFF
            self.ticks(JUDGED)
        return self.check

    # Ticks until neither is said any more.
    def lapses(self):
        ticks = 0
        while self.check.agreed or self.check.sluggish:
            self.ticks(1)
            ticks += 1
        return ticks

    def put_out(self, linear, turn):
        self.linear = linear
        self.turn = turn


# Trusted, by the sample judged just now.
def trusting(dead_ms=0):
    bench = Bench(dead_ms)
    bench.samples(1, 0)
    bench.samples(AGREED - 1)
    assert not bench.check.agreed
    assert bench.samples(1).agreed
    return bench


def test_the_first_sample_counts_whatever_its_number():
    for number in (0, 1, 2, 65535):
        bench = Bench(0, number)
        bench.i.rate_q4 = ON
        bench.ticks(JUDGED)
        assert not bench.samples(AGREED - 2).agreed
        bench.ticks(10 - JUDGED)
        bench.i.heading_count -= 20000  # another number, though a lower one
        bench.ticks(JUDGED - 1)
        assert not bench.check.agreed
        bench.ticks(1)
        assert bench.check.agreed, number


def test_a_steady_turn_counts_once_it_lasts_longer_than_the_dead_time():
    for dead_ms, early in ((9, 0), (10, 1), (19, 1), (20, 2), (500, 50)):
        bench = Bench(dead_ms, 65535)
        bench.i.rate_q4 = ON
        bench.ticks(JUDGED)
        bench.samples(max(0, early + AGREED - 2))
        assert not bench.check.agreed, dead_ms
        assert bench.samples(1).agreed, dead_ms
        # And anew after a sample of a turn that is not.
        bench.model.is_steady = False
        bench.samples(1)
        bench.model.is_steady = True
        bench.linear = 0
        bench.check.agreed = False
        assert not bench.samples(early + AGREED - 1).agreed, dead_ms
        assert bench.samples(1).agreed, dead_ms


def test_the_rate_agrees_within_a_quarter_and_the_model_must_turn():
    for model_q10, seen_q4, agrees in (
        (6400, 125, True),
        (6400, 126, False),
        (6400, 75, True),
        (6400, 74, False),
        (-6400, -125, True),
        (-6400, -126, False),
        (-6400, 125, False),
        (6144, 96, False),
        (6145, 96, True),
        (-6145, -96, True),
    ):
        bench = Bench()
        bench.model.rate_q10 = model_q10
        bench.turn = 500 if model_q10 > 0 else -500
        assert bench.samples(AGREED + 1, seen_q4).agreed == agrees, (model_q10, seen_q4)


def test_what_is_half_as_fast_again_and_8_degrees_a_second_contradicts():
    for model_q10, seen_q4, contradicts in (
        (0, 128, False),
        (0, 129, True),
        (0, -128, False),
        (0, -129, True),
        (42, 129, True),  # 42 + 21 + 8192 = 129 * 64 - 1
        (43, 129, False),
        (-42, -129, True),
        (-44, -129, False),
        (-1, -128, False),
        (-1, 128, False),
        (6400, 278, False),
        (6400, 279, True),
        (6400, -279, True),
    ):
        bench = trusting()
        bench.model.is_steady = False
        bench.model.rate_q10 = model_q10
        assert bench.samples(19, seen_q4).agreed
        assert bench.samples(1, seen_q4).agreed != contradicts, (model_q10, seen_q4)


def test_twenty_samples_contradict_and_one_that_agrees_between_makes_it_twenty_anew():
    bench = trusting()
    bench.samples(19, 3 * ON)
    bench.samples(1)
    assert bench.samples(19, 3 * ON).agreed
    assert not bench.samples(1, 3 * ON).agreed
    # Nothing is forgotten by what says nothing.
    bench = trusting()
    bench.samples(19, 3 * ON)
    bench.turn = 0
    bench.samples(5, 0)
    assert not bench.samples(1, 3 * ON).agreed


def test_what_contradicts_interrupts_the_agreement():
    bench = Bench()
    bench.samples(AGREED - 1)
    bench.samples(1, 3 * ON)
    assert not bench.samples(AGREED - 1).agreed
    assert bench.samples(1).agreed


def test_trust_lasts_from_the_sample_that_completed_the_agreement():
    bench = trusting()
    bench.put_out(600, 0)
    assert bench.lapses() == limits.TRUST_MS
    # The next that completes it comes after as many again.
    bench = trusting()
    bench.samples(AGREED - 1)
    bench.put_out(600, 0)
    assert bench.lapses() == limits.TRUST_MS - 10 * (AGREED - 1)
    bench = trusting()
    bench.samples(AGREED)
    bench.put_out(600, 0)
    assert bench.lapses() == limits.TRUST_MS


def test_trust_begins_anew_to_lapse_at_rest():
    for linear, turn in ((0, 0), (149, -149)):
        bench = trusting()
        for _ in range(2):
            bench.put_out(linear, turn)
            assert bench.lapses() == limits.TRUST_STANDING_MS
            bench.put_out(600, 500)
            bench.samples(AGREED)
            assert bench.check.agreed


def test_a_turn_in_which_trust_lapses_has_to_confirm_it_from_its_beginning():
    bench = trusting()
    bench.put_out(600, 0)
    bench.ticks(limits.TRUST_MS - 205)
    bench.put_out(600, 500)
    bench.samples(20)
    assert bench.check.agreed
    bench.samples(AGREED - 1)
    assert not bench.check.agreed
    assert bench.samples(1).agreed


def test_trust_that_was_contradicted_lapses_no_more():
    bench = trusting()
    bench.samples(20, 3 * ON)
    assert not bench.check.agreed
    bench.put_out(600, 0)
    bench.ticks(limits.TRUST_MS - 400)
    bench.put_out(600, 500)
    bench.samples(AGREED - 1)
    assert not bench.check.agreed
    assert bench.samples(1).agreed


STUCK = limits.TRYING_MS // 10  # samples


def stuck():
    bench = Bench()
    bench.model.is_steady = False
    bench.model.rate_q10 = 0
    bench.put_out(0, 0)
    bench.ticks(10)
    bench.put_out(0, 300)
    return bench


def test_a_chair_stands_below_one_and_a_half_degrees_a_second():
    for rate_q4, sluggish in ((23, True), (-23, True), (24, False), (-24, False)):
        bench = stuck()
        assert not bench.samples(STUCK - 1, rate_q4).sluggish
        assert bench.samples(1, rate_q4).sluggish == sluggish, rate_q4


def test_sluggish_takes_one_attempt_of_its_full_length():
    for interrupt in ("output", "rate", "fault"):
        bench = stuck()
        bench.i.heading_count = 65000
        bench.samples(STUCK - 2)
        if interrupt == "output":
            bench.turn = -299
            bench.samples(1, 0)
        elif interrupt == "rate":
            bench.samples(1, 24)
        else:
            bench.i.heading_faults = 1
            bench.samples(1, 0)
            bench.i.heading_faults = 0
        bench.turn = -300
        assert not bench.samples(STUCK - 1, 0).sluggish, interrupt
        assert bench.samples(1, 0).sluggish, interrupt


def test_sluggish_lapses_like_trust_from_its_first_moment_on():
    bench = stuck()
    bench.samples(STUCK, 0)
    bench.put_out(600, 300)
    assert bench.lapses() == limits.TRUST_MS
    # It may stand at once: what stood before it does not count.
    bench = trusting()
    bench.put_out(0, 0)
    bench.lapses()
    bench.model.rate_q10 = 0
    bench.put_out(0, 300)
    bench.samples(STUCK, 0)
    bench.put_out(0, 0)
    assert bench.lapses() == limits.TRUST_STANDING_MS
    bench.samples(1, 0)
    bench.put_out(0, 300)
    assert not bench.samples(STUCK - 1, 0).sluggish
    assert bench.samples(1, 0).sluggish


def test_trust_after_a_rest_stands_in_full_though_the_chair_rests_at_once():
    bench = trusting()
    bench.put_out(0, 0)
    assert bench.lapses() == limits.TRUST_STANDING_MS
    bench.put_out(0, 500)
    bench.samples(AGREED)
    bench.put_out(0, 0)
    assert bench.lapses() == limits.TRUST_STANDING_MS


def test_the_model_s_rate_is_the_one_at_the_sample():
    bench = Bench()
    bench.samples(1, 0)
    for _ in range(AGREED):
        assert not bench.check.agreed
        bench.model.rate_q10 = 0
        bench.ticks(10 - JUDGED)
        bench.i.heading_count += 1
        bench.i.rate_q4 = ON
        bench.ticks(1)
        bench.model.rate_q10 = ON << 6
        bench.ticks(1)
        bench.model.rate_q10 = 0
        bench.ticks(JUDGED - 2)
    assert bench.check.agreed


def test_a_turn_of_less_than_450_permille_or_a_faulty_heading_tells_nothing():
    for turn, fault, agrees in ((449, 0, 0), (-449, 0, 0), (450, 0, 1), (-450, 0, 1), (450, 1, 0)):
        bench = Bench()
        bench.turn = turn
        bench.i.heading_faults = fault
        assert bench.samples(AGREED).agreed == bool(agrees), turn
    bench = trusting()
    bench.i.heading_faults = 1
    assert bench.samples(AGREED, 3 * ON).agreed


def test_an_agreement_is_of_one_turn():
    bench = Bench()
    bench.samples(AGREED - 1)
    bench.turn = 449
    bench.samples(1)
    bench.turn = 450
    assert not bench.samples(AGREED - 1).agreed
    assert bench.samples(1).agreed


def test_a_steady_turn_beyond_a_quarter_contradicts():
    for rate_q4 in (ON + 101, ON - 101):
        bench = trusting()
        assert bench.samples(19, rate_q4).agreed
        assert not bench.samples(1, rate_q4).agreed


def test_standing_is_less_than_150_permille_of_both_for_three_seconds_in_one():
    for linear, turn in ((150, 0), (-150, 0), (0, 150), (0, -150)):
        bench = trusting()
        for _ in range(2):
            bench.put_out(0, 0)
            bench.ticks(limits.TRUST_STANDING_MS - 1)
            assert bench.check.agreed
            bench.put_out(linear, turn)
            bench.ticks(1)
            assert bench.check.agreed
        bench.put_out(0, 0)
        assert bench.lapses() == limits.TRUST_STANDING_MS


def test_from_the_very_first_sample_on_it_may_be_sluggish_or_contradict_that():
    bench = Bench()
    bench.model.is_steady = False
    bench.model.rate_q10 = 0
    bench.put_out(600, 300)
    bench.ticks(JUDGED)
    assert not bench.samples(STUCK - 2, 0).sluggish
    assert bench.samples(1, 0).sluggish
    assert bench.samples(19, 200).sluggish
    assert not bench.samples(1, 200).sluggish
