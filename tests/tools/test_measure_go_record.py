"""Missions that are gathered in several runs: what is kept, and when it counts no more."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from gazemeasure import go_record


@dataclass(frozen=True)
class Job:
    """One of them."""

    kind: str
    seed: int


@dataclass(frozen=True)
class Came:
    """What came of it."""

    job: Job
    arrived: bool
    collisions: int
    ratio: float


def run(job: Job) -> Came:
    """Leaves a mark each time."""
    with Path(f"ran {job.seed}").open("a") as file:
        file.write("x")
    return Came(job, job.seed != 2, 0, 1.0 + job.seed)


def load(row: dict[str, Any]) -> Came:
    """Of a kept row."""
    return Came(**{**row, "job": Job(**row["job"])})


def test_what_is_kept_is_not_run_again_until_a_file_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "missions.json"
    jobs = [Job("far", seed) for seed in range(3)]
    first = go_record.gather(jobs[:1], run, load, 1, file)
    assert go_record.gather(jobs[:1], run, load, 1, file) == first
    assert Path("ran 0").read_text() == "x"
    done = go_record.gather(jobs, run, load, 1, file)
    assert [one.job for one in done] == jobs
    assert Path("ran 0").read_text() == "x"
    assert json.loads(file.read_text())["kinds"] == {
        "far": {"missions": 3, "arrived": 2, "collisions": 0, "time by the ideal, median": 1.5}
    }
    monkeypatch.setattr(go_record, "digest", lambda: "another")
    go_record.gather(jobs[:1], run, load, 1, file)
    assert Path("ran 0").read_text() == "xx"
    assert json.loads(file.read_text())["kinds"]["far"]["missions"] == 1
