"""The error handler: all problems become one level and one message."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gazechair.base.health import DEGRADED, LOST, OK, STARTING, HealthState
from gazechair.board.state import BoardState
from gazechair.driving.error_handler import (
    ErrorHandler,
    Problem,
    Verdict,
    of_board,
    of_host,
    of_parts,
    of_silence,
)
from gazelink import codes

QUIET = BoardState(0, 0, 0, 0, 0, 0, 0.0, 170, 170, 0, 0, 0, 0.0)


def part(state: str, reason: str = "ok") -> HealthState:
    return HealthState(state, reason, "", 0.0)


def test_nothing_wrong_is_ok() -> None:
    problems = of_board(QUIET) + of_parts({"board": part(OK), "lidar": part(OK)})
    assert ErrorHandler().fold(problems, 1.0) == Verdict("ok", "ok")


@pytest.mark.parametrize("fault", codes.FAULTS, ids=lambda fault: str(fault[1]))
def test_every_fault_bit_has_its_name_and_severity(fault: tuple[int, str, int, bool]) -> None:
    bit, name, severity, _ = fault
    (problem,) = of_board(replace(QUIET, faults=1 << bit))
    assert problem == Problem(name, severity)


def test_an_override_is_a_warning_unless_it_names_a_fault() -> None:
    handler = ErrorHandler()
    overruled = replace(QUIET, override=codes.OBSTACLE_FORWARD)
    assert handler.fold(of_board(overruled), 0) == Verdict("warning", "obstacle_forward")
    faulty = replace(QUIET, override=codes.FAULT_REASON + codes.TILT, faults=1 << codes.TILT)
    assert handler.fold(of_board(faulty), 1) == Verdict("error", "tilt")


def test_alerts_that_cannot_leave_are_the_caretakers_to_know() -> None:
    """No list on the page shows what the broker did not get."""
    for state, reason in ((DEGRADED, "alerts_mqtt"), (LOST, "alerts_lost")):
        (problem,) = of_parts({"alerts": part(state, reason)})
        assert problem == Problem(reason, codes.WARNING, caretaker_only=True)
    assert of_parts({"alerts": part(STARTING, "alerts_starting")}) == []


def test_the_most_severe_is_shown_then_the_oldest() -> None:
    handler = ErrorHandler()
    old, new = Problem("tilt", codes.ERROR), Problem("wiper", codes.ERROR)
    warning = Problem("heading_bus", codes.WARNING)
    assert handler.fold([warning], 0).message == "heading_bus"
    assert handler.fold([warning, old], 1).message == "tilt"
    assert handler.fold([new, warning, old], 2).message == "tilt"
    assert handler.fold([new, warning], 3).message == "wiper"
    assert handler.fold([old, new], 4).message == "wiper"  # tilt went and came back
    assert handler.fold([], 5) == Verdict("ok", "ok")


def test_a_lidar_that_is_lost_is_told_rather_than_that_its_data_are_old() -> None:
    handler = ErrorHandler()
    fault = codes.FAULT_REASON + codes.OBSTACLE_DATA_OLD
    board = replace(QUIET, override=fault, faults=1 << codes.OBSTACLE_DATA_OLD)

    def reported(lidar: HealthState, age_s: float, now_s: float) -> str:
        problems = of_host({"lidar": lidar}, board, age_s, None, False)
        return handler.fold(problems, now_s).message

    assert reported(part(OK), 0.4, 0.0) == "obstacle_data_old"
    assert reported(part(LOST, "lidar_silent"), 0.5, 0.1) == "lidar_silent"
    assert reported(part(DEGRADED, "lidar_damaged"), 0.6, 0.2) == "obstacle_data_old"
    assert reported(part(OK), 2.1, 1.8) == "lidar_lost"  # its process has stopped


@pytest.mark.parametrize(
    ("name", "state", "level"),
    [
        ("board", STARTING, "warning"),
        ("board", LOST, "error"),
        ("lidar", DEGRADED, "warning"),
        ("lidar", LOST, "error"),
        ("camera", STARTING, "ok"),
        ("camera", LOST, "warning"),
    ],
)
def test_parts_by_severity(name: str, state: str, level: str) -> None:
    problems = of_parts({name: part(state, f"{name}_{state}")})
    verdict = ErrorHandler().fold(problems, 0.0)
    assert verdict.level == level
    if level != "ok":
        assert verdict.message == f"{name}_{state}"


def test_a_source_silent_for_2_s_is_told() -> None:
    assert of_silence("lidar", None) == []
    assert of_silence("lidar", 2.0) == []
    assert of_silence("lidar", 2.1) == [Problem("lidar_lost", codes.ERROR)]
    assert of_silence("camera", 2.1) == [Problem("camera_lost", codes.WARNING)]
