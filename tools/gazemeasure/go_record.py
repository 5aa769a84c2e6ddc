"""Results of missions, kept as they come: a run of the full set that was ended is resumed.

docs/missions.json has them, and a digest of the files that they rest upon: when one of these
changes, all begins anew.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Protocol, TypeVar

import numpy as np

from gazesetup import ROOT

FILE = ROOT / "docs" / "missions.json"
_HOST = ("base", "board", "driving", "going", "plugins", "producers", "sensing")
_FOLDERS = (
    *("firmware/gazeboard", "protocol/gazelink", "tools/gazesim"),
    *(f"host/gazechair/{name}" for name in _HOST),
)
_OWN = "tools/gazemeasure"


class Job(Protocol):
    """One mission."""

    @property
    def kind(self) -> str: ...
    @property
    def seed(self) -> int: ...


class Result(Protocol):
    """What came of one: a dataclass, whose fields JSON can hold."""

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
    file: Path = FILE,
) -> list[R]:
    """What came of each job; those that `file` does not hold are run. `load`: of a kept row."""
    of = digest()
    rows = _read(file, of)
    todo = [job for job in jobs if _key(job) not in rows]
    with get_context("fork").Pool(processes) as pool:
        for one in pool.imap_unordered(run, todo):
            rows[_key(one.job)] = asdict(one)  # type: ignore[call-overload]
            _write(file, of, rows, load)
    return [load(rows[_key(job)]) for job in jobs]


def digest() -> str:
    """Of all files that missions rest upon."""
    files = [path for name in _FOLDERS for path in (ROOT / name).rglob("*.py")]
    files += (ROOT / _OWN).glob("go_*.py")
    found = hashlib.sha256()
    for path in sorted(files):
        found.update(f"{path.relative_to(ROOT)}\n".encode() + path.read_bytes())
    return found.hexdigest()


def _key(job: Job) -> str:
    return f"{job.kind} {job.seed}"


def _read(file: Path, of: str) -> dict[str, dict[str, Any]]:
    if not file.exists():
        return {}
    record = json.loads(file.read_text())
    rows: dict[str, dict[str, Any]] = record["missions"] if record["of"] == of else {}
    return rows


def _write(
    file: Path, of: str, rows: dict[str, dict[str, Any]], load: Callable[[dict[str, Any]], Result]
) -> None:
    kinds: dict[str, list[Result]] = {}
    for _, row in sorted(rows.items()):
        one = load(row)
        kinds.setdefault(one.job.kind, []).append(one)
    record = {"of": of, "kinds": {kind: _summary(of_it) for kind, of_it in kinds.items()}}
    fresh = file.with_suffix(".new")
    fresh.write_text(json.dumps({**record, "missions": dict(sorted(rows.items()))}, indent=1))
    os.replace(fresh, file)


def _summary(done: list[Result]) -> dict[str, Any]:
    ratios = [one.ratio for one in done if one.arrived]
    return {
        "missions": len(done),
        "arrived": sum(one.arrived for one in done),
        "collisions": sum(one.collisions for one in done),
        "time by the ideal, median": round(float(np.median(ratios)), 3) if ratios else None,
    }
