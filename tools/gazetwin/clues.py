"""Clues: what was published about the first prototype's turns, and the twin's value for each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from gazesim.chair_axis import Axis
from gazesim.profiles import PROFILES
from gazetwin.experiment import ANGLE_DEG, CUTOFF_DEG, Trace, run
from gazetwin.prototype import PUBLISHED, Gains, Reading

TENTH_DEG = 0.1 * ANGLE_DEG
LONG_S = 60.0
_PD = replace(PUBLISHED, ki=0.0)
_WORKING = (Gains(4.0, 0.0005, 1.0), Gains(4.0, 0.0005, 2.0), Gains(6.0, 0.0005, 2.0))


@dataclass(frozen=True)
class Clue:
    """One published statement as a range: it holds when the value is within it."""

    key: str
    published: str
    unit: str
    low: float
    high: float
    scale: float
    """A miss by this much costs 1."""

    def miss(self, value: float) -> float:
        """How far `value` is outside, in scales; at most 3."""
        outside = max(self.low - value, value - self.high, 0.0)
        return min(3.0, outside / self.scale)


CLUES = {
    clue.key: clue
    for clue in (
        Clue("crossing", "A: first crossing at 1.2 s", "s", 1.1, 1.3, 0.1),
        Clue("overshoot", "A: large overshoot (taken as 3 deg or more)", "deg", 3.0, 10.0, 1.0),
        Clue("left", "A: about 2 deg left at 33 s", "deg", 1.5, 2.5, 0.5),
        Clue("settled", "B: 25-30 s to within 10 %", "s", 25.0, 30.0, 5.0),
        Clue("pd", "PD never converges: deg left after 60 s", "deg", TENTH_DEG, 10.0, 0.5),
        Clue("calm", "Ki 0.0005 is stable: swings in 10..60 s", "", 0.0, 1.0, 1.0),
        Clue("unstable", "more Ki is unstable: first such Ki / 0.0005", "x", 1.0, 10.0, 5.0),
        Clue("gains", "Kp 4..6, Kd 1..2 work: most deg left", "deg", 0.0, 2.5, 1.0),
        Clue("harder", "1.2 is harder: deg left after 30 s", "deg", TENTH_DEG, 10.0, 0.5),
    )
}


def swings(trace: Trace) -> int:
    """Unstable means: three or more swings across the setpoint, 10 % beyond it, in 10..60 s."""
    return trace.swings(10.0, TENTH_DEG)


def _unstable_from(turn: Axis, reading: Reading) -> float:
    """The first of 2, 4, 10, 40 times the published Ki that swings on; 1000 when none does."""
    for times in (2.0, 4.0, 10.0, 40.0):
        gains = replace(PUBLISHED, ki=times * PUBLISHED.ki)
        if swings(run(turn, reading, gains, LONG_S)) >= 3:
            return times
    return 1000.0


def profile_axis(turn: Axis, profile: str) -> Axis:
    """The same chair in another profile: its full speeds there, all else as it is."""
    full = PROFILES[profile].turn
    return replace(turn, positive=full.positive, negative=full.negative)


def values(turn: Axis, reading: Reading) -> Iterator[tuple[str, float]]:
    """The value of each clue by its key, cheapest first, for the chair `turn` in profile 4.1."""
    short = run(turn, reading, PUBLISHED, 2.5)
    yield "crossing", short.first_crossing_s()
    yield "overshoot", short.overshoot_deg()
    a = run(turn, reading, PUBLISHED, LONG_S)
    yield "left", abs(a.error_deg(33.0))
    yield "calm", float(swings(a))
    b = run(turn, reading, PUBLISHED, LONG_S, CUTOFF_DEG)
    yield "settled", b.settled_s(TENTH_DEG)
    yield "pd", abs(run(turn, reading, _PD, LONG_S).error_deg(LONG_S))
    lefts = [run(turn, reading, gains, LONG_S, CUTOFF_DEG) for gains in _WORKING]
    yield "gains", max(abs(trace.error_deg(LONG_S)) for trace in lefts)
    slow = run(profile_axis(turn, "1.2"), reading, PUBLISHED, 30.0, CUTOFF_DEG, "1.2")
    yield "harder", abs(slow.error_deg(30.0))
    yield "unstable", _unstable_from(turn, reading)


@dataclass(frozen=True)
class Match:
    """How well a chair reproduces the clues under one reading."""

    found: dict[str, float]
    cost: float

    def holds(self) -> bool:
        """Whether every clue holds."""
        return self.cost == 0.0


def match(turn: Axis, reading: Reading) -> Match:
    """Sum of squared misses over all clues."""
    found = dict(values(turn, reading))
    return Match(found, sum(CLUES[key].miss(value) ** 2 for key, value in found.items()))
