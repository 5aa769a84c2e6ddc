"""Localization in generated homes: starts anywhere without a hint, crowds, disturbed homes.

The map of a home is made of key scans with poses right within 1 cm and 0.2 degrees. A chair with
one front lidar stands somewhere, turns by at most 20 degrees per second, and has 10 s. Right is
within 0.1 m and 3 degrees; any other claimed pose is confidently wrong. Crowds hide most of the
surroundings: a walking one hides other parts in each look, a standing one the same. In a home that
is not on the map, every claimed pose is wrong.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gazechair.base.angles import half_turn_rad
from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between, compose, to_frame
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, occupancy_of
from gazechair.sensing.mapping.locating.localization import Localization
from gazechair.sensing.mapping.locating.location import Location
from gazechair.sensing.mapping.locating.map_match import Look
from gazemeasure.report import Report, percentile
from gazesim import home_plans, rays
from gazesim.home_drive import FRONT, LIDAR_HEIGHT_M, REAR, Mounted
from gazesim.homes import Home
from gazesim.lidar_noise import NOISE_M
from gazesim.rooms import Solid

_HOMES, _HOMES_QUICK = 100, 3
_STARTS, _HOSTILE_STARTS = 10, 2  # in each home
_KEY_SCANS = 120
KEY_SIGMAS = np.array((0.01, 0.01, math.radians(0.2)))
_RIGHT_M, _RIGHT_RAD = 0.1, math.radians(3.0)
_LOOK_S, _TURN_RAD_S, _GIVEN_S = 0.5, math.radians(20.0), 10.0
_BEAMS = 600  # per turn
_FARTHEST_M = 18.0
_NOTICED_S = 5.0
_HIDDEN_SHARE, _SECTORS = 0.7, 20
_PERSON_M, _AWAY_M = (0.12, 0.25), (0.85, 1.8)  # a standing person: radius, distance from the axle
_CROWD_S, _AGAIN_S = 10.0, 0.2  # it stands around a chair that knew its place
_MOVED_SHARE, _MOVED_M = 0.5, 0.5
_LEAST_KEPT = 90.0
_ANOTHER = 500  # offset in seed of a home that is not on the map
_NOBODY: FloatArray = np.zeros((0, 3))

# Kind of start, and the percentage that must be right.
_MAPPED, _MOVED, _WALKING, _STANDING = (
    "as mapped",
    "doors and furniture moved",
    "70 % hidden by a crowd that walks",
    "70 % hidden by a crowd that stands",
)
_LEAST = {_MAPPED: 99.0, _MOVED: 85.0, _WALKING: 90.0, _STANDING: 50.0}
_JUDGED = 10  # of fewer starts, a single one would decide about the share


@dataclass
class Counted:
    """The results of the starts in one home, by the kind of start."""

    right: dict[str, int] = field(default_factory=dict)
    wrong: dict[str, int] = field(default_factory=dict)
    unknown: dict[str, int] = field(default_factory=dict)
    after_s: list[float] = field(default_factory=list)
    """Time until a right pose in undisturbed homes."""
    lost_after_s: list[float] = field(default_factory=list)
    elsewhere: list[bool] = field(default_factory=list)
    """For each start in a home that is not on the map: True if it claimed a pose."""
    crowded: list[str] = field(default_factory=list)
    """The pose after a crowd came to a located chair: right, wrong or unknown."""
    look_ms: list[float] = field(default_factory=list)

    def count(self, kind: str, found: Location | None, pose: FloatArray) -> None:
        """Add the result of one start."""
        which = self.unknown if found is None else self.wrong
        if found is not None and is_right(found, pose):
            which = self.right
        which[kind] = which.get(kind, 0) + 1


def measure(report: Report, quick: bool, each: Callable[..., list[Counted]]) -> None:
    """Add the rows; `each` maps a function over seeds, as a pool does."""
    done = each(starts_in, range(_HOMES_QUICK if quick else _HOMES))
    for kind, least in _LEAST.items():
        add_right(report, kind, done, least)
    elsewhere = [wrong for one in done for wrong in one.elsewhere]
    report.add(
        f"in a home that is not on the map ({len(elsewhere)}): claims", sum(elsewhere), "", 0.0
    )
    after_s = [one for each_home in done for one in each_home.after_s]
    report.add("  after, 95 % of those found", percentile(after_s, 0.95), "s")
    lost_s = [one for each_home in done for one in each_home.lost_after_s]
    report.add(f"carried away ({len(lost_s)}): noticed, most", max(lost_s), "s", _NOTICED_S)
    crowded = [one for each_home in done for one in each_home.crowded]
    kept = 100.0 * crowded.count("right") / len(crowded)
    known = f"a crowd comes and stands ({len(crowded)}): still known after"
    report.add(known, kept, "%", _LEAST_KEPT, at_least=True)
    report.add("  confidently wrong", crowded.count("wrong"), "", 0.0)
    look_ms = [one for each_home in done for one in each_home.look_ms]
    report.add("a search of the whole map, median", percentile(look_ms, 0.5), "ms")


def add_right(report: Report, kind: str, done: Sequence[Counted], least: float | None) -> None:
    """Add the share of right starts of that kind, and the number of wrong ones: always 0."""
    right, wrong, unknown = (
        sum(getattr(one, name).get(kind, 0) for one in done)
        for name in ("right", "wrong", "unknown")
    )
    count = right + wrong + unknown
    limit = least if count >= _JUDGED else None
    name, unit = f"finding itself, {kind}: right", f"% of {count}"
    report.add(name, 100.0 * right / count, unit, limit, at_least=True)
    report.add("  confidently wrong", wrong, "", 0.0)


def starts_in(seed: int) -> Counted:
    """Run all starts in one home."""
    chance = np.random.default_rng(seed)
    counted = Counted()
    home = home_plans.home(seed)
    home.people = ()
    grid = mapped(home, chance)
    for number in range(_STARTS):
        localization = Localization(grid)
        found, pose, spent_s = turning(localization, home, somewhere(home, chance), chance)
        counted.count(_MAPPED, found, pose)
        if found is not None:
            counted.after_s.append(spent_s)
            if number < _HOSTILE_STARTS:
                counted.crowded.append(_crowded(localization, home, pose, chance))
            if localization.location is not None:
                counted.lost_after_s.append(_carried(localization, home, pose, chance))
    localization = Localization(grid)
    for number in range(2):
        begin_s = time.process_time()
        localization.look(look(home, pose, chance), np.zeros(3), float(number))
    counted.look_ms.append(1000.0 * (time.process_time() - begin_s))
    for _ in range(_HOSTILE_STARTS):
        pose = somewhere(home, chance)
        found, pose, _ = turning(Localization(grid), home, pose, chance, _HIDDEN_SHARE)
        counted.count(_WALKING, found, pose)
        pose = somewhere(home, chance)
        crowd = crowd_around(pose, chance)
        found, pose, _ = turning(Localization(grid), home, pose, chance, crowd=crowd)
        counted.count(_STANDING, found, pose)
        other = _disturbed(seed, chance)
        found, pose, _ = turning(Localization(grid), other, somewhere(other, chance), chance)
        counted.count(_MOVED, found, pose)
        other = home_plans.home(seed + _ANOTHER)
        other.people = ()
        pose = somewhere(other, chance)
        found, _, _ = turning(Localization(grid), other, pose, chance)
        counted.elsewhere.append(found is not None)
    return counted


def mapped(home: Home, chance: np.random.Generator) -> OccupancyGrid:
    """A map of the home as it is now."""
    return occupancy_of(key_scans(home, chance))


def key_scans(home: Home, chance: np.random.Generator) -> list[KeyScan]:
    """Key scans of the home as it is now, from everywhere in it."""
    keys = []
    for _ in range(_KEY_SCANS):
        pose = somewhere(home, chance)
        seen = look(home, pose, chance, (FRONT, REAR))
        known = pose + chance.normal(0.0, KEY_SIGMAS)
        keys.append(KeyScan(known, seen.points_m, seen.origins_m, 0.0, 0.0, 0.0))
    return keys


def look(
    home: Home,
    pose: FloatArray,
    chance: np.random.Generator,
    lidars: tuple[Mounted, ...] = (FRONT,),
    hidden: float = 0.0,
    crowd: FloatArray = _NOBODY,
) -> Look:
    """The lidars' view from `pose`.

    Walking people hide the share `hidden` of it; `crowd`: standing people, rows x, y, radius.
    """
    points, origins = [], []
    for lidar in lidars:
        origin = np.array((lidar.x_m, lidar.y_m))
        own = np.arange(-lidar.half_deg, lidar.half_deg, 360.0 / _BEAMS)
        angles = np.radians(own + lidar.heading_deg)
        x_m, y_m = to_frame(origin[None], pose)[0].tolist()
        metres = home.cast(x_m, y_m, angles + pose[2], LIDAR_HEIGHT_M)
        everywhere = np.full(len(own), x_m), np.full(len(own), y_m)
        metres = np.minimum(metres, rays.cast_discs(*everywhere, angles + pose[2], crowd))
        near = chance.uniform(0.6, 1.5, _SECTORS)
        near[chance.random(_SECTORS) >= hidden] = math.inf
        metres = np.minimum(metres, near[np.arange(len(own)) * _SECTORS // len(own)])
        seen = (metres > 0.05) & (metres < _FARTHEST_M)
        noisy = metres[seen] + chance.normal(0.0, NOISE_M, int(seen.sum()))
        directions = np.stack((np.cos(angles[seen]), np.sin(angles[seen])), axis=1)
        points.append(origin + noisy[:, None] * directions)
        origins.append(np.tile(origin, (len(noisy), 1)))
    return Look(np.concatenate(points), np.concatenate(origins))


def is_right(found: Location, pose: FloatArray) -> bool:
    """True if the found pose is the chair's."""
    off = between(pose, found.pose)
    return bool(math.hypot(off[0], off[1]) < _RIGHT_M and abs(off[2]) < _RIGHT_RAD)


def turning(
    localization: Localization,
    home: Home,
    start: FloatArray,
    chance: np.random.Generator,
    hidden: float = 0.0,
    crowd: FloatArray = _NOBODY,
) -> tuple[Location | None, FloatArray, float]:
    """The first claimed pose while the chair turns on the spot, the true pose then, and the time.

    The chair stands for the first second.
    """
    for number in range(int(_GIVEN_S / _LOOK_S)):
        at_s = number * _LOOK_S
        turned = np.array((0.0, 0.0, _TURN_RAD_S * max(0.0, at_s - 1.0)))
        pose = compose(start, turned)
        seen = look(home, pose, chance, hidden=hidden, crowd=crowd)
        found = localization.look(seen, turned, at_s)
        if found is not None:
            break
    return found, pose, at_s


def _crowded(
    localization: Localization, home: Home, pose: FloatArray, chance: np.random.Generator
) -> str:
    """The result at the end, or "wrong" if it ever was; the chair stands."""
    odometry = np.zeros(3)
    localization.place(pose, odometry)
    crowd = crowd_around(pose, chance)
    for number in range(round(_CROWD_S / _AGAIN_S)):
        seen = look(home, pose, chance, crowd=crowd)
        found = localization.look(seen, odometry, 50.0 + _AGAIN_S * number)
        if found is not None and not is_right(found, pose):
            return "wrong"
    return "unknown" if found is None else "right"


def crowd_around(pose: FloatArray, chance: np.random.Generator) -> FloatArray:
    """People who stand around the chair: rows x, y, radius."""
    bearings = np.radians(np.arange(360.0))
    hidden = np.zeros(360, dtype=bool)
    found = []
    while hidden.mean() < _HIDDEN_SHARE:
        bearing, away_m = chance.uniform(-math.pi, math.pi), chance.uniform(*_AWAY_M)
        radius_m = chance.uniform(*_PERSON_M)
        at = to_frame(away_m * np.array([(math.cos(bearing), math.sin(bearing))]), pose)[0]
        found.append((*at.tolist(), radius_m))
        off = np.abs(half_turn_rad(bearings - bearing))
        hidden |= off < math.asin(radius_m / away_m)
    return np.array(found)


def _carried(
    localization: Localization, home: Home, pose: FloatArray, chance: np.random.Generator
) -> float:
    """Seconds until the pose is unknown or right after the chair was carried; inf: neither."""
    there = somewhere(home, chance)
    while math.hypot(*(there - pose)[:2]) < 1.0:
        there = somewhere(home, chance)
    for number in range(30):
        at_s = 0.2 * number
        found = localization.look(look(home, there, chance), np.zeros(3), 100.0 + at_s)
        if found is None or is_right(found, there):
            return at_s
    return math.inf


def somewhere(home: Home, chance: np.random.Generator) -> FloatArray:
    """A pose in the home where the chair has room."""
    rows = home.segments(LIDAR_HEIGHT_M).reshape(-1, 2)
    around = np.radians(np.arange(0.0, 360.0, 10.0))
    while True:
        x, y = chance.uniform(rows.min(axis=0), rows.max(axis=0))
        heading = chance.uniform(-math.pi, math.pi)
        if (
            home.clearance_m(x, y, math.degrees(heading)) > 0.05
            and np.isfinite(home.cast(x, y, around, LIDAR_HEIGHT_M)).all()
        ):
            return np.array((x, y, heading))


def _disturbed(seed: int, chance: np.random.Generator) -> Home:
    """The home with some doors closed and half of its furniture shifted by up to 0.5 m."""
    home = home_plans.home(seed)
    home.people = ()
    for door in home.doors:
        home.set_door(door.name, bool(chance.random() < 0.7))
    home.furniture = tuple(_shifted(one, chance) for one in home.furniture)
    home.changed()
    return home


def _shifted(one: Solid, chance: np.random.Generator) -> Solid:
    if one.z1_m >= 2.0 or chance.random() >= _MOVED_SHARE:  # walls
        return one
    dx, dy = chance.uniform(-_MOVED_M, _MOVED_M, 2)
    return replace(one, corners=tuple((x + dx, y + dy) for x, y in one.corners))
