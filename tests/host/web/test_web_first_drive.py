"""The first drive on a caretaker's phone: its state, beginning a step; only there."""

from __future__ import annotations

import json
from typing import Any

import pytest


def test_a_caretaker_sees_and_does_the_steps(visitor: Any, steps: Any) -> None:
    caretaker = visitor("caretaker")
    status, _, raw = caretaker.get("/first-drive")
    assert (status, json.loads(raw)) == (200, steps.status())
    assert caretaker.post("/first-drive", {"run": "mask"})[0] == 200
    assert steps.received == [{"run": "mask"}]


@pytest.mark.parametrize(("reason", "status"), [("lidar_lost", 409), ("bad_message", 400)])
def test_a_refusal_has_its_reason(visitor: Any, steps: Any, reason: str, status: int) -> None:
    steps.refusal = reason, "why"
    answered, _, answer = visitor("caretaker").post("/first-drive", {"run": "mask"})
    assert (answered, answer["reason"], answer["detail"]) == (status, reason, "why")


@pytest.mark.parametrize("role", ["driver", "viewer"])
def test_nobody_else_may(visitor: Any, steps: Any, role: str) -> None:
    other = visitor(role)
    assert other.get("/first-drive")[0] == 403
    assert other.post("/first-drive", {"run": "mask"})[0] == 403
    assert steps.received == []
