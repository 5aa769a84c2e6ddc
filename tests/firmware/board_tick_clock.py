# The ticks' pace: what is counted as missed, when it is a stall, and that it allocates nothing.

from boardtest import no_allocation
from gazeboard.core import limits
from gazeboard.core.tick_clock import TickClock


def counted(gaps):
    clock = TickClock()
    return [clock.step(gap) for gap in gaps], clock


def test_ticks_in_time_owe_nothing():
    missed, clock = counted([1000] * 50)
    assert missed == [0] * 50
    assert not clock.late
    assert not clock.owes


def test_whole_milliseconds_are_counted_and_the_rest_is_kept():
    missed, clock = counted([1400, 1400, 1400, 2000, 5999])
    assert missed == [0, 0, 1, 1, 5]
    assert clock.owes


def test_ticks_in_quick_succession_take_nothing_back():
    missed, _ = counted([6000, 0, 0, 0, 0, 0, 3000])
    assert missed == [5, 0, 0, 0, 0, 0, 2]


def test_a_stall_and_a_slow_pace_are_late_until_made_up_for():
    for gap, ticks in ((limits.TICK_STALLED_US + 1, 1), (10000, 2), (2000, 11), (1061, 910)):
        _missed, clock = counted([gap] * ticks)
        assert clock.late, gap
        assert not counted([gap] * (ticks - 1))[1].late, gap
        clock.step(1000)
        clock.behind_us = 1
        clock.step(1000)
        assert not clock.late


def test_five_percent_is_never_late():
    _, clock = counted([1050] * 5000)
    assert not clock.late


def test_a_gap_beyond_the_clocks_half_is_late():
    for gap in (-1, -(1 << 29), (1 << 29) - 1):
        missed, clock = counted([gap])
        assert clock.late
        assert missed[0] >= 999
        assert clock.behind_us <= 2 * limits.TICK_BEHIND_US


def test_it_allocates_nothing():
    clock = TickClock()

    def run():
        for gap in (1000, 1400, 3, 30000, -5, 1 << 29):
            clock.step(gap)

    no_allocation(run)
