"""The board's settings from a caretaker's phone: a few, checked, and only while driving is off."""

from __future__ import annotations

import json
from typing import Any

import pytest

from gazechair.board.caretaker_settings import ALLOWED
from gazelink import codes
from gazelink.settings_table import TABLE, index_of

LINEAR = index_of("linear_permille")
PROFILE = index_of("profile")
STEP = index_of("step_forward_ms")


@pytest.fixture
def caretaker(visitor: Any) -> Any:
    return visitor("caretaker")


def test_the_settings_are_read_with_their_limits(caretaker: Any) -> None:
    status, _, raw = caretaker.get("/settings")
    settings = json.loads(raw)["settings"]
    assert status == 200
    assert set(settings) == set(ALLOWED)
    assert settings["linear_permille"] == {"value": 600, "low": 50, "high": 1000, "default": 600}


def test_a_change_is_in_force_and_saved(caretaker: Any, board: Any) -> None:
    posted = {"set": {"linear_permille": 400, "step_forward_ms": 1000}}
    status, _, answer = caretaker.post("/settings", posted)
    assert status == 200
    assert answer["settings"]["linear_permille"]["value"] == 400
    assert board.saved[LINEAR] == 400


@pytest.mark.parametrize(
    ("values", "status", "reason"),
    [
        ({"linear_permille": 1001}, 400, "setting_out_of_range"),
        ({"linear_permille": "500"}, 400, "setting_out_of_range"),
        ({"linear_permille": True}, 400, "setting_out_of_range"),
        ({"relay_fitted": 0}, 400, "setting_unknown"),
        ({"stop_margin_mm": 50}, 400, "setting_unknown"),
        ({"x" * 300: 1}, 400, "setting_unknown"),
        ([1], 400, "bad_message"),
        (None, 400, "bad_message"),
    ],
)
def test_a_bad_request_changes_nothing(
    caretaker: Any, board: Any, values: Any, status: int, reason: str
) -> None:
    if isinstance(values, dict):
        values = {"turn_permille": 321, **values}  # nor the good half of it
    found, _, answer = caretaker.post("/settings", {"set": values})
    assert (found, answer["reason"]) == (status, reason)
    assert 321 not in board.values
    assert board.saved == []


def test_while_driving_is_on_nothing_changes(caretaker: Any, board: Any) -> None:
    board.armed = True
    found, _, answer = caretaker.post("/settings", {"set": {"linear_permille": 400}})
    assert (found, answer["reason"]) == (409, "setting_while_armed")
    assert board.values[LINEAR] == 600
    assert caretaker.get("/settings")[0] == 200


def test_while_a_step_of_the_first_drive_uses_them_nothing_changes(
    caretaker: Any, board: Any, steps: Any
) -> None:
    steps.holds_settings = True
    found, _, answer = caretaker.post("/settings", {"set": {"linear_permille": 400}})
    assert (found, answer["reason"]) == (409, "first_busy")
    assert board.values[LINEAR] == 600
    assert caretaker.get("/settings")[0] == 200


def test_without_a_measured_neutral_nothing_changes(caretaker: Any, board: Any) -> None:
    board.faults = 1 << codes.CALIBRATION
    found, _, answer = caretaker.post("/settings", {"set": {"profile": 2}})
    assert (found, answer["reason"]) == (409, "setting_by_calibration")
    assert board.values[index_of("profile")] == TABLE[index_of("profile")][1]
    assert board.saved == []


def test_the_board_has_the_last_word(caretaker: Any, board: Any) -> None:
    board.refuses = lambda *_: codes.SETTING_NOT_STORED
    found, _, answer = caretaker.post("/settings", {"set": {"linear_permille": 400}})
    assert (found, answer["reason"]) == (507, "setting_not_stored")


@pytest.mark.parametrize(
    "refused",
    [(codes.SETTING_SAVE, 0), (codes.SETTING_SET, STEP)],
    ids=["not stored", "the second one"],
)
def test_what_is_not_stored_does_not_stay_in_force(
    caretaker: Any, board: Any, refused: tuple[int, int]
) -> None:
    before = list(board.values)
    board.refuses = lambda *requested: codes.SETTING_NOT_STORED if requested == refused else 0
    posted = {"set": {"linear_permille": 1000, "step_forward_ms": 1000}}
    found, _, answer = caretaker.post("/settings", posted)
    assert (found, answer["reason"]) == (507, "setting_not_stored")
    assert board.values == before


@pytest.mark.parametrize("lost", [2, 3])
def test_what_was_stored_unheard_is_set_back_in_the_flash_too(
    caretaker: Any, board: Any, lost: int
) -> None:
    before = list(board.values)
    board.unanswered_saves = lost
    found, _, answer = caretaker.post("/settings", {"set": {"linear_permille": 1000}})
    assert (found, answer["reason"]) == (503, "not_connected")
    assert board.values == board.saved == before


def test_half_of_what_was_set_back_is_not_saved(caretaker: Any, board: Any) -> None:
    before, lost = list(board.values), []

    def loses(request: int, index: int, value: int) -> bool:
        back = request == codes.SETTING_SET and (index, value) == (LINEAR, before[LINEAR])
        lose = request == codes.SETTING_SAVE or back
        lost.extend([request] * lose)
        return lose and len(lost) <= 4  # both tries of each

    board.loses = loses
    found, _, answer = caretaker.post("/settings", {"set": {"profile": 4, "linear_permille": 1000}})
    assert (found, answer["reason"]) == (503, "not_connected")
    assert board.saved == []
    assert board.values[PROFILE] == before[PROFILE]  # what can be set back is


def test_a_board_that_restarts_before_it_saves_has_stored_nothing(
    caretaker: Any, board: Any
) -> None:
    before = list(board.values)
    board.restarts = True
    found, _, answer = caretaker.post("/settings", {"set": {"linear_permille": 1000}})
    assert (found, answer["reason"]) == (503, "not_connected")
    assert board.values == board.saved == before


def test_what_was_stored_unheard_and_then_refused_is_set_back_in_the_flash_too(
    caretaker: Any, board: Any
) -> None:
    before = list(board.values)
    board.unanswered_saves = 1
    saves = iter([0, codes.SETTING_NOT_STORED])
    board.refuses = lambda request, _: next(saves, 0) if request == codes.SETTING_SAVE else 0
    found, _, answer = caretaker.post("/settings", {"set": {"linear_permille": 1000}})
    assert (found, answer["reason"]) == (507, "setting_not_stored")
    assert board.values == board.saved == before


def test_without_a_board_it_says_so(caretaker: Any, board: Any) -> None:
    board.connected = False
    assert caretaker.get("/settings")[0] == 503
    assert caretaker.post("/settings", {"set": {"profile": 1}})[2]["reason"] == "not_connected"


@pytest.mark.parametrize("role", ["driver", "viewer"])
def test_only_a_caretaker_may(visitor: Any, board: Any, role: str) -> None:
    device = visitor(role)
    assert device.get("/settings")[0] == 403
    assert device.post("/settings", {"set": {"linear_permille": 400}})[2]["reason"] == "not_allowed"
    assert board.values[LINEAR] == 600
