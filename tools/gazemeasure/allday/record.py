"""Stores the day in virtual time, with a digest of the files that it ran: docs/allday.json."""

from __future__ import annotations

import json
from pathlib import Path

from gazemeasure import on_record
from gazemeasure.report import Report
from gazesetup import ROOT

FILE = on_record.file_of("allday.json")
# A life runs these files and everything that they import.
_BEGINS = (Path(__file__).with_name("chair.py"), ROOT / "firmware/gazeboard/main.py")


def digest() -> str:
    """One digest of all files that a life runs."""
    return on_record.digest(_BEGINS)


def write(day: Report, file: Path | None = FILE) -> None:
    """Store the figures of a whole day; its first figure is the hours that were driven."""
    if file is not None:
        on_record.write(file, {"of": digest(), **json.loads(day.json())})


def sentence(file: Path | None = FILE) -> str:
    """What is on record, and whether the files are still the same."""
    if file is None or not file.exists():
        return "No whole day in virtual time is on record."
    record = json.loads(file.read_text())
    hours = record["figures"][0]["value"]
    kept = "within its limits" if record["ok"] else "it FELL SHORT"
    same = "these" if record["of"] == digest() else "other"
    return f"On record: a day of {hours:.1f} h, {kept}, with {same} files ({file.name})."
