"""The sets of doors and rooms that assist is measured in; docs/assist.json keeps their results."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from gazemeasure import on_record
from gazemeasure.go.assist import BARE, HELPED, PLAIN, Outcome, Run, Task, cluttered, door
from gazemeasure.on_record import Job, Record, Row
from gazemeasure.pools import PROCESSES
from gazemeasure.report import Report

FILE = on_record.file_of("assist.json")
DOORS, ROOMS, NARROW = "doors of 0.81-0.90 m", "cluttered rooms", "doors of 0.81 m"
_TASKS: dict[str, Callable[[int], Task]] = {
    DOORS: door,
    ROOMS: cluttered,
    NARROW: lambda seed: door(seed, 0.81),
}
_WAYS = {DOORS: (BARE, PLAIN, HELPED), ROOMS: (BARE, PLAIN, HELPED), NARROW: (HELPED,)}
_COUNTS, _COUNTS_QUICK = {DOORS: 1000, ROOMS: 300, NARROW: 200}, {DOORS: 4, ROOMS: 3, NARROW: 3}
_PROFILE = "3.1"
_ARRIVED = 95.0  # %, as of the doors of 0.81 m


@dataclass(frozen=True)
class Result:
    """The outcomes of one task, by the way in which it was driven."""

    kind: str
    by_way: dict[str, Outcome]


def measure(report: Report, quick: bool) -> None:
    """Doors and rooms, each with and without help; as part of `gazechair measure go`."""
    counts = _COUNTS_QUICK if quick else _COUNTS
    jobs = [Job(kind, seed) for kind, count in counts.items() for seed in range(count)]
    done = gather(jobs, None if quick else FILE)
    for kind in (DOORS, ROOMS):
        tasks = [one.by_way for one in done if one.kind == kind]
        add_rows(report, kind, *([one[way] for one in tasks] for way in (BARE, PLAIN, HELPED)))
    passed = [one.by_way[HELPED].arrived for one in done if one.kind == NARROW]
    share = 100.0 * sum(passed) / len(passed)
    report.add("assist: doors of 0.81 m passed, no side margin", share, "%", 95.0, at_least=True)
    report.note("assist: a simulated gaze driver (gazesim/gaze_driver.py), the same luck with and")
    report.note(
        "without; the board's safety core decides; two lidars on corners. Simulation is not"
    )
    report.note("a user study. No rule: nothing stops the chair, as on a chair without gazechair.")


def gather(jobs: Sequence[Job], file: Path | None) -> list[Result]:
    """The result of each job; those without a row in the record are run, and stored there."""
    of = "" if file is None else on_record.digest((Path(__file__),))
    record = Record(file, of, asdict, kept, _summary)
    return record.gather({f"{job.kind} {job.seed:04}": job for job in jobs}, run, PROCESSES)


def run(job: Job) -> Result:
    """Drive one task in each way of its kind."""
    task = _TASKS[job.kind](job.seed)
    ways = _WAYS[job.kind]
    return Result(job.kind, {way: Run(task, way, job.seed, _PROFILE)() for way in ways})


def kept(row: Row) -> Result:
    """A result from its JSON row."""
    return Result(row["kind"], {way: Outcome(**one) for way, one in row["by_way"].items()})


def _summary(rows: list[Row]) -> Row:
    """For each kind: tasks, and in each way how many arrived or touched, and all commands."""
    summary: dict[str, Counter[str]] = {}
    for row in rows:
        of = summary.setdefault(row["kind"], Counter(tasks=0))
        of["tasks"] += 1
        for way, one in row["by_way"].items():
            for name in ("arrived", "contact", "commands"):
                of[f"{name}, {way}"] += one[name]
    return {"kinds": {kind: dict(of) for kind, of in sorted(summary.items())}}


def add_rows(
    report: Report,
    name: str,
    bare: list[Outcome],
    plain: list[Outcome],
    helped: list[Outcome],
) -> None:
    """The same tasks in three ways."""
    report.add(f"assist: {name}", len(helped), "")
    for way, found in ((PLAIN, plain), (HELPED, helped)):
        arrived = 100.0 * sum(o.arrived for o in found) / len(found)
        report.add(f"  arrived, {way}", arrived, "%", _ARRIVED if way == HELPED else None, True)
        report.add(f"  commands per task, {way}", sum(o.commands for o in found) / len(found), "")
        stopped = sum(o.overrides for o in found) / len(found)
        report.add(f"  presses that the board ended, {way}", stopped, "")
    commands = [sum(o.commands for o in found) for found in (plain, helped)]
    report.add("  commands, helped of unhelped", commands[1] / max(1, commands[0]), "", 0.5)
    contacts = [sum(o.contact for o in found) for found in (bare, plain, helped)]
    for way, count in zip((BARE, PLAIN, HELPED), contacts, strict=True):
        report.add(f"  tasks that end in a contact, {way}", count, "")
    cut = 100.0 * (1.0 - contacts[2] / contacts[0]) if contacts[0] else math.nan
    report.add("  contacts cut, against no rule", cut, "%", 82.0, at_least=True)
    report.add("  moved while nothing was held", sum(o.loose for o in helped), "", 0)
