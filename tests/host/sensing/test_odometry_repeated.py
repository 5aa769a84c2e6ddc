"""After a gap, scans that repeat the view before it are old, whatever their times."""

from __future__ import annotations

import pytest

from gazechair.sensing.odometry.repeated import repeats

ON = [600] * 15


def test_a_chair_that_went_on_and_has_not_moved_is_seen_in_old_scans() -> None:
    assert repeats(0.3, 0.4, 0.01, ON)
    assert repeats(0.3, -0.4, -0.02, [-600] * 15)


@pytest.mark.parametrize(
    ("gap_s", "speed_m_s", "moved_m", "outputs"),
    [
        (0.3, 0.4, 0.12, ON),  # it moved on
        (0.06, 0.4, 0.0, ON),  # no gap
        (0.3, 0.02, 0.0, ON),  # it stood
        (0.3, 0.4, 0.0, [600] * 7 + [0] * 8),  # it was stopped
        (0.3, 0.4, 0.0, [600] * 7 + [None] * 8),
        (0.3, 0.4, 0.0, []),  # the board was silent, too
        (0.3, 0.4, -0.02, [600] * 7 + [-600] * 8),
    ],
)
def test_all_else_is_no_sign_of_it(
    gap_s: float, speed_m_s: float, moved_m: float, outputs: list[int | None]
) -> None:
    assert not repeats(gap_s, speed_m_s, moved_m, outputs)
