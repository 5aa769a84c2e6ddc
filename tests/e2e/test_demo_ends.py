"""`tools/demo` takes all it started with it, however and whenever it is ended."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator

import pytest

from e2e.demo_family import LIMIT_S, RUNNING, Family

# Odometry is not ready in the time that the demo gives it beside pages and emulated boards.
pytestmark = pytest.mark.e2e

BOARD_STARTS = "* simulator and firmware"
HOST_STARTS = "* host and driver's page"
CASES = [
    (signal.SIGTERM, RUNNING),
    (signal.SIGKILL, RUNNING),
    (signal.SIGINT, BOARD_STARTS),
    (signal.SIGHUP, HOST_STARTS),
    (signal.SIGKILL, HOST_STARTS),
]


@pytest.fixture
def family(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Family]:
    family = Family(tmp_path_factory.mktemp("d"))
    yield family
    family.end()


@pytest.mark.parametrize(
    ("number", "moment"), CASES, ids=lambda value: getattr(value, "name", None)
)
def test_a_demo_that_is_ended_leaves_nothing_running(
    family: Family, number: signal.Signals, moment: str
) -> None:
    family.until(moment)
    if moment == RUNNING:
        assert len(family.alive()) >= 4  # demo, simulator, board, host
    family.demo.send_signal(number)
    end_s = time.monotonic() + LIMIT_S
    while family.alive() and time.monotonic() < end_s:
        time.sleep(0.02)
    assert family.alive() == []
    assert family.demo.wait(LIMIT_S) == (-signal.SIGKILL if number == signal.SIGKILL else 0)
