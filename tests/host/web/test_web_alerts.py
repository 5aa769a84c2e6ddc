"""The alerts on a caretaker's phone: read, acknowledged with its name, tested; only there."""

from __future__ import annotations

import json
from typing import Any

import pytest


@pytest.fixture
def caretaker(visitor: Any) -> Any:
    return visitor("caretaker")


def test_a_caretaker_reads_them(caretaker: Any, alerts: Any) -> None:
    status, _, raw = caretaker.get("/alerts")
    assert (status, json.loads(raw)) == (200, alerts.as_json())


def test_who_acknowledges_or_tests_is_the_paired_device(caretaker: Any, alerts: Any) -> None:
    assert caretaker.post("/alerts", {"acknowledge": 3})[0] == 200
    assert caretaker.post("/alerts", {"test": True})[0] == 200
    assert [what for what, _ in alerts.received] == [3, "test"]
    assert len({by for _, by in alerts.received}) == 1
    assert alerts.received[0][1]


@pytest.mark.parametrize(
    "posted", [{}, {"acknowledge": "3"}, {"acknowledge": True}, {"test": 1}, {"test": True, "x": 1}]
)
def test_what_is_no_request_is_refused(caretaker: Any, alerts: Any, posted: dict[str, Any]) -> None:
    status, _, answer = caretaker.post("/alerts", posted)
    assert (status, answer["reason"], alerts.received) == (400, "bad_message", [])


@pytest.mark.parametrize("role", ["driver", "viewer"])
def test_nobody_else_may(visitor: Any, alerts: Any, role: str) -> None:
    other = visitor(role)
    assert other.get("/alerts")[0] == 403
    assert other.post("/alerts", {"test": True})[0] == 403
    assert alerts.received == []
