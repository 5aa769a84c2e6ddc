"""The virtual board's time: what the PC takes from it did not happen for the firmware."""

from __future__ import annotations

import random

import pytest

from gazeboard.boards import bank_layout as layout
from gazeboard.boards import virtual
from gazeboard.boards.bank_devices import put_u32
from gazeboard.core import limits
from gazeboard.core.tick_clock import TickClock
from gazesim.lockstep import Clock

_START_US = 0x3FFFFFFF - 2_000_000  # the clock wraps within the test
_SLICES = 30_000


class _PC:
    """A PC that stalls at random, with the simulated world and the app that runs on the board."""

    def __init__(
        self, seed: int, stall: float, world_stall: float, reading_stall: float = 0.0
    ) -> None:
        self._chance = random.Random(seed)
        self._stall = stall
        self._world_stall = world_stall
        self._reading_stall = reading_stall
        self._us = _START_US
        self._world_us = 0
        self._world_stands_us = 0
        self._left = _SLICES
        bank = bytearray(layout.SIZE)
        clock = Clock()
        self.board = virtual.VirtualBoard(bank, None, None, 1, self._now_us, clock.ticks_diff)
        self._bank = bank
        self._last_us = -1
        self.elapsed_us: list[int] = []
        self._last_ms = 0
        self.slept_ms = 0  # ticks since the milliseconds last changed
        self.slept_most_ms = 0

    def _now_us(self) -> int:
        """Just before it is read, too, the process may not be run."""
        if self._chance.random() < self._reading_stall:
            self._us += self._chance.randrange(200, 150_000)
        return self._us & 0x3FFFFFFF

    def pass_us(self, us: int) -> None:
        """That much time passes, and now and then more: the process is not run, or the world's."""
        if self._chance.random() < self._stall:
            us += self._chance.randrange(200, 150_000)
        self._us += us
        if self._world_stands_us <= 0 and self._chance.random() < self._world_stall:
            self._world_stands_us = self._chance.randrange(1_000, 120_000)
        if self._world_stands_us > 0:
            self._world_stands_us -= us
        else:
            self._world_us += us
        put_u32(self._bank, layout.WORLD_MS_AT, 1 + self._world_us // 1000)

    def tick(self) -> None:
        """As the app's: it reads the clock first."""
        now_us = self.board.ticks_us()
        if self._last_us >= 0:
            self.elapsed_us.append(self.board.ticks_diff(now_us, self._last_us))
        self._last_us = now_us
        self.slept_ms += 1
        self.pass_us(self._chance.randrange(50, 400))

    def service(self) -> bool:
        """A slice, which reads the clock as well."""
        now_ms = self.board.ticks_ms()
        self.slept_most_ms = max(self.slept_most_ms, self.slept_ms)
        if now_ms != self._last_ms:
            self._last_ms = now_ms
            self.slept_ms = 0
        self.pass_us(self._chance.randrange(20, 900))
        self._left -= 1
        return self._left > 0

    def shut_down(self) -> None:
        """Nothing to do."""


@pytest.mark.parametrize(
    ("stall", "world_stall", "reading_stall"),
    [
        (0.0, 0.0, 0.0),
        (0.01, 0.0, 0.0),
        (0.0, 0.01, 0.0),
        (0.01, 0.01, 0.0),
        (0.2, 0.2, 0.0),
        (0.0, 0.0, 0.01),
        (0.2, 0.2, 0.2),
    ],
    ids=["quiet", "it stalls", "the world", "both", "both, often", "at a reading", "everywhere"],
)
def test_a_stall_of_the_pc_is_no_late_tick(
    stall: float, world_stall: float, reading_stall: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Time never goes back between two ticks, no tick counts as stalled, and milliseconds go on."""
    pc = _PC(1, stall, world_stall, reading_stall)
    monkeypatch.setattr(virtual, "sleep_us", pc.pass_us)
    pc.board.run(pc)
    clock = TickClock()
    missed_ms = 0
    for elapsed_us in pc.elapsed_us:
        missed_ms = max(missed_ms, clock.step(elapsed_us))
        assert elapsed_us >= 0
    assert len(pc.elapsed_us) > 1000
    assert max(pc.elapsed_us) <= limits.TICK_STALLED_US
    assert missed_ms <= limits.TICK_STALLED_US // 1000
    assert pc.slept_most_ms <= 5


def test_a_stall_before_the_first_tick_does_not_stop_the_ticks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Wherever the clock stands, and between whichever of its first readings."""
    monkeypatch.setattr(virtual, "sleep_us", lambda us: None)
    for stalls_at in range(1, 5):
        for start_us in (100, (1 << 29) + 100_000_000, _START_US):
            pc = _PC(1, 0.0, 0.0)
            pc._us = start_us
            pc._left = 30
            pc.board._ms_at_us = start_us
            readings = 0

            def now_us(pc: _PC = pc, stalls_at: int = stalls_at) -> int:
                nonlocal readings
                readings += 1
                pc._us += 6_000 if readings == stalls_at else 100
                return pc._us & 0x3FFFFFFF

            monkeypatch.setattr(pc.board, "_clock_us", now_us)
            pc.board.run(pc)
            assert len(pc.elapsed_us) > 1


def test_a_hang_on_purpose_is_found_late(monkeypatch: pytest.MonkeyPatch) -> None:
    """The simulator says that it stopped the process: that time has passed for the firmware."""
    pc = _PC(1, 0.0, 0.0)
    hung = []

    def service() -> bool:
        if len(pc.elapsed_us) == 100 and not hung:
            hung.append(True)
            put_u32(pc.board._bank, layout.HOST_FLAGS_AT, 2)
            pc.pass_us(300_000)
        return _PC.service(pc)

    monkeypatch.setattr(virtual, "sleep_us", pc.pass_us)
    monkeypatch.setattr(pc, "service", service)
    pc.board.run(pc)
    assert max(pc.elapsed_us) >= 300_000
