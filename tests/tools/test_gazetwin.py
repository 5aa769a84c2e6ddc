"""The chair's twin still turns as was published about the first prototype."""

import pytest

from gazesim.profiles import PROFILES, identified, least_sticky
from gazetwin.clues import CLUES, match
from gazetwin.experiment import Trace
from gazetwin.prototype import FITTED, MILLISECOND, PUBLISHED, READINGS, Gains, Prototype, Reading


@pytest.mark.parametrize("chair", [identified, least_sticky])
def test_every_published_clue_holds_on_the_identified_chairs(chair):
    found = match(chair("4.1").turn, FITTED)
    missed = {key: value for key, value in found.found.items() if CLUES[key].miss(value)}
    assert missed == {}
    assert found.holds()


def test_the_identified_chair_has_every_profile_with_its_speeds():
    for profile, chair in PROFILES.items():
        turn = identified(profile).turn
        assert (turn.positive, turn.negative) == (chair.turn.positive, chair.turn.negative)
        assert turn.stiction == identified("4.1").turn.stiction


def test_gains_per_second_can_not_explain_the_published_convergence():
    per_second = READINGS[2]
    found = match(identified("4.1").turn, per_second)
    assert CLUES["settled"].miss(found.found["settled"]) > 0
    assert CLUES["unstable"].miss(found.found["unstable"]) > 0


def test_the_prototype_puts_out_what_was_published():
    reading = READINGS[1]
    controller = Prototype(reading, Gains(6.0, 0.0, 0.0), 10.0)
    assert controller.update(0.0) == 230
    assert controller.update(10.0) == 170
    assert controller.update(-90.0) == 254
    assert controller.update(90.0) == 85


def test_within_the_cutoff_it_asks_for_neutral():
    controller = Prototype(READINGS[1], PUBLISHED, 10.0, cutoff_deg=2.0)
    assert controller.update(8.1) == 170
    assert controller.update(7.9) > 180


def test_the_sum_grows_by_the_reading_of_ki():
    for reading, factor in zip(READINGS[:3], (1.0, 1.0, 0.01), strict=True):
        controller = Prototype(reading, Gains(0.0, 1.0, 0.0), 10.0)
        assert controller.update(0.0) == 170 + round(10.0 * factor)
    by_ms = Reading("per ms", 100, MILLISECOND, MILLISECOND)
    assert (by_ms.ki_factor(), by_ms.kd_factor()) == (10.0, 0.1)


def test_what_is_read_from_a_turn():
    trace = Trace(10.0, [0.0] * 100 + [12.0] * 100 + [8.0] * 100 + [10.5] * 100)
    assert trace.first_crossing_s() == 1.0
    assert trace.overshoot_deg() == 2.0
    assert trace.error_deg(2.5) == 2.0
    assert trace.settled_s(1.0) == 3.0
    assert trace.settled_s(0.1) == float("inf")
    assert trace.swings(0.0, 1.0) == 2
    assert Trace(10.0, [0.0] * 10).first_crossing_s() == float("inf")
