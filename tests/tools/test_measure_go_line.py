"""The benchmark of line following: one short drive whose tape is gone after some seconds."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gazechair.following import line
from gazechair.following.line import State
from gazemeasure.go import line as go_line
from gazemeasure.go.line import Driven, Job, add_drives, add_lost, drive
from gazemeasure.report import Report

pytestmark = pytest.mark.costly

GOOD = Driven("", 1, State.ENDED, 1.0, 0.02, 1.0, 0.05, 0.0, 0.0, 0.3, 0.0)
CUT = replace(GOOD, state=State.LOST, lost_s=0.3, rolled_m=0.2, cut_m_s=0.3)


def verdict(add, *of) -> bool:
    report = Report("")
    add(report, *of)
    return report.ok


def test_a_drive_that_stops_early_has_not_followed_the_rest_of_the_tape() -> None:
    assert verdict(add_drives, [GOOD])
    assert not verdict(add_drives, [replace(GOOD, followed=0.3)])


@pytest.mark.parametrize("bad", [{"chosen": "refused"}, {"state": State.LOST}])
def test_nearly_all_find_the_tape_and_end_with_it(bad: dict[str, object]) -> None:
    assert verdict(add_drives, [GOOD] * 19 + [replace(GOOD, **bad)])
    assert not verdict(add_drives, [GOOD] * 9 + [replace(GOOD, **bad)])
    assert not verdict(add_drives, [replace(GOOD, **bad)])


def test_lost_is_judged_by_the_issues_time_on_chairs_that_moved(monkeypatch) -> None:
    monkeypatch.setattr(line, "LOST_S", 9.0)
    assert not hasattr(go_line, "LOST_S")
    assert verdict(add_lost, "tape", [CUT])
    assert not verdict(add_lost, "tape", [replace(CUT, lost_s=0.35)])
    assert not verdict(add_lost, "tape", [replace(CUT, cut_m_s=0.0, lost_s=0.0)])
    assert not verdict(add_lost, "tape", [])


def test_a_drive_is_judged_by_the_truth() -> None:
    found = drive(Job(2, "3.1", "tape"))
    assert not found.chosen
    assert found.state is State.LOST
    assert found.near > 0.95
    assert found.worst_m < 0.1
    assert found.lost_s <= 0.3
    assert found.rolled_m < 0.5
    assert found.cut_m_s > 0.1
