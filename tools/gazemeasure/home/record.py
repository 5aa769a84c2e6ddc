"""The record of the starts of `gazechair measure home`, docs/starts.json: a row per home."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

from gazemeasure import on_record
from gazemeasure.home.localization import Counted
from gazemeasure.on_record import Record, Row
from gazemeasure.pools import PROCESSES

FILE = on_record.file_of("starts.json")
_BEGINS = (Path(__file__).with_name("localization.py"),)


def starts(
    run: Callable[[int], Counted], homes: Sequence[int], file: Path | None = FILE
) -> list[Counted]:
    """The starts in each home; those without a row in the record are run, and stored there."""
    of = "" if file is None else on_record.digest(_BEGINS)
    record = Record(file, of, asdict, lambda row: Counted(**row), _summary)
    return record.gather({f"{home:03}": home for home in homes}, run, PROCESSES)


def _summary(rows: list[Row]) -> Row:
    """How many starts of each kind were right, wrong, and without a claim."""
    told: dict[str, Counter[str]] = {}
    for row in rows:
        for result in ("right", "wrong", "unknown"):
            for kind, count in row[result].items():
                told.setdefault(kind, Counter())[result] += count
    return {
        "homes": len(rows),
        "kinds": {kind: dict(counts) for kind, counts in sorted(told.items())},
        "claims in homes that are not on the map": sum(sum(row["elsewhere"]) for row in rows),
        "carried away": sum(len(row["lost_after_s"]) for row in rows),
        "noticed after, most, s": max(max(row["lost_after_s"], default=0.0) for row in rows),
    }
