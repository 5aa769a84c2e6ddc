"""The clearance as sent to a page."""

from __future__ import annotations

from gazechair.board.board_commands import Clearance
from gazechair.sensing.clearance.shown import shown
from gazelink import codes

NOW_S = 100.0
OLD_S = 0.3


def test_ways_and_views_by_direction() -> None:
    clearance = Clearance(0b0010, codes.REAL, NOW_S - 0.1, 0b1000, 1234, 500, 20 * 16 + 9)
    reported = shown(clearance, NOW_S, OLD_S)
    assert reported == {
        "clearance": {"forward": 1.23, "backward": 0.5, "left": 21.0, "right": None},
        "view": {"forward": "seen", "backward": "blind", "left": "seen", "right": "unseen"},
    }


def test_nothing_or_old_is_blind() -> None:
    for clearance in (None, Clearance(0, codes.REAL, NOW_S - 0.31, forward_mm=1000)):
        reported = shown(clearance, NOW_S, OLD_S)
        assert set(reported["view"].values()) == {"blind"}
        assert set(reported["clearance"].values()) == {None}
