"""The table of reasons has a row and texts for everything that a part can report, and no more."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import gazechair
from gazechair.base.health import Health
from gazechair.base.languages import languages, message
from gazechair.base.reasons import FILE_REASONS, NOTE, PARTS, PLUGIN, REASONS, THEN, WHO
from gazelink import codes

HOST = Path(gazechair.__file__).parent
SOURCES = {path: path.read_text("utf-8") for path in HOST.rglob("*.py")}
# A health state with its reason, in one call or in two lines; a constant that is one; and how
# the supervisor loses a child, of which plug-ins make a reason.
SET = re.compile(r'(?:h|states|health)\.(?:LOST|DEGRADED|STARTING),\s*"(\w+)"')
PROBLEM = re.compile(r'Problem\("(\w+)"')
CONSTANT = re.compile(rf'^[A-Z_]+ = "((?:{"|".join(PARTS)})_\w+)"', re.M)
HOW = re.compile(r'_lost\("(\w+)"')


ALL = {**REASONS, **FILE_REASONS}


def reported() -> set[str]:
    """All that the host's code, the link and the board's tables name."""
    found = {*codes.REASONS[1:], *(name for _, name, *_ in codes.FAULTS)}
    for path, text in SOURCES.items():
        if path.parent.name == "alerts" and path.stem != "sender":
            continue  # kinds of alerts
        found |= {*SET.findall(text), *PROBLEM.findall(text)}
        found |= {*CONSTANT.findall(text)} - {"board_program"}  # a file of `gazechair calibrate`
    found |= {f"{PLUGIN}_{how}" for how in HOW.findall(SOURCES[HOST / "base" / "supervisor.py"])}
    started = {Health(name).reason for name in PARTS if name not in (PLUGIN, "host", "motion")}
    return found | started | {Health("mode some").reason}


def test_every_reason_that_is_reported_has_a_row_and_no_row_is_unused() -> None:
    assert set(REASONS) == reported()


@pytest.mark.parametrize("language", languages())
def test_every_row_has_texts(language: str) -> None:
    for key in {*REASONS, *FILE_REASONS}:
        text, _ = message(language, key)
        assert text, key


def test_who_must_do_something_is_told_what() -> None:
    silent = {key for key, row in ALL.items() if row.severity > NOTE and not message("en", key)[1]}
    assert silent == {"setting_unknown"}


def test_rows_use_the_words_there_are() -> None:
    for key, row in ALL.items():
        assert row.severity in (NOTE, codes.WARNING, codes.ERROR), key
        assert row.who in WHO, key
        assert row.then in THEN, key


def test_a_row_is_as_severe_as_its_part() -> None:
    """The pages take the severity from the health state; the row gives its maximum."""
    for key, row in REASONS.items():
        part = PARTS.get(key.split("_")[0])
        if part and part.severity and row.severity != NOTE and key not in _FAULTS:
            assert row.severity in part.severity.values(), key


_FAULTS = {name for _, name, *_ in codes.FAULTS}


def test_a_source_is_silent_after_its_own_time() -> None:
    assert {name: part.silent_s for name, part in PARTS.items()} == {
        "board": 2.0,
        "lidar": 2.0,
        "odometry": 2.0,
        "motion": 2.0,
        "map": 3.0,
        "assist": 2.0,
        "camera": 2.0,
        "host": 2.0,
        "log": 3.0,
        "alerts": 3.0,
        "plugin": 1.0,
    }
