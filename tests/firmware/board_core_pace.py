# The ticks' pace at every edge, against the same rule in plain numbers.

from gazeboard.core.tick_clock import TickClock


# (ms missed, late, owes, behind) of each tick.
def by_rule(gaps):
    behind = 0
    owed = 0
    for gap in gaps:
        passed = gap if 0 <= gap <= 1000000 else 1000000
        behind = min(20000, max(0, behind + passed - 1050))
        owed = max(0, owed + passed - 1000)
        missed = owed // 1000
        owed -= 1000 * missed
        yield missed, passed > 20000 or behind > 10000, behind > 0 or owed > 0, behind


def by_clock(gaps):
    clock = TickClock()
    for gap in gaps:
        missed = clock.step(gap)
        yield missed, clock.late, clock.owes, clock.behind_us


GAPS = (
    (1000, 1001, 1049, 1050, 1051, 999, 950, 900),
    (1050, 1051, 1050, 1049, 1000, 1000),
    (20000, 20001, 0, 0, 0, 0),
    (20001,),
    (20000,),
    (11049, 1051, 1051, 1050, 1049),
    (11050, 1051, 1051),
    (11051, 1050, 1049, 1051),
    (40000, 1000, 1049, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1051),
    (-1, 1000),
    (0, 1, 1999, 2000, 2001),
    (1000000, 1000001, 999999, 1000),
    (1 << 29, -(1 << 29)),
    (1001, 1001, 1001, 996, 1001, 1000),
    (1999, 1, 1999, 1001),
    (1999, 1001, 1999, 1001, 2000),
    (1003, 0, 1001, 1999, 1998),
    (2000, 101),
    (2000, 100),
)


def test_every_edge_is_as_the_rule_says():
    for gaps in GAPS:
        assert list(by_clock(gaps)) == list(by_rule(gaps)), gaps


def test_before_the_first_tick_it_is_in_time():
    clock = TickClock()
    assert (clock.late, clock.owes, clock.behind_us) == (False, False, 0)


def test_many_ticks_of_every_length_are_as_the_rule_says():
    gaps = []
    state = 1
    for _ in range(3000):
        state = (state * 1103515245 + 12345) & 0x7FFFFFFF
        gaps.append((1000, 1040, 1060, 1100, 700, 5000, 12000)[(state >> 12) % 7])
    assert list(by_clock(gaps)) == list(by_rule(gaps))
