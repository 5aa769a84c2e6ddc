"""The record of missions, docs/missions.json; a change of a file they depend on starts it anew."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np

from gazemeasure import on_record
from gazemeasure.on_record import Job, Record, Row
from gazesetup import ROOT

FILE = on_record.file_of("missions.json")
_HERE = Path(__file__).parent
# Missions depend on these files and on everything that they import.
_BEGINS = (
    *(_HERE / name for name in ("missions.py", "scenes.py", "another.py")),
    ROOT / "firmware/gazeboard/main.py",
)


class Result(Protocol):
    """The result of one mission: a dataclass whose fields JSON can represent."""

    @property
    def job(self) -> Job: ...
    @property
    def arrived(self) -> bool: ...
    @property
    def collisions(self) -> int: ...
    @property
    def ratio(self) -> float: ...


R = TypeVar("R", bound=Result)


def gather(
    jobs: Sequence[Job],
    run: Callable[[Job], R],
    load: Callable[[Row], R],
    processes: int,
    file: Path | None,
) -> list[R]:
    """The result of each job; jobs without a result in `file` are run, and stored there.

    `load`: makes a result from its JSON fields. `file`: None stores nothing.
    """
    of = "" if file is None else digest()
    record = Record(file, of, _row, lambda row: load(row["result"]), _summary)
    return record.gather({f"{job.kind} {job.seed}": job for job in jobs}, run, processes)


def digest() -> str:
    """One digest of all files that missions depend on."""
    return on_record.digest(_BEGINS)


def _row(one: Result) -> Row:
    """A result as a JSON row, with common fields for every kind."""
    return {
        "kind": one.job.kind,
        "arrived": one.arrived,
        "collisions": one.collisions,
        "ratio": one.ratio,
        "result": asdict(one),  # type: ignore[call-overload]
    }


def _summary(rows: list[Row]) -> Row:
    kinds = sorted({row["kind"] for row in rows})
    return {
        "kinds": {kind: _of_kind([one for one in rows if one["kind"] == kind]) for kind in kinds}
    }


def _of_kind(done: list[Row]) -> Row:
    ratios = [row["ratio"] for row in done if row["arrived"]]
    return {
        "missions": len(done),
        "arrived": sum(row["arrived"] for row in done),
        "collisions": sum(row["collisions"] for row in done),
        "time by the ideal, median": round(float(np.median(ratios)), 3) if ratios else None,
    }
