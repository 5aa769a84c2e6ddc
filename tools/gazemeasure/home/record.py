"""What `gazechair measure home` keeps in docs/: starts.json and drives.json."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

from gazemeasure import on_record
from gazemeasure.home import drives as home_drives
from gazemeasure.home.drives import Driven, Job
from gazemeasure.home.localization import Counted
from gazemeasure.on_record import Record, Row
from gazemeasure.pools import PROCESSES
from gazemeasure.spread import together

STARTS, DRIVES = on_record.file_of("starts.json"), on_record.file_of("drives.json")
_HERE = Path(__file__).parent


def starts(
    run: Callable[[int], Counted], homes: Sequence[int], file: Path | None = STARTS
) -> list[Counted]:
    """The starts in each home; those without a row in the record are run, and stored there."""
    of = _digest(file, "localization.py")
    record = Record(file, of, asdict, lambda row: Counted(**row), _of_starts)
    return record.gather({f"{home:03}": home for home in homes}, run, PROCESSES)


def drives(
    run: Callable[[Job], Driven], jobs: Sequence[Job], file: Path | None = DRIVES
) -> list[Driven]:
    """The result of each drive; those without a row in the record are run, and stored there."""
    record = Record(file, _digest(file, "drives.py"), asdict, home_drives.kept, _of_drives)
    keys = {f"{job.lidars} {job.seed:03} {job.seconds:.0f} s": job for job in jobs}
    return record.gather(keys, run, PROCESSES)


def _digest(file: Path | None, begins: str) -> str:
    return "" if file is None else on_record.digest((_HERE / begins,))


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
    done = [home_drives.kept(row) for row in rows]
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
