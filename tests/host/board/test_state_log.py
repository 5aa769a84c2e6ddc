"""The board's story in the log."""

import dataclasses
import logging

import pytest

from gazechair.board.state import BoardState
from gazechair.board.state_log import StateLog, fault_names
from gazelink import codes

DISARMED = BoardState(
    state=codes.DISARMED,
    motion=codes.STOPPED,
    override=codes.NO_REASON,
    arm_reason=codes.NO_REASON,
    first_fault=codes.NO_REASON,
    faults=0,
    heading_deg=0.0,
    linear_permille=0,
    turn_permille=0,
    edge=0,
    decisions=0,
    board_ms=100,
    received_s=1.0,
)


def test_only_what_changes_is_told(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    story = StateLog()
    faulty = dataclasses.replace(
        DISARMED, faults=1 << codes.WIPER, first_fault=codes.FAULT_REASON + codes.WIPER
    )
    for state in (DISARMED, dataclasses.replace(DISARMED, board_ms=110), faulty, faulty):
        story.note(state)
    assert [record.levelno for record in caplog.records] == [logging.INFO, logging.WARNING]
    assert "faults wiper, first wiper" in caplog.text
    story.forget()
    story.note(faulty)
    assert len(caplog.records) == 3


def test_fault_names_are_those_of_the_table() -> None:
    assert fault_names(0) == []
    every = sum(1 << fault[0] for fault in codes.FAULTS)
    assert fault_names(every) == [fault[1] for fault in codes.FAULTS]
