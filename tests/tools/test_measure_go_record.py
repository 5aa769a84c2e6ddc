"""Missions that are gathered in several runs: what is kept, and when it counts no more."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from gazemeasure.go import record as go_record
from gazemeasure.on_record import Job

_LIMIT_S = 10.0


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


@dataclass(frozen=True)
class Otherwise:
    """What came of missions of another sort: nothing that `load` knows."""

    job: Job
    arrived: bool
    collisions: int
    ratio: float
    pieces: list[int]


def run_otherwise(job: Job) -> Otherwise:
    """At once."""
    return Otherwise(job, True, 1, 2.0, [1, 2])


def load_otherwise(row: dict[str, Any]) -> Otherwise:
    """Of a kept row."""
    return Otherwise(**{**row, "job": Job(**row["job"])})


def test_results_of_several_sorts_are_kept_in_one_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "missions.json"
    far, near = [Job("far", 0)], [Job("near", 0)]
    for _ in range(2):
        assert go_record.gather(far, run, load, 1, file) == [run(far[0])]
        came = go_record.gather(near, run_otherwise, load_otherwise, 1, file)
        assert came == [run_otherwise(near[0])]
    assert Path("ran 0").read_text() == "xxx"  # one of the record's, two of the comparison
    assert set(json.loads(file.read_text())["kinds"]) == {"far", "near"}


def run_in_turn(job: Job) -> Came:
    """The first one ends only once another one is on record; and then it fails."""
    if job.seed == 0:
        end_s = time.monotonic() + _LIMIT_S
        while time.monotonic() < end_s and not Path("missions.json").exists():
            time.sleep(0.01)
        raise InterruptedError
    return run(job)


def test_a_slow_one_holds_back_none_that_ended_before_the_run_was_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "missions.json"
    with pytest.raises(InterruptedError):
        go_record.gather([Job("far", seed) for seed in (0, 1)], run_in_turn, load, 2, file)
    assert set(json.loads(file.read_text())["rows"]) == {"far 1"}


def test_without_a_file_nothing_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for _ in range(2):
        go_record.gather([Job("far", 0)], run, load, 1, None)
    assert [path.name for path in tmp_path.iterdir()] == ["ran 0"]
    assert Path("ran 0").read_text() == "xx"


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
