"""Which steps of the first drive count as done, from what the board says of itself."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from controlrig import QUIET
from gazechair.first_drive.facts import NEUTRALS, Facts
from gazechair.first_drive.record import Record
from gazelink import codes
from gazelink.settings_table import TABLE

DEFAULTS = {name: default for name, default, _, _ in TABLE}


def neutral(tmp_path: Path, linear: int, turn: int, recorded: bool, faults: int) -> bool:
    """Is the joystick's neutral set?"""
    record = Record(tmp_path)
    if recorded:
        record.keep("neutral", [linear, turn])
    settings = {**DEFAULTS, **dict(zip(NEUTRALS, (linear, turn), strict=True))}
    state = replace(QUIET, faults=faults, settings=settings)
    facts = Facts(state, None, None, {}, None, (), record, "", None)
    (row,) = [row for row in facts.rows() if row["step"] == "neutral"]
    assert row["counts"] == [linear, turn]
    return bool(row["done"])


@pytest.mark.parametrize(
    ("linear", "turn", "recorded", "done"),
    [(170, 170, False, False), (170, 170, True, True), (170, 172, False, True)],
    ids=["the defaults", "defaults that were measured", "others"],
)
def test_a_neutral_is_set_once_it_is_measured_and_stored(
    tmp_path: Path, linear: int, turn: int, recorded: bool, done: bool
) -> None:
    assert neutral(tmp_path, linear, turn, recorded, 0) is done
    assert not neutral(tmp_path, linear, turn, recorded, 1 << codes.CALIBRATION)
