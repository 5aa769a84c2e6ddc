"""P17 to P20 end to end: a mode that nobody holds drives the whole chair."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from gazeboard.core import limits
from gazelink import codes
from gazesim.lockstep_chair import Lockstep
from promises import END_TO_END, kept, measured

pytestmark = pytest.mark.costly

MODE = "go"
SUPERVISION_MS = 3000  # the setting
PAGE_MS = 20  # from a page to the wheels, in an idle network
PATH_MS = 60  # of a page's word: network, host and cable
LIFE_S = 0.15


class Going(Lockstep):
    """A chair that drives by itself: its planner says the same in each 20 ms."""

    def __init__(self, output: tuple[int, int] = (400, 0)) -> None:
        super().__init__()
        self.output = output
        self.plans = True
        self.looks = True
        self.watchers.append(self._act)
        self.arm()
        self.until(lambda: not self.board.app.obstacles.blocked & 15, 700)
        assert self.host is not None
        self.host.control.offer_mode(MODE, {"auto": True})
        self.begin()

    def begin(self) -> None:
        """Dwell on its tile, once."""
        self.plans = self.looks = True
        self.page.choose(MODE)
        self.until(lambda: not self.neutral(), PATH_MS + 40)
        self.run(300)
        assert not self.neutral(), self.why()

    def _act(self) -> None:
        if self.host is None:
            return
        control = self.host.control
        if self.plans and self.now_ms % 20 == 0:
            context = control.mode_context()
            if context.mode:
                control.mode_output(context.mode, context.press, self.output, self.now_s() + LIFE_S)
        if self.looks and self.page.alive and self.now_ms % 250 == 0:
            self.page.look()

    def ends(self, promise: str, cause: str, limit_ms: int) -> None:
        """Neutral in time, for good; "Verder" goes on."""
        ms = self.until(self.neutral, limit_ms + 100)
        measured(END_TO_END, promise, cause, ms, limit_ms)
        self.plans = self.looks = True
        self.stays_still(500)
        self.begin()


@pytest.fixture
def chair() -> Iterator[Going]:
    return Going()


def test_p17_the_planner_falls_silent(chair: Going) -> None:
    chair.until(lambda: chair.now_ms % 20 == 0, 20)
    chair.plans = False
    chair.ends("P17", "no newer value of the planner", limits.AUTO_TTL_MS)


def test_p18_the_driver_looks_away(chair: Going) -> None:
    chair.until(lambda: chair.now_ms % 250 == 1, 250)
    chair.looks = False
    cause = f"supervision not renewed, {SUPERVISION_MS} ms set"
    chair.ends("P18", cause, SUPERVISION_MS + 1)
    assert chair.host is not None


def test_p18_another_driver_who_moves_on_their_page_does_not_supervise(chair: Going) -> None:
    other = chair.another_page()
    chair.run(200)
    chair.until(lambda: chair.now_ms % 250 == 1, 250)
    chair.looks = False
    chair.watchers.append(lambda: other.look() if chair.now_ms % 250 == 0 else None)
    chair.until(chair.neutral, SUPERVISION_MS + 1)
    chair.stays_still(500)


def test_p18_a_caretaker_watches_and_lets_go(chair: Going) -> None:
    caretaker = chair.another_page("caretaker")
    chair.run(200)
    chair.looks = False
    for _ in range(20):
        caretaker.look()
        chair.run(250)
        assert not chair.neutral(), chair.why()
    cause = f"supervision not renewed, {SUPERVISION_MS} ms set"
    chair.ends("P18", cause, SUPERVISION_MS + 1)


def test_p19_no_bypass_helps_it(chair: Going) -> None:
    caretaker = chair.another_page("caretaker")
    chair.run(200)
    caretaker._send_fresh(k="bypass", held=True, edge=1)
    ms = chair.until(chair.neutral, PATH_MS)
    measured(END_TO_END, "P20", "a bypass press, on a page", ms, PAGE_MS)
    kept(END_TO_END, "P19", "a bypass while it is blocked")


def test_p19_it_keeps_to_its_own_speed() -> None:
    chair = Going((1000, 0))
    fastest = 556  # mm/s at full deflection, of the fastest profile
    for _ in range(1000):
        chair.one_ms()
        permille = (chair.wipers()[0] - 170) * 1000 / 84
        assert permille * fastest / 1000 <= limits.AUTO_MM_S
    kept(END_TO_END, "P19", "more is asked for than its speed")


def test_p20_another_tile_or_stop_ends_it(chair: Going) -> None:
    chair.page.say(k="stop")
    chair.ends("P20", "Stop, on a page", PAGE_MS)
    chair.page.press("left")
    chair.until(lambda: not chair.neutral() and chair.wipers()[0] == 170, PATH_MS)
    chair.page.release()
    chair.until(chair.neutral, PATH_MS)
    chair.comes_to_rest()
    chair.stays_still(300)
    kept(END_TO_END, "P20", "a press by anyone")


def test_p20_the_board_tells_why_and_the_page_offers_to_go_on(chair: Going) -> None:
    chair.looks = False
    chair.until(chair.neutral, SUPERVISION_MS + 300)
    chair.run(200)
    assert chair.page.shown["override"] == codes.reason_name(codes.SUPERVISION_LOST)
    assert chair.page.shown["auto"] == ["", MODE]
