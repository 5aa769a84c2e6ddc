"""The benchmark of going somewhere: one mission judged by the truth, and the ideal time."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gazechair.going.plan import Path
from gazemeasure.go.benchmark import add_comfort, add_kind
from gazemeasure.go.ideal import Permitted, ideal_s
from gazemeasure.go.missions import (
    DOORS,
    HOMES,
    KINDS,
    ONE,
    PEOPLE,
    TWO,
    Job,
    Result,
    mission,
)
from gazemeasure.go.rig import Go
from gazemeasure.report import Report
from gazemeasure.turn.board import settings_with
from goingrig import numbers

pytestmark = pytest.mark.costly


def test_a_mission_is_judged_by_the_truth() -> None:
    found = mission(Job(DOORS, 2))
    assert found.collisions == 0
    assert found.arrived, found.why
    assert found.least_m > 0.0


def result(kind: str, **of: Any) -> Result:
    return replace(Result(Job(kind, 1), True, 0, 0.1, 1.2, 0.6, 2.2, ""), **of)


def kind_ok(kind: str, *done: Result) -> bool:
    report = Report("")
    add_kind(report, kind, list(done))
    return report.ok


@pytest.mark.parametrize("kind", KINDS)
def test_missions_of_every_kind_must_arrive(kind: str) -> None:
    assert kind_ok(kind, result(kind))
    assert not kind_ok(kind, *[result(kind)] * 9, result(kind, arrived=False))
    assert not kind_ok(kind, result(kind, collisions=1))
    most = [result(kind)] * 24 + [result(kind, arrived=False)]
    assert kind_ok(kind, *most) == (kind not in (TWO, DOORS, HOMES))


def test_time_and_comfort_are_bounded() -> None:
    assert not kind_ok(ONE, result(ONE, ratio=1.4))
    assert kind_ok(PEOPLE, result(PEOPLE, ratio=1.6))
    for of, ok in (({}, True), ({"acceleration": 1.2}, False), ({"jerk": 4.0}, False)):
        report = Report("")
        add_comfort(report, [result(TWO, **of)])
        assert report.ok == ok


def test_a_plan_is_ready_when_planning_would_be() -> None:
    go: Any = Go.__new__(Go)
    go.now_ms, go.outcome = 1000, SimpleNamespace(plan_s=[])
    planned = go._submit(lambda: None)
    go.now_ms = 1300
    assert planned.done()

    def slowly() -> None:
        end_s = time.process_time() + 0.4
        while time.process_time() < end_s:
            pass

    planned = go._submit(slowly)
    go.now_ms = 1690
    assert not planned.done()
    go.now_ms = round(1300 + 1000 * go.outcome.plan_s[-1]) + 1
    assert planned.done()


def test_the_ideal_is_the_way_at_the_permitted_speed_and_its_turns() -> None:
    full = {"profile": 2, "linear_permille": 1000, "turn_permille": 1000}
    permitted = Permitted(settings_with(full), numbers(), False)
    assert 0.15 < permitted.m_s <= numbers().cap_m_s
    assert 15.0 < permitted.deg_s < numbers().left_deg_s
    straight = Path(np.array(((0.0, 0.0), (3.5, 0.0))), None)
    way_s = 3.5 / permitted.m_s
    assert ideal_s(straight, (0.0, 0.0, 0.0), permitted) == way_s
    turned = ideal_s(straight, (0.0, 0.0, math.pi / 2), permitted)
    assert way_s + 90.0 / permitted.deg_s < turned < way_s + 90.0 / permitted.deg_s + 3.0
