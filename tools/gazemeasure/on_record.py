"""Records of measurements in docs/, with one digest of the files that each depends on."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Generic, TypeVar

from gazeprove.sources import digest_of, digests
from gazesetup import ROOT

J = TypeVar("J")
R = TypeVar("R")
Row = dict[str, Any]
"""A result as JSON stores it."""

_DOCS = ROOT / "docs"


def file_of(name: str) -> Path | None:
    """The record's file. None outside of a checkout: nothing is stored there."""
    return _DOCS / name if _DOCS.is_dir() else None


def digest(begins: Iterable[Path]) -> str:
    """One digest of these files and of everything that they import."""
    return digest_of(digests(begins))


def write(file: Path, record: Mapping[str, Any], rows: Mapping[str, Row] | None = None) -> None:
    """Replace the file whole: who reads it at any time finds the old record or the new one.

    `rows` are stored as "rows", each on one line.
    """
    text = json.dumps(record, indent=1)
    if rows:
        lines = [f"  {json.dumps(key)}: {json.dumps(row)}" for key, row in rows.items()]
        text = text.removesuffix("\n}") + ',\n "rows": {\n' + ",\n".join(lines) + "\n }\n}"
    fresh = file.with_suffix(".new")
    fresh.write_text(text + "\n")
    os.replace(fresh, file)


@dataclass(frozen=True)
class Job:
    """One case of a set: its kind, and the seed that it is drawn from."""

    kind: str
    seed: int


@dataclass(frozen=True)
class Record(Generic[R]):
    """Results that are stored one by one, so that an interrupted run is resumed."""

    file: Path | None
    """None stores nothing."""
    of: str
    """The digest of what they depend on; results of another one are dropped."""
    row: Callable[[R], Row]
    result: Callable[[Row], R]
    """The inverse of `row`."""
    summary: Callable[[list[Row]], Row]
    """What the file says about all rows, for people."""

    def gather(self, jobs: Mapping[str, J], run: Callable[[J], R], processes: int) -> list[R]:
        """The result of each job; those without one in the file are run, and stored there."""
        rows = self._read()
        todo = [(key, job) for key, job in jobs.items() if key not in rows]
        found: dict[str, R] = {}
        with get_context("fork").Pool(processes) as pool:
            # As they end: a slow one holds back no result that an interrupted run should keep.
            for key, one in pool.imap_unordered(partial(_keyed, run), todo):
                found[key] = one
                rows[key] = self.row(one)
                self._write(rows)
        return [found[key] if key in found else self.result(rows[key]) for key in jobs]

    def _read(self) -> dict[str, Row]:
        if self.file is None or not self.file.exists():
            return {}
        stored = json.loads(self.file.read_text())
        rows: dict[str, Row] = stored["rows"] if stored["of"] == self.of else {}
        return rows

    def _write(self, rows: dict[str, Row]) -> None:
        if self.file is not None:
            rows = dict(sorted(rows.items()))
            head = {"of": self.of, **self.summary(list(rows.values()))}
            write(self.file, head, rows)


def _keyed(run: Callable[[J], R], job: tuple[str, J]) -> tuple[str, R]:
    return job[0], run(job[1])
