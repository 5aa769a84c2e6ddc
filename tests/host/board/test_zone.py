"""The board's stop zone: known once all directions have arrived, until its settings change."""

from __future__ import annotations

from typing import Any

import pytest

from gazechair.board.zone import NOT_KNOWN, BoardZone
from gazelink import codes
from gazesim.zone import reported_zone

POINTS = reported_zone().points


def zones(events: list[Any]) -> list[BoardZone]:
    return [event for event in events if isinstance(event, BoardZone)]


def tell(line: Any) -> list[BoardZone]:
    frames = b"".join(line.board.zone(at, POINTS[at]) for at in range(4))
    return zones(line.say(frames))


def test_it_is_an_event_once_all_directions_are_said(joined: Any) -> None:
    for at in (0, 1, 2):
        assert zones(joined.say(joined.board.zone(at, POINTS[at]))) == []
    assert zones(joined.say(joined.board.zone(3, POINTS[3]))) == [BoardZone(POINTS)]
    assert tell(joined) == []  # again: nothing new


@pytest.mark.parametrize(
    "request_",
    [
        codes.SETTING_SET,
        codes.SETTING_DEFAULTS,
        codes.SETTING_SAVE,
        codes.SETTING_SET_NEUTRAL,
    ],
)
def test_a_change_makes_it_unknown_until_it_is_told_anew(joined: Any, request_: int) -> None:
    assert tell(joined) == [BoardZone(POINTS)]
    assert zones(joined.say(joined.board.setting_reply(request=request_))) == [NOT_KNOWN]
    assert tell(joined) == [BoardZone(POINTS)]


def test_reading_a_setting_and_a_refusal_change_nothing(joined: Any) -> None:
    assert tell(joined) == [BoardZone(POINTS)]
    for reply in (
        {"request": codes.SETTING_GET},
        {"request": codes.SETTING_SET, "refused": codes.SETTING_OUT_OF_RANGE},
    ):
        assert zones(joined.say(joined.board.setting_reply(**reply))) == []


def test_no_direction_there_is_no_zone(joined: Any) -> None:
    for at in (4, 200, 255):
        assert zones(joined.say(joined.board.zone(at, POINTS[0]))) == []
    assert tell(joined) == [BoardZone(POINTS)]
