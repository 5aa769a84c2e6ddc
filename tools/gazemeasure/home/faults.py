"""Drives in a known home with a fault of the lidars: claimed poses, and reports of the fault.

The map is made from key scans (see localization.py); the chair knows its pose at the beginning,
and drives among people. Then a lidar is bumped or lost, or all scans arrive late. Each claimed pose
is judged at its own time: it is wrong if it is 0.1 m or 3 degrees off, at any look after the fault.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gazechair.base.poses import between
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.mapping.locating.atlas import Atlas
from gazechair.sensing.mapping.locating.looks import Looks
from gazechair.sensing.odometry import doubts
from gazechair.sensing.odometry.odometry import Odometry
from gazemeasure.home.localization import is_right, mapped
from gazemeasure.report import Report
from gazemeasure.spread import Spread, together
from gazesim import home_plans
from gazesim.home_drive import FRONT, REAR, Drive, Mounted

NOTHING, BUMPED, BUMPED_ONE, GONE, LATE = (
    "nothing wrong",
    "the only lidar bumped by 3 degrees",
    "one lidar of two bumped by 3 degrees",
    "one lidar of two lost",
    "scans 300 ms late",
)
_LIDARS: dict[str, tuple[Mounted, ...]] = {
    NOTHING: (FRONT,),
    BUMPED: (FRONT,),
    BUMPED_ONE: (FRONT, REAR),
    GONE: (FRONT, REAR),
    LATE: (FRONT,),
}
_BUMPED_DEG, _LATE_S = 3.0, 0.3
_OFF_STEP_M, _SIGMA_STEP = 0.001, 0.1
_NO_METRES, _NO_SIGMAS = (Spread.of((), step) for step in (_OFF_STEP_M, _SIGMA_STEP))
_SPREADS = ("off_m", "sigma_m", "off_by_sigma", "turned_by_sigma")
_BEGINS_S, _SECONDS = 15.0, 60.0
_LOOK_S = 0.2

_NOTICED_S = {BUMPED: 5.0, BUMPED_ONE: 5.0, GONE: 1.0, LATE: 1.0}
_DOUBTS = {BUMPED: doubts.TURNED, BUMPED_ONE: doubts.TURNED, GONE: doubts.SILENT, LATE: doubts.LATE}
_SEEDS, _SEEDS_QUICK = range(60, 70), range(60, 61)

Job = tuple[str, int]  # fault, seed


@dataclass
class Drove:
    """The result of a drive."""

    wrong: int = 0
    """Looks at which a wrong pose was claimed."""
    known: int = 0
    """Looks at which a pose was claimed."""
    looks: int = 0
    alarms: int = 0
    """Estimates that reported the fault, or a turned lidar, before there was a fault."""
    noticed_s: float = math.inf
    """Time from the fault to its report."""
    off_m: Spread = _NO_METRES
    """Position errors of the claimed poses."""
    sigma_m: Spread = _NO_METRES
    """Claimed standard deviations of the position."""
    off_by_sigma: Spread = _NO_SIGMAS
    """Position errors in claimed standard deviations."""
    turned_by_sigma: Spread = _NO_SIGMAS
    """Errors of the heading in claimed standard deviations."""


def of_row(row: dict[str, Any]) -> Drove:
    """A result from its JSON row."""
    return Drove(**{**row, **{name: Spread(**row[name]) for name in _SPREADS}})


Run = Callable[[Callable[[Job], Drove], Sequence[Job]], list[Drove]]


def drove(job: Job) -> Drove:
    """Run one drive, with the fault from _BEGINS_S on."""
    kind, seed = job
    home = home_plans.home(seed)
    people, home.people = home.people, ()
    grid = mapped(home, np.random.default_rng(seed))
    home.people, home.script = people, ()
    driven = Drive(home, seed, _LIDARS[kind])
    odometry, looks, atlas, done = Odometry(), Looks(), Atlas(), Drove()
    atlas.know({"a": grid})
    off_m: list[float] = []
    off_rad: list[float] = []
    sigma_m: list[float] = []
    sigma_rad: list[float] = []
    look_s = 0.0
    for event in _events(driven, kind, _SECONDS):
        if isinstance(event, Motion):
            odometry.motion(event)
            continue
        looks.piece(event)
        found = odometry.piece(event)
        if found is None:
            continue
        began = driven.time_s >= _BEGINS_S
        if began and _DOUBTS.get(kind) in found.doubts:
            done.noticed_s = min(done.noticed_s, driven.time_s - _BEGINS_S)
        if not began or kind == NOTHING:
            done.alarms += bool({doubts.TURNED, _DOUBTS.get(kind)}.intersection(found.doubts))
        if not looks.estimate(found) or driven.time_s < look_s:
            continue
        truth = driven.truth(found.time_s)
        true = np.array((truth.x_m, truth.y_m, math.radians(truth.heading_deg)))
        seen = looks.seen()
        if not look_s:
            atlas.place("a", true, seen.odometry, found.track)
        look_s = driven.time_s + _LOOK_S
        location = atlas.look(seen)
        done.looks += 1
        if atlas.askew and began:
            done.noticed_s = min(done.noticed_s, driven.time_s - _BEGINS_S)
        done.alarms += atlas.askew and not (began and kind in (BUMPED, BUMPED_ONE))
        if location is None:
            continue
        done.known += 1
        done.wrong += not is_right(location, true)
        off = between(true, location.pose)
        off_m.append(math.hypot(off[0], off[1]))
        off_rad.append(abs(off[2]))
        sigma_m.append(location.sigma_m)
        sigma_rad.append(location.sigma_rad)
    done.off_m, done.sigma_m = Spread.of(off_m, _OFF_STEP_M), Spread.of(sigma_m, _OFF_STEP_M)
    done.off_by_sigma = Spread.of(np.divide(off_m, sigma_m), _SIGMA_STEP)
    done.turned_by_sigma = Spread.of(np.divide(off_rad, sigma_rad), _SIGMA_STEP)
    return done


def _events(driven: Drive, kind: str, seconds: float) -> Iterator[Motion | Piece]:
    """The sensors' data, in the order of arrival."""
    late: deque[tuple[float, Piece]] = deque()
    for event in driven.events(seconds):
        while late and late[0][0] <= driven.time_s:
            yield late.popleft()[1]
        wrong = driven.time_s >= _BEGINS_S
        if isinstance(event, Motion) or not wrong or kind == NOTHING:
            yield event
        elif kind == LATE:
            late.append((driven.time_s + _LATE_S, event))
        elif event.origin_m != (FRONT.x_m, FRONT.y_m):
            yield event
        elif kind in (BUMPED, BUMPED_ONE):
            if driven.lidars[0] is FRONT:
                driven.lidars = (replace(FRONT, heading_deg=_BUMPED_DEG), *driven.lidars[1:])
                yield event
            else:  # odometry still assumes its old direction
                yield replace(event, directions_deg=event.directions_deg - _BUMPED_DEG)


def measure(report: Report, quick: bool, run: Run) -> None:
    """Add the rows; `run` maps jobs."""
    seeds = _SEEDS_QUICK if quick else _SEEDS
    kinds = list(_LIDARS)
    done = run(drove, [(kind, seed) for kind in kinds for seed in seeds])
    for number, kind in enumerate(kinds):
        mine = done[number * len(seeds) : (number + 1) * len(seeds)]
        known = 100.0 * sum(one.known for one in mine) / sum(one.looks for one in mine)
        report.add(f"a known home, {kind} ({len(mine)}): place known", known, "% of looks")
        wrong = sum(one.wrong for one in mine)
        report.add("  looks at which it was confidently wrong", wrong, "", 0.0)
        report.add("  doubted before anything was wrong", sum(one.alarms for one in mine), "", 0.0)
        if kind in _NOTICED_S:
            noticed_s = max(one.noticed_s for one in mine)
            report.add("  noticed, slowest", noticed_s, "s", _NOTICED_S[kind])
        else:
            _add_errors(report, mine)


def _add_errors(report: Report, done: list[Drove]) -> None:
    off_m, sigma_m, off_by_sigma, turned_by_sigma = (
        together(getattr(one, name) for one in done) for name in _SPREADS
    )
    report.add("  place off, 95 %", off_m.percentile(95.0), "m")
    report.add("  it says, median", sigma_m.percentile(50.0), "m")
    report.add("  place within two of its sigmas", 100.0 * off_by_sigma.share_below(2.0), "%")
    report.add("  heading within two of its sigmas", 100.0 * turned_by_sigma.share_below(2.0), "%")
