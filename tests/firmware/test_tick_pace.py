"""Ticks that come too seldom, unevenly or in bursts: promises in ms are kept in microseconds.

Time here is the microsecond clock's. The oracle knows when the last frame, hold, view or service
slice was, and when the wipers became neutral; a tick that has not come can write nothing, so the
longest gap between ticks is granted, as P10 grants it, and no more.
"""

import copy
from collections.abc import Callable, Iterator
from functools import cache
from itertools import chain, cycle, repeat

import pytest

from gazeboard.core import limits
from gazelink import codes
from gazesim.board_rig import Rig
from promises import CORE, kept

pytestmark = pytest.mark.costly

QUANTUM_US = 250
WRAP_US = 1 << 30
PERIODS_US = (
    *(1000, 1005, 1010, 1011, 1030, 1049, 1050, 1060, 1100, 1200, 1300, 1500, 1900),
    *(2000, 3000, 4000, 5000, 7000, 10_000, 12_000, 15_000, 19_000, 20_000),
)
PACES: dict[str, Callable[[], Iterator[int]]] = {
    **{f"{period} us": (lambda p=period: repeat(p)) for period in PERIODS_US},
    "every other one late": lambda: cycle((500, 1500)),
    "jitter": lambda: cycle((1000, 1300, 700, 1900, 100, 1000, 1250, 750)),
    "one of ten lost": lambda: cycle((*repeat(1000, 9), 2000)),
    "pauses made up for": lambda: cycle((*repeat(1000, 20), 5000, *repeat(0, 4))),
    "pauses not made up for": lambda: cycle((*repeat(1000, 20), 5000)),
    "a pause, then well": lambda: chain((9000,), repeat(1000)),
    "slower and slower": lambda: chain(range(1000, 20_000, 20), repeat(20_000)),
}
CAUSES = {
    "P2": limits.HOST_SILENT_MS,
    "P3": limits.COMMAND_TTL_MS,
    "P6": limits.CLEARANCE_OLD_MS,
    "P9": limits.SERVICE_STALLED_MS,
}


@cache
def driving(wraps: bool) -> Rig:
    """A chair that drives forward, its contact closed from now on, whatever the ticks do."""
    rig = Rig(WRAP_US - 1_800_000 if wraps else 0)
    rig.drive()
    rig.until(lambda: rig.now_ms % 20 == 0, 20)
    rig._relay = lambda: None
    return rig


class World:
    """Everything but the ticks goes on every 250 us of the clock."""

    def __init__(self, rig: Rig, gaps: Iterator[int]) -> None:
        self.rig = rig
        self.gaps = gaps
        self.now_us = 0
        self.host = self.lidar = self.hold = self.service = True
        self.last_us = dict.fromkeys(CAUSES, 0)
        self.ticked_us = 0
        self.longest_us = 0
        self.next_us = next(gaps)
        self._start_us = rig.clock.now_us
        rig.host_alive = False  # it speaks here

    def step(self) -> None:
        rig = self.rig
        self.now_us += QUANTUM_US
        if self.now_us % 10_000 == 0:
            rig._sense()
        if self.now_us % 20_000 == 0 and self.host:
            rig.lidar_alive = self.lidar
            rig.hold = self.hold
            rig.speak()
            self._note("P2")
            if self.lidar:
                self._note("P6")
            if self.hold:
                self._note("P3")
        while self.next_us <= self.now_us:
            rig.clock.now_us = self._start_us + self.next_us
            rig.board.tick(rig.app)
            self.longest_us = max(self.longest_us, self.next_us - self.ticked_us)
            self.ticked_us = self.next_us
            self.next_us += next(self.gaps)
        rig.clock.now_us = self._start_us + self.now_us
        if self.service:
            rig.app.service()
            self._note("P9")
        rig.listen()

    def _note(self, cause: str) -> None:
        self.last_us[cause] = self.now_us


def cut(world: World, cause: str) -> None:
    """What the promise is about does not come any more, from now on."""
    world.host = cause != "P2"
    world.hold = cause != "P3"
    world.lidar = cause != "P6"
    world.service = cause != "P9"


@pytest.mark.parametrize("wraps", [False, True])
@pytest.mark.parametrize("cause", CAUSES)
@pytest.mark.parametrize("pace", PACES)
def test_ages_are_kept_whatever_the_pace(pace: str, cause: str, wraps: bool) -> None:
    for before_ms in (0, 13, 60):
        world = World(copy.deepcopy(driving(wraps)), PACES[pace]())
        for _ in range(4 * before_ms):
            world.step()
        cut(world, cause)
        limit_us = 1000 * CAUSES[cause]
        world.longest_us = 0
        for _ in range(2 * limit_us // QUANTUM_US + 4 * 40):
            world.step()
            if world.rig.neutral():
                break
        took_us = world.ticked_us - world.last_us[cause]
        granted_us = limit_us + max(0, world.longest_us - 1000)
        # An age counts from a view's acquisition: the rig's are 5 ms old when they are sent.
        took_us += 5000 if cause == "P6" else 0
        story = f"{pace}, {cause}: {took_us} us, at most {granted_us}: {world.rig.why()}"
        assert world.rig.neutral(), story
        assert took_us <= granted_us, story
    kept(CORE, cause, "ticks of any pace")


@pytest.mark.parametrize("verb", [codes.FORWARD, codes.LEFT])
@pytest.mark.parametrize("pace", PACES)
def test_p4_a_step_is_no_longer_whatever_the_pace(pace: str, verb: int) -> None:
    rig = copy.deepcopy(driving(False))
    rig.release()
    rig.run(60)
    rig.app.settings.step_forward_ms = rig.app.settings.step_turn_limit_ms = 1000
    world = World(rig, PACES[pace]())
    rig.press(verb, codes.STEP)
    while rig.neutral() and world.now_us < 200_000:
        world.step()  # where ticks are too rare it is disarmed before
    began_us = world.ticked_us
    world.longest_us = 0
    while not rig.neutral():
        world.step()
    took_us = world.ticked_us - began_us
    assert took_us <= 1_001_000 + max(0, world.longest_us - 1000), rig.why()
    kept(CORE, "P4", "ticks of any pace")


def moves_for_s(gaps: Iterator[int], seconds: float) -> bool:
    world = World(copy.deepcopy(driving(False)), gaps)
    for _ in range(int(seconds * 1e6 / QUANTUM_US)):
        world.step()
        if world.rig.neutral():
            return False
    return True


@pytest.mark.parametrize("period_us", [p for p in PERIODS_US if p > 1050])
def test_a_pace_more_than_5_percent_slow_is_seen(period_us: int) -> None:
    world = World(copy.deepcopy(driving(False)), repeat(period_us))
    while world.rig.app.safety.state == codes.ARMED:
        world.step()
        assert world.now_us < 1_100_000, world.rig.why()
    assert world.rig.app.safety.faults & 1 << codes.TICK_STALLED
    for _ in range(8000):
        world.step()
        assert world.rig.app.safety.faults & 1 << codes.TICK_STALLED


@pytest.mark.parametrize("pace", ["every other one late", "jitter", "pauses made up for"])
def test_a_pace_that_is_right_on_the_whole_drives_on(pace: str) -> None:
    assert moves_for_s(PACES[pace](), 1.5)
    assert moves_for_s(repeat(1049), 1.5)
