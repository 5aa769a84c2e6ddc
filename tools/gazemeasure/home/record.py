"""What `gazechair measure home` stores in docs/, part by part, so that it can be resumed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Generic, TypeVar

from gazemeasure import on_record
from gazemeasure.home import drives, faults, upkeep
from gazemeasure.home.alarms import Told
from gazemeasure.home.drives import Driven
from gazemeasure.home.faults import Drove
from gazemeasure.home.forward import Found
from gazemeasure.home.localization import Counted
from gazemeasure.home.upkeep import Kept
from gazemeasure.on_record import Record, Row
from gazemeasure.pools import PROCESSES
from gazemeasure.spread import together

J = TypeVar("J")
R = TypeVar("R")

_HERE = Path(__file__).parent


def _counted(rows: list[Row]) -> Row:
    return {"cases": len(rows)}


@dataclass(frozen=True)
class Stored(Generic[J, R]):
    """One part's results: each is stored when it is there, and none is measured twice."""

    file: Path | None
    """None stores nothing."""
    module: str
    """The file beside this one that measures it: with all that it imports, it makes the digest."""
    key: Callable[[J], str]
    result: Callable[[Row], R]
    """The inverse of `row`."""
    row: Callable[[R], Row] = asdict  # type: ignore[assignment]
    summary: Callable[[list[Row]], Row] = _counted

    def each(self, run: Callable[[J], R], jobs: Sequence[J]) -> list[R]:
        """The result of each job; those without a row in the file are run."""
        of = "" if self.file is None else on_record.digest((_HERE / self.module,))
        record = Record(self.file, of, self.row, self.result, self.summary)
        return record.gather({self.key(job): job for job in jobs}, run, PROCESSES)


def _case(job: tuple[str, int]) -> str:
    """The key of a kind and a seed."""
    return f"{job[0]} {job[1]:03}"


def _of_starts(rows: list[Row]) -> Row:
    """How many starts of each kind were right, wrong, and without a claim."""
    by_kind: dict[str, Counter[str]] = {}
    for row in rows:
        for result in ("right", "wrong", "unknown"):
            for kind, count in row[result].items():
                by_kind.setdefault(kind, Counter())[result] += count
    return {
        "homes": len(rows),
        "kinds": {kind: dict(counts) for kind, counts in sorted(by_kind.items())},
        "claims in homes that are not on the map": sum(sum(row["elsewhere"]) for row in rows),
        "carried away": sum(len(row["lost_after_s"]) for row in rows),
        "noticed after, most, s": max(max(row["lost_after_s"], default=0.0) for row in rows),
    }


def _of_drives(rows: list[Row]) -> Row:
    """The largest errors of each number of lidars, and what was reported without cause."""
    summary = {}
    done = [drives.kept(row) for row in rows]
    for lidars in sorted({one.job.lidars for one in done}):
        mine = [one for one in done if one.job.lidars == lidars]
        summary[lidars] = {
            "drives": len(mine),
            "hours": round(sum(one.job.seconds for one in mine) / 3600.0, 2),
            "way, m": round(sum(one.way_m for one in mine)),
            "end error by way, most, %": round(
                max(100.0 * one.end_m / one.way_m for one in mine), 3
            ),
            "speed error, 95 %, m/s": together(one.speed_m_s for one in mine).percentile(95.0),
            "walls, 95 %, m": together(one.map.off_m for one in mine).percentile(95.0),
            "homes with a doubled room": sum(one.map.doubled for one in mine),
            "called stuck or pushed without cause": sum(one.alarms for one in mine),
            "a lidar called turned without cause": sum(one.turned for one in mine),
        }
    return summary


STARTS = Stored[int, Counted](
    on_record.file_of("starts.json"),
    "localization.py",
    "{:03}".format,
    lambda row: Counted(**row),
    summary=_of_starts,
)
DRIVES = Stored[drives.Job, Driven](
    on_record.file_of("drives.json"),
    "drives.py",
    lambda job: f"{job.lidars} {job.seed:03} {job.seconds:.0f} s",
    drives.kept,
    summary=_of_drives,
)
FOREIGN = Stored[tuple[str, int], Counted](
    on_record.file_of("foreign.json"), "foreign.py", _case, lambda row: Counted(**row)
)
FAULTS = Stored[tuple[str, int], Drove](
    on_record.file_of("faults.json"), "faults.py", _case, faults.of_row
)
UPKEEP = Stored[int, Kept](
    on_record.file_of("upkeep.json"), "upkeep.py", "{:03}".format, upkeep.of_row
)
ALARMS = Stored[tuple[str, int], Told](
    on_record.file_of("alarms.json"), "alarms.py", _case, lambda row: Told(**row)
)
FORWARD = Stored[tuple[str, int], Found](
    on_record.file_of("forward.json"),
    "forward.py",
    _case,
    lambda row: (row["step_off_m"], row["stopping_by_true"]),
    row=lambda found: {"step_off_m": found[0], "stopping_by_true": found[1]},
)
