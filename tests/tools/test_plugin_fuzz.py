"""The fuzzer of senders: the code keeps the promises, and planted mistakes are found."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from gazechair.driving.arbiter import Arbiter
from gazechair.driving.control import Control
from gazechair.driving.press import DrivingPress, Presses
from gazechair.plugins import value_checks
from gazecontract.fuzz import fuzz
from gazecontract.sender_oracle import Violation


def test_nothing_that_is_said_moves_the_chair_against_the_promises() -> None:
    sent, judged = fuzz(12_000)
    assert sent >= 12_000
    assert judged > 400


def _times_do_not_matter(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(value_checks._Times, "fresh", lambda _self, _born_s: True)


def _future_is_taken(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(value_checks, "_AHEAD_S", 1e9)


_ALWAYS = property(lambda _self: 1e9, lambda _self, _value: None)


def _rest_is_not_needed(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(value_checks.InputRun, "_rested_s", _ALWAYS, raising=False)


def _a_flicker_undoes_a_stop(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(value_checks, "_REST_S", 0.0)


def _ended_presses_come_back(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Presses, "end", lambda _self: None)


def _letting_go_is_not_heard(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(value_checks, "LET_GO", value_checks.Beat(None))


def _a_stop_is_not_heard(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(value_checks, "STOP", value_checks.Beat(None))


def _anyone_drives(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Arbiter, "_may_drive", lambda _self, _client, _page: True)


def _a_mode_lives_for_ever(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(value_checks, "LIFE_S", 9.0)
    steer = DrivingPress.steer
    patch.setattr(DrivingPress, "steer", lambda self, a, b, till_s: steer(self, a, b, till_s + 9.0))


def _a_lost_mode_drives_on(patch: pytest.MonkeyPatch) -> None:
    offer = Control.offer_mode

    def keep(self: Control, mode: str, tile: Any) -> None:
        if tile is not None:
            offer(self, mode, tile)

    patch.setattr(Control, "offer_mode", keep)


def _another_press_is_answered(patch: pytest.MonkeyPatch) -> None:
    says = Arbiter.mode_output

    def any_press(self: Arbiter, mode: str, _number: int, *rest: Any) -> None:
        says(self, *self.mode_press, *rest)

    patch.setattr(Arbiter, "mode_output", any_press)


def _a_life_that_ends_drives_on(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(value_checks.InputRun, "end", lambda _self: None)


MISTAKES: tuple[Callable[[pytest.MonkeyPatch], None], ...] = (
    _times_do_not_matter,
    _future_is_taken,
    _rest_is_not_needed,
    _a_flicker_undoes_a_stop,
    _ended_presses_come_back,
    _letting_go_is_not_heard,
    _a_stop_is_not_heard,
    _anyone_drives,
    _a_mode_lives_for_ever,
    _a_lost_mode_drives_on,
    _another_press_is_answered,
    _a_life_that_ends_drives_on,
)


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake.__name__.strip("_"))
def test_a_mistake_is_found(
    mistake: Callable[[pytest.MonkeyPatch], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    mistake(monkeypatch)
    with pytest.raises(Violation, match="seed"):
        fuzz(60_000)
