"""A producer's runner on a busy machine: late steps, steps that think for long, old values."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from itertools import pairwise
from typing import Any

import pytest

from gazechair.plugins.exchange import AUTO_LIFE_S
from gazechair.plugins.exchange import unpack as value_of
from gazechair.producers.contract import STEP_S, Output, Press, Producer, Sensed, Setup
from gazechair.producers.exchange import unpack
from gazechair.producers.runner import Runner
from gazechair.sensing.inbox.pieces import Lidars

_DRIVES = Output((400, 0), "drives")


class _Drives(Producer):
    def press(self, press: Press) -> None:
        pass

    def step(self, sensed: Sensed, now_s: float) -> Output:
        return _DRIVES


class _Slow(Executor):
    """Runs a step that takes `takes_s` of the rig's time."""

    def __init__(self, rig: _Rig) -> None:
        self._rig = rig
        self._open: list[tuple[float, Future[Any], Callable[[], Any]]] = []

    def submit(self, work: Any, /, *_args: Any, **_kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self._open.append((self._rig.now_s + self._rig.takes_s, future, work))
        self.work()
        return future

    def work(self) -> None:
        """Finish what is due."""
        for one in [one for one in self._open if one[0] <= self._rig.now_s]:
            self._open.remove(one)
            one[1].set_result(one[2]())


class _Rig:
    """A runner that is pressed, and everything it reports: (now, birth, stick, state)."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s, self.takes_s, self.press = 100.0, 0.005, 1
        self.sent: list[tuple[float, float, tuple[int, int] | None, str]] = []
        self._slow = _Slow(self)
        monkeypatch.setattr("gazechair.producers.runner.wait", lambda _futures, s: self._pass(s))
        setup: Any = Setup
        self.runner = Runner(_Drives(setup), Lidars({}), self, self._slow, lambda: self.now_s)

    def _pass(self, seconds: float) -> None:
        # As wait(): up to the end of the step.
        end_s = self.now_s + seconds
        while self.now_s < end_s and self._slow._open:
            self.now_s = min(end_s, max(self.now_s, self._slow._open[0][0]))
            self._slow.work()

    def data(self, payload: bytes) -> None:
        """What the runner reports."""
        record = unpack(payload)
        value = value_of(record.value)
        drives = value.intent.do == "drive"
        stick = (value.intent.linear_permille, value.intent.turn_permille) if drives else None
        self.sent.append((self.now_s, value.born_s, stick, record.state))

    def run(self, seconds: float, gap_s: float = STEP_S) -> None:
        """Tick for that long, pressed."""
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            tick_s = self.now_s
            self._slow.work()
            words = {"target": {}, "settings": {}, "may_reverse": True, "cap_permille": 1000}
            self.runner.on_message({"at_s": tick_s, "press": self.press, **words})
            self.runner.tick(tick_s)
            self.now_s = max(self.now_s, tick_s + gap_s)

    def standing(self) -> list[str]:
        """States of reports that stop the chair."""
        return [state for _, _, stick, state in self.sent if stick != (400, 0)]

    def lapses(self) -> int:
        """Number of times that the newest value had expired before the next one."""
        lives = [(now_s, born_s + AUTO_LIFE_S) for now_s, born_s, _, _ in self.sent]
        return sum(b[0] >= a[1] for a, b in pairwise(lives))


@pytest.fixture
def rig(monkeypatch: pytest.MonkeyPatch) -> _Rig:
    return _Rig(monkeypatch)


def test_each_step_reports_what_it_decides(rig: _Rig) -> None:
    """Every 50 ms, born at its end."""
    rig.run(0.99)
    assert len(rig.sent) == 20
    assert {sent[2:] for sent in rig.sent} == {((400, 0), "drives")}
    assert max(now_s - born_s for now_s, born_s, _, _ in rig.sent) < 0.001


@pytest.mark.parametrize("takes_s", [0.035, 0.06, 0.075])
def test_a_late_step_stops_nothing(rig: _Rig, takes_s: float) -> None:
    """The value before it still lives: on a busy machine the chair drives on."""
    rig.run(0.2)
    for _ in range(10):
        rig.takes_s = takes_s
        rig.run(STEP_S)
        rig.takes_s = 0.005
        rig.run(0.1)
    assert rig.standing() == []
    assert rig.lapses() == 0


def test_one_that_thinks_for_long_stands_before_its_value_expires(rig: _Rig) -> None:
    """It stands and says that it thinks; what it decides in the end is too old to count."""
    rig.run(0.2)
    rig.takes_s = 2.0
    rig.run(1.0)
    assert set(rig.standing()) == {"thinks"}
    assert rig.lapses() == 0
    rig.takes_s = 0.005
    rig.sent.clear()
    rig.run(1.5)
    ended = [(now_s, born_s) for now_s, born_s, stick, _ in rig.sent if stick == (400, 0)]
    assert ended[0][0] - ended[0][1] > AUTO_LIFE_S
    assert ended[1][0] - ended[1][1] < 0.01


def test_a_press_during_another_ones_step_is_answered_at_once(rig: _Rig) -> None:
    """It stands and thinks from its first tick on, not when that step has ended."""
    rig.takes_s = 0.029
    rig.run(0.2)
    rig.takes_s = 1.0
    rig.run(0.01, gap_s=0.0)
    rig.press = 2
    rig.sent.clear()
    rig.run(0.01, gap_s=0.0)
    assert [state for _, _, _, state in rig.sent] == ["thinks"]


def test_a_press_does_not_wait_for_the_next_period(rig: _Rig) -> None:
    rig.run(0.2)
    words = {"target": {}, "settings": {}, "may_reverse": True, "cap_permille": 1000}

    def after_s(number: int) -> float:
        message = {"at_s": rig.now_s, "press": number, **words}
        before_s = rig.now_s
        rig.runner.on_message(message)
        rig.now_s += rig.runner.left_s(rig.now_s)
        rig.runner.tick(rig.now_s)
        return rig.now_s - before_s

    rig.takes_s = 0.0
    after_s(rig.press)
    rig.now_s += 0.02
    assert after_s(2) == 0.0
    assert rig.sent[-1][2] == (400, 0)
    assert after_s(2) == pytest.approx(STEP_S)  # then every 50 ms
    rig.now_s += 0.02
    assert after_s(0) > 0.01
    rig.now_s += 0.02
    assert after_s(3) == 0.0


def test_a_value_is_at_most_as_old_as_a_step_may_take(rig: _Rig) -> None:
    """Whatever the step takes, its data is no older than 50 ms at the birth of its value."""
    for takes_s in (0.0, 0.02, 0.05, 0.09, 0.3, 0.02):
        rig.takes_s = takes_s
        began_s = rig.now_s
        rig.run(0.4, gap_s=0.4)
        mine = [born_s for _, born_s, stick, _ in rig.sent if stick == (400, 0)]
        assert mine[-1] <= began_s + 0.05 + 1e-9


def test_one_that_is_starved_reports_nothing(rig: _Rig) -> None:
    """Ticks that do not come are a planner that has fallen silent: its value expires."""
    rig.run(0.5)
    last_s = rig.sent[-1][1]
    rig.now_s += 0.3
    rig.run(STEP_S)
    assert rig.lapses() == 1
    assert rig.sent[-2][1] == last_s
