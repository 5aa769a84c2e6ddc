"""Stores results of missions one by one, so that an interrupted run of the full set is resumed.

docs/missions.json has the results, and a digest of the files that they depend on: when one of these
changes, all missions start again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Protocol, TypeVar

import numpy as np

from gazemeasure import on_record
from gazesetup import ROOT

FILE = on_record.file_of("missions.json")
_HERE = Path(__file__).parent
# Missions depend on these files and on everything that they import.
_BEGINS = (
    *(_HERE / name for name in ("missions.py", "scenes.py", "another.py")),
    ROOT / "firmware/gazeboard/main.py",
)


class Job(Protocol):
    """One mission."""

    @property
    def kind(self) -> str: ...
    @property
    def seed(self) -> int: ...


class Result(Protocol):
    """The result of one mission: a dataclass whose fields JSON can represent."""

    @property
    def job(self) -> Any: ...
    @property
    def arrived(self) -> bool: ...
    @property
    def collisions(self) -> int: ...
    @property
    def ratio(self) -> float: ...


J = TypeVar("J", bound=Job)
R = TypeVar("R", bound=Result)


def gather(
    jobs: Sequence[J],
    run: Callable[[J], R],
    load: Callable[[dict[str, Any]], R],
    processes: int,
    file: Path | None,
) -> list[R]:
    """The result of each job; jobs without a result in `file` are run, and stored there.

    `load`: makes a result from its JSON fields. `file`: None stores nothing.
    """
    of = "" if file is None else digest()
    rows = {} if file is None else _read(file, of)
    todo = [job for job in jobs if _key(job) not in rows]
    found: dict[str, R] = {}
    with get_context("fork").Pool(processes) as pool:
        for one in pool.imap_unordered(run, todo):
            found[_key(one.job)] = one
            if file is not None:
                rows[_key(one.job)] = _row(one)
                _write(file, of, rows)
    keys = [_key(job) for job in jobs]
    return [found[key] if key in found else load(rows[key]["result"]) for key in keys]


def digest() -> str:
    """One digest of all files that missions depend on."""
    return on_record.digest(_BEGINS)


def _key(job: Job) -> str:
    return f"{job.kind} {job.seed}"


def _row(one: Result) -> dict[str, Any]:
    """A result as a JSON row, with common fields for every kind."""
    return {
        "kind": one.job.kind,
        "arrived": one.arrived,
        "collisions": one.collisions,
        "ratio": one.ratio,
        "result": asdict(one),  # type: ignore[call-overload]
    }


def _read(file: Path, of: str) -> dict[str, dict[str, Any]]:
    if not file.exists():
        return {}
    record = json.loads(file.read_text())
    rows: dict[str, dict[str, Any]] = record["missions"] if record["of"] == of else {}
    return rows


def _write(file: Path, of: str, rows: dict[str, dict[str, Any]]) -> None:
    kinds: dict[str, list[dict[str, Any]]] = {}
    for _, row in sorted(rows.items()):
        kinds.setdefault(row["kind"], []).append(row)
    record = {"of": of, "kinds": {kind: _summary(of_it) for kind, of_it in kinds.items()}}
    on_record.write(file, {**record, "missions": dict(sorted(rows.items()))})


def _summary(done: list[dict[str, Any]]) -> dict[str, Any]:
    ratios = [row["ratio"] for row in done if row["arrived"]]
    return {
        "missions": len(done),
        "arrived": sum(row["arrived"] for row in done),
        "collisions": sum(row["collisions"] for row in done),
        "time by the ideal, median": round(float(np.median(ratios)), 3) if ratios else None,
    }
