"""A flood of refusals makes only a few log lines."""

from __future__ import annotations

import logging
import threading

import pytest

from gazechair.base.throttled_log import ThrottledLog


def test_a_flood_is_a_few_lines_and_a_number(caplog: pytest.LogCaptureFixture) -> None:
    now_s = 0.0
    throttled = ThrottledLog(logging.getLogger("door"), lambda: now_s)
    with caplog.at_level(logging.WARNING):
        for _ in range(10_000):
            throttled.warn("refused %s", "192.0.2.1")
        assert len(caplog.messages) == 20
        now_s = 5.0
        throttled.warn("refused %s", "192.0.2.2")
    assert caplog.messages[-1] == "refused 192.0.2.2 (and 9980 more before)"
    assert len(caplog.messages) == 21


def test_an_ended_thread_is_one_throttled_line(caplog: pytest.LogCaptureFixture) -> None:
    throttled = ThrottledLog(logging.getLogger("threads"), lambda: 0.0)
    for _ in range(100):
        try:
            raise ValueError("what a stranger sent")
        except ValueError as error:
            args = (ValueError, error, error.__traceback__, threading.current_thread())
            throttled.thread_ended(threading.ExceptHookArgs(args))
    assert len(caplog.messages) == 20
    assert "MainThread ended by ValueError('what a stranger sent')" in caplog.messages[0]
    assert "Traceback" in caplog.text
