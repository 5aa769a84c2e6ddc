"""Shares of the processor: kept in the long run, whatever a piece of work costs. Virtual time."""

from __future__ import annotations

import threading
import time

import pytest

from gazechair.web.processor_share import BURST_S, SHARE, Crowded, Shares, write_off


class Shop:
    """Share of a thread that works in virtual time."""

    def __init__(self, at_once: int = 1) -> None:
        self.now_s = self.spent_s = 0.0
        self.share = Shares(
            at_once, clock=lambda: self.now_s, spent=lambda: self.spent_s, sleep=self._pass
        )
        self.share.bill()
        self.spent_s = 0.0

    def work(self, seconds: float) -> None:
        self.spent_s += seconds
        self.now_s += seconds

    def _pass(self, seconds: float) -> None:
        self.now_s += seconds


@pytest.fixture(autouse=True)
def fresh_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gazechair.web.processor_share._MINE", threading.local())


@pytest.mark.parametrize("each_s", [0.0001, 0.002, 0.05])
def test_in_the_long_run_work_takes_its_share(each_s: float) -> None:
    shop = Shop()
    while shop.now_s < 20:
        with shop.share.turn():
            shop.work(each_s)
    assert shop.spent_s <= SHARE * shop.now_s + BURST_S + each_s


def test_little_work_never_waits() -> None:
    shop = Shop()
    for _ in range(1000):
        began_s = shop.now_s
        with shop.share.turn():
            assert shop.now_s == began_s
            shop.work(0.002)
        shop.now_s += 0.01


def test_a_debt_that_takes_too_long_is_refused() -> None:
    shop = Shop()
    with shop.share.turn():
        shop.work(10.0)
    with pytest.raises(Crowded), shop.share.turn():
        pass
    shop.now_s += 60
    with shop.share.turn():
        pass


def test_work_outside_turns_is_billed_too() -> None:
    shop = Shop()
    for _ in range(1000):
        shop.work(0.001)
        shop.share.bill()
        shop.share.pause(0.1)
    assert shop.spent_s <= SHARE * shop.now_s + BURST_S + 0.001


def test_a_pause_has_an_end() -> None:
    shop = Shop()
    shop.work(100.0)
    shop.share.bill()
    began_s = shop.now_s
    shop.share.pause(0.1)
    assert shop.now_s - began_s <= 0.1001


def test_only_so_many_work_at_once() -> None:
    share = Shop(at_once=2).share
    with share.turn(), share.turn(), pytest.raises(Crowded), share.turn(0.01):
        pass
    with share.turn(0.01):
        pass  # free again, after an error too


def test_what_waits_holds_up_no_other_kind_and_all_share_one_processor() -> None:
    shop = Shop()
    with shop.share.turn(kind="POST"):
        with pytest.raises(Crowded), shop.share.turn(0.01, kind="POST"):
            pass
        with shop.share.turn(0.01), shop.share.turn(0.01, kind="GET"):
            shop.work(10.0)
    for kind in ("", "GET", "POST"):
        with pytest.raises(Crowded), shop.share.turn(kind=kind):
            pass


def test_what_was_written_off_is_billed_to_nobody() -> None:
    share = Shares(clock=lambda: 0.0, sleep=lambda _: pytest.fail("it waits"))
    share.bill()
    share = Shares(clock=lambda: 0.0, sleep=lambda _: pytest.fail("it waits"))
    end_s = time.thread_time() + 2 * BURST_S
    while time.thread_time() < end_s:
        pass
    write_off()
    with share.turn(0.0):
        pass
