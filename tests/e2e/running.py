"""The real daemon and the real firmware as processes, the page played; judged by board ticks."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from typing import Any

from e2e.player import Player
from gazedemo.stack import Stack

NEUTRAL = (170, 170)
LIMIT_S = 60.0  # for conditions that do come; the machine may stall


class Running:
    """One simulated chair with everything around it, in real time."""

    def __init__(self, stack: Stack) -> None:
        self.stack = stack
        self.sim = stack.control()
        self.player = Player(stack.url, stack.cookie())

    def close(self) -> None:
        """The page closes."""
        self.player.stop()

    # -- what is so --

    def until(self, condition: Callable[[], object], what: str) -> None:
        """Wait for `condition`; AssertionError saying `what` when it never comes."""
        end_s = time.monotonic() + LIMIT_S
        while not condition():
            assert time.monotonic() < end_s, f"never: {what}; {self.why()}"
            time.sleep(0.01)

    def why(self) -> str:
        """For messages of failed assertions."""
        return f"page {self.player.state}, refused {self.player.refused[-5:]}, {self.sim.truth()}"

    def wipers(self) -> tuple[int, int]:
        """What the pot's registers hold now."""
        return self.sim.wipers()

    def harmless(self) -> bool:
        """Nothing reaches the chair."""
        truth = self.sim.truth()
        return tuple(truth["wipers"]) == NEUTRAL or not truth["relay_closed"]

    def mark(self) -> int:
        """Number of the last wiper change so far."""
        return int(self.sim.do("wiper_log", since=0)["last"])

    def moved_since(self, mark: int) -> bool:
        """Whether the wipers left neutral after `mark`."""
        entries = self.sim.do("wiper_log", since=mark)["entries"]
        return any((e[2], e[3]) != NEUTRAL for e in entries)

    def neutral_at(self, mark: int) -> int:
        """The board's tick at which the wipers became neutral after `mark`; waits for it."""
        self.until(lambda: self._neutral_entry(mark) is not None, "neutral wipers")
        tick = self._neutral_entry(mark)
        assert tick is not None
        return tick

    def _neutral_entry(self, mark: int) -> int | None:
        log = self.sim.do("wiper_log", since=mark)
        for entry, tick in zip(log["entries"], log["ticks"], strict=True):
            if (entry[2], entry[3]) == NEUTRAL:
                return int(tick)
        return None

    def tick(self) -> int:
        """The board's own time, ms."""
        return int(self.sim.truth()["tick_ms"])

    def message(self) -> str:
        """What the page shows."""
        return str(self.player.state.get("message", ""))

    # -- what people do --

    def drive(self, verb: str = "forward") -> None:
        """Armed and moving; tries again when a stall of the PC came between."""
        self.player.release()
        end_s = time.monotonic() + LIMIT_S
        while time.monotonic() < end_s:
            if self._reaches(lambda s: s.get("arm_reason") == "none", 20.0):
                if self.player.state.get("state") != "armed":
                    self.player.arm()
                if self._reaches(lambda s: s.get("state") == "armed", 3.0):
                    self.player.press(verb)
                    if self._moves():
                        return
            self.player.release()
            time.sleep(0.5)
        raise AssertionError(f"does not drive: {self.why()}")

    def _reaches(self, condition: Callable[[dict[str, Any]], bool], limit_s: float) -> bool:
        end_s = time.monotonic() + limit_s
        while time.monotonic() < end_s:
            if condition(self.player.state):
                return True
            time.sleep(0.01)
        return False

    def _moves(self) -> bool:
        end_s = time.monotonic() + 3.0
        while time.monotonic() < end_s:
            truth = self.sim.truth()
            if tuple(truth["wipers"]) != NEUTRAL and abs(truth["speed_m_s"]) > 0.05:
                return True
            time.sleep(0.01)
        return False

    def stays_still(self, ticks: int, mark: int) -> None:
        """For that much of the board's time nothing moves; counted from `mark` on."""
        start = self.tick()
        self.until(lambda: not 0 <= self.tick() - start < ticks, f"{ticks} ms of the board's time")
        assert not self.moved_since(mark), self.why()

    def stands(self) -> None:
        """The chair itself comes to rest."""
        self.until(
            lambda: self.sim.truth()["speed_m_s"] == 0 and self.harmless(), "the chair stands"
        )

    # -- the host --

    def signal_host(self, number: signal.Signals) -> None:
        """SIGKILL, SIGSTOP, SIGCONT to the daemon."""
        os.kill(self.stack.pid("host"), number)

    def restart_host(self) -> None:
        """The daemon has been killed: start it again as it was started."""
        self.until(lambda: self.stack.ended("host") is not None, "it has ended")
        self.stack.start_host()

    def take_a_place(self) -> None:
        """Room to drive in, standing."""
        self.player.release()
        self.until(self.harmless, "harmless")
        self.sim.do("teleport", x_m=-5.0, y_m=0.0, heading_deg=0)
