"""The benchmark of line following: one short drive whose tape is gone after some seconds."""

from __future__ import annotations

from gazechair.following.line import State
from gazemeasure.go_line import Job, drive


def test_a_drive_is_judged_by_the_truth() -> None:
    found = drive(Job(2, "3.1", "tape"))
    assert not found.chosen
    assert found.state is State.LOST
    assert found.near > 0.95
    assert found.worst_m < 0.1
    assert found.lost_s <= 0.3
    assert found.rolled_m < 0.5
