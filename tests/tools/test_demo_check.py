"""The demo's own check: what it forgives as a stall of this PC, and what it does not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gazedemo.check import NEUTRAL, Check, CheckFailed

MOVING = (200, 170)


class Demo:
    """Its stack, simulator, page and driver, all ideal but for the attributes."""

    def __init__(self) -> None:
        self.moves_by_itself = False
        self.says_it_is_gone = True
        self.stalled = range(0)  # which holds do not begin: the PC disarms the chair
        self.ended = 0  # which pull of the cable comes after the press has ended
        self.shown_after = 0  # looks at the page until it shows the stall that ended a step
        self.turned_deg = [10.0]  # by each press of Links
        self.held = self.pulled = 0
        self.page = self
        self._armed = True
        self._wipers = NEUTRAL
        self._heading_deg = 0.0
        self.looks = 0

    def control(self) -> Demo:
        return self

    def health(self) -> dict[str, Any]:
        return {"board": {"state": "ok"}}

    # The simulator.

    def do(self, what: str, **_more: Any) -> dict[str, Any]:
        if what == "pull_cable":
            self.pulled += 1
            self._armed, self._wipers = False, NEUTRAL
        elif what == "plug_cable" and self.moves_by_itself:
            self._wipers = MOVING
        at_s = 0.0 if self.pulled == self.ended else 1e9
        return {"last": 0, "entries": [(1, at_s, *NEUTRAL)]}

    def wipers(self) -> tuple[int, int]:
        return self._wipers

    def truth(self) -> dict[str, float]:
        return {"heading_deg": self._heading_deg}

    def wait(self, condition: Callable[..., bool], _limit_s: float, what: str) -> Any:
        if what == "a stall":
            for _ in range(10):
                if condition():
                    return 0.1
            raise TimeoutError(what)
        if "drives" in what:
            self.held += 1
            if self.held in self.stalled:
                self._armed = False
                raise TimeoutError(what)
            self._wipers = MOVING
        if what == "the page says that the board is gone":
            if not self.says_it_is_gone:
                raise TimeoutError(what)
            return 0.1
        return {}

    # The driver and the page.

    def click(self, target: str) -> None:
        if target == "left":
            self._heading_deg += self.turned_deg.pop(0)
            self.looks = 0

    def data(self, name: str) -> str:
        if name == "mode":
            return "step"
        assert name == "state"
        return "armed" if self._armed else "disarmed"

    def arm(self, _tries: int, _limit_s: float) -> int:
        self._armed = True
        return 0

    def release(self) -> None:
        self._wipers = NEUTRAL

    def evaluate(self, _what: str) -> str:
        self.looks += 1
        return "host_silent" if 0 < self.shown_after < self.looks else ""

    def ignore(self, *_any: object) -> None:
        pass

    press = rest = screenshot = wait_for_timeout = ignore


def pulls_the_cable(demo: Demo) -> None:
    check = Check(demo, demo, Path())  # type: ignore[arg-type]
    check._do(check.pull_the_cable_and_plug_it_in, 4)


@pytest.mark.parametrize(
    ("what", "value", "reason"),
    [("moves_by_itself", True, "moved by itself"), ("says_it_is_gone", False, "the board is gone")],
    ids=["a chair that moves by itself", "a page that does not say that the board is gone"],
)
def test_what_is_no_stall_of_this_pc(what: str, value: bool, reason: str) -> None:
    demo = Demo()
    setattr(demo, what, value)
    with pytest.raises(CheckFailed, match=reason):
        pulls_the_cable(demo)
    assert demo.pulled == 1


def test_a_stall_before_the_cable_is_pulled_is_forgiven() -> None:
    demo = Demo()
    demo.ended = 1
    demo.stalled = range(2, 6)  # all of the second try
    pulls_the_cable(demo)
    assert (demo.pulled, demo.held) == (2, 7)


def steps_left(demo: Demo, tries: int = 4) -> None:
    check = Check(demo, demo, Path())  # type: ignore[arg-type]
    check._do(check.step_left, tries)


def test_a_stall_that_the_page_shows_a_moment_later_is_forgiven() -> None:
    demo = Demo()
    demo.shown_after = 5
    demo.turned_deg = [0.0, 10.0]
    steps_left(demo)
    assert not demo.turned_deg


def test_a_step_that_is_too_short_without_a_stall_is_not() -> None:
    demo = Demo()
    demo.turned_deg = [0.0, 10.0]
    with pytest.raises(CheckFailed, match="turned"):
        steps_left(demo)


def test_after_the_last_try_nobody_waits_for_the_page_to_show_a_stall() -> None:
    demo = Demo()
    demo.shown_after = 5
    demo.turned_deg = [0.0]
    with pytest.raises(CheckFailed, match="turned"):
        steps_left(demo, tries=1)
    assert demo.looks == 0
