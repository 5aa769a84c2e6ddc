"""Maps kept current: homes whose furniture moved since the map, driven through again in a crowd.

The map is made from key scans with poses right within 5 mm and 0.1 degrees. Then two pieces of
furniture are moved and a door is closed, and the chair drives through the rooms of these pieces
again, hours apart, among people who stand elsewhere each time. The home itself is the reference.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between, compose
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, occupancy_of
from gazechair.sensing.mapping.keeping import APART_S, Keeping
from gazechair.sensing.mapping.locating.atlas import Atlas
from gazechair.sensing.mapping.locating.looks import Seen
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.store import MapStore
from gazechair.sensing.odometry.estimate import Estimate
from gazemeasure.home.localization import is_right, look
from gazemeasure.home.maps import OFF_STEP_M, WALLS_M, surfaces_off_m
from gazemeasure.report import Report
from gazemeasure.spread import Spread, together
from gazesim import home_plans
from gazesim.home_drive import FRONT, LIDAR_HEIGHT_M, REAR
from gazesim.home_routes import Pose, Router
from gazesim.homes import Home
from gazesim.rooms import Solid

DRIVES = 6
_HOMES, _HOMES_QUICK = 20, 1
_LOOK_S, _EVERY = 0.8, 2  # poses of the route, 10 cm or 22.5 degrees apart
_PIECES, _SHIFT_M, _TRIES = 2, (0.4, 1.2), 60
_FREE_M, _PLACE_M = 0.15, 0.9  # around a piece that was moved, and from where the chair turns
_PLACED_M = 0.05  # a piece is mapped this near to its sides
_APART_M = 0.15  # a cell this far from every surface is not of the home
_KEY_SIGMAS = np.array((0.005, 0.005, math.radians(0.1)))
_PERSON_M, _PEOPLE, _ASIDE_M = 0.15, 5, (0.55, 1.5)
_LEAST_GONE, _LEAST_FOUND = 40.0, 80.0  # percent of cells, of homes
_ODOMETRY = 0.01  # error as a share of distance and turn


@dataclass(frozen=True)
class Kept:
    """The result for one home's map."""

    added_off_m: Spread
    """Distances of added cells from the present surfaces."""
    off_m: Spread
    """Distances of all occupied cells from present surfaces, or those at the time of mapping."""
    new: int
    """Added cells where an object stands now."""
    old: int
    """Cells of the first map for furniture that was moved since."""
    left: int
    """Number of those in the last map."""
    nothing: int
    """Added cells where nothing of the home ever stood."""
    early: int
    """Cells changed after the first drive alone."""
    wrong: int
    """Looks at which a wrong pose was claimed."""


def measure(report: Report, quick: bool, each: Callable[..., list[Kept]]) -> None:
    """Add the rows; `each` maps a function over seeds, as a pool does."""
    done = each(kept, range(_HOMES_QUICK if quick else _HOMES))
    off_m, added_off_m = (
        together(getattr(one, name) for one in done).percentile(95.0)
        for name in ("off_m", "added_off_m")
    )
    name = f"maps kept current ({len(done)} homes, {DRIVES} drives): walls, 95 %"
    report.add(name, off_m, "m", WALLS_M)
    report.add("  what was added, 95 %", added_off_m, "m", WALLS_M)
    old, left = sum(one.old for one in done), sum(one.left for one in done)
    gone = 100.0 * (1.0 - left / old) if old else math.nan
    report.add("  moved furniture: gone where it was", gone, "%", _LEAST_GONE, at_least=True)
    found = 100.0 * sum(one.new > 0 for one in done) / len(done)
    report.add("  homes with some of it where it is", found, "%", _LEAST_FOUND, at_least=True)
    report.add("  cells of people who stood", float(sum(one.nothing for one in done)), "", 0.0)
    report.add("  cells changed after one drive", float(sum(one.early for one in done)), "", 0.0)
    report.add("  confidently wrong meanwhile", float(sum(one.wrong for one in done)), "", 0.0)


def of_row(row: dict[str, Any]) -> Kept:
    """A result from its JSON row."""
    return Kept(**{**row, **{name: Spread(**row[name]) for name in ("added_off_m", "off_m")}})


def kept(seed: int, drives: int = DRIVES) -> Kept:
    """Map a home, move its furniture, and drive through it `drives` times."""
    chance = np.random.default_rng(seed)
    home = home_plans.home(seed)
    home.people, home.script = (), ()
    moved, rooms = changed(home, chance)
    first = _mapped(home, list(_route(home, rooms)), chance)
    before, now = (one.segments(LIDAR_HEIGHT_M) for one in (home, moved))
    both = np.concatenate((before, now))
    early = wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        store = MapStore(Path(folder))
        HomeMap("home", first).save(store.folder / "a.map")
        for number in range(drives):
            wrong += _drive(store, moved, list(_route(moved, rooms)), number, chance)
            if number == 0:
                early = int((_grid(store).occupied != first.occupied).sum())
        last = _grid(store)
    added = _centres(last, last.occupied & ~first.occupied)
    off_m = surfaces_off_m(added, now)
    stood = np.array(
        [edge for one in home.furniture for edge in one.edges() if one not in moved.furniture]
    )
    was, left = (
        (surfaces_off_m(one.occupied_m(), now) > _APART_M)
        & (surfaces_off_m(one.occupied_m(), stood) < _PLACED_M)
        for one in (first, last)
    )
    return Kept(
        Spread.of(off_m, OFF_STEP_M),
        Spread.of(surfaces_off_m(last.occupied_m(), both), OFF_STEP_M),
        int((off_m < WALLS_M).sum()),
        int(was.sum()),
        int(left.sum()),
        int((surfaces_off_m(added, both) > _APART_M).sum()),
        early,
        wrong,
    )


def changed(home: Home, chance: np.random.Generator) -> tuple[Home, list[str]]:
    """The home with furniture moved and a door closed, and the rooms to drive through.

    No door is closed where that would leave the chair no place to turn in the corridor.
    """
    pieces = list(home.furniture)
    rooms = ["corridor"]
    for number in chance.permutation(len(pieces)).tolist():
        if len(rooms) > _PIECES:
            break
        room = _room(home, pieces[number])
        if room not in rooms:
            elsewhere = _elsewhere(home, pieces, number, chance)
            if elsewhere is not None:
                pieces[number] = elsewhere
                rooms.append(room)
    moved = replace(home, furniture=tuple(pieces))
    moved.changed()
    moved.doors = tuple(replace(one) for one in home.doors)
    for door in home.doors:
        if door.name not in rooms:
            moved.set_door(door.name, False)
            if Router(moved).place(*moved.places["corridor"]) is not None:
                break
            moved.set_door(door.name, door.open)
    return moved, rooms


def _room(home: Home, piece: Solid) -> str:
    middle = np.mean(piece.corners, axis=0)
    return min(home.places, key=lambda name: math.dist(home.places[name], middle.tolist()))


def _elsewhere(
    home: Home, pieces: list[Solid], number: int, chance: np.random.Generator
) -> Solid | None:
    """The piece moved to a free place in its room; None: it cannot be moved."""
    piece = pieces[number]
    if piece.z1_m >= 2.0 or not piece.z0_m <= LIDAR_HEIGHT_M <= piece.z1_m:
        return None
    others = replace(home, furniture=tuple(one for one in pieces if one is not piece))
    others.changed()
    surfaces = others.segments(LIDAR_HEIGHT_M)
    x_m, y_m = np.mean(piece.corners, axis=0).tolist()
    for _ in range(_TRIES):
        way_m, bearing = chance.uniform(*_SHIFT_M), chance.uniform(-math.pi, math.pi)
        off = way_m * np.array((math.cos(bearing), math.sin(bearing)))
        corners = np.array(piece.corners) + off
        edges = np.concatenate(
            [
                np.linspace(one, after, 12)
                for one, after in zip(corners, np.roll(corners, -1, 0), strict=True)
            ]
        )
        open_m = others.cast(x_m, y_m, np.array([bearing]), LIDAR_HEIGHT_M)[0]
        apart = min(math.dist(one, corners.mean(axis=0)) for one in home.places.values())
        if open_m > way_m and apart > _PLACE_M and surfaces_off_m(edges, surfaces).min() > _FREE_M:
            return replace(piece, corners=tuple((x, y) for x, y in corners.tolist()))
    return None


def _route(home: Home, rooms: list[str]) -> Iterator[FloatArray]:
    """Poses (3,) from the corridor through these rooms and back, as far as possible."""
    router = Router(home)
    begin = router.place(*home.places["corridor"])
    assert begin is not None
    here = Pose(*begin, 0.0)
    for name in [one for room in rooms[1:] for one in (room, "corridor")]:
        way = router.route(router.costs_to(*home.places[name]), here)
        for pose in way[::_EVERY]:
            yield np.array((pose.x_m, pose.y_m, math.radians(pose.heading_deg)))
        here = way[-1] if way else here


def _mapped(home: Home, poses: list[FloatArray], chance: np.random.Generator) -> OccupancyGrid:
    keys = []
    for pose in poses:
        seen = look(home, pose, chance, (FRONT, REAR))
        known = pose + chance.normal(0.0, _KEY_SIGMAS)
        keys.append(KeyScan(known, seen.points_m, seen.origins_m, 0.0, 0.0, 0.0))
    return occupancy_of(keys)


def _drive(
    store: MapStore, home: Home, poses: list[FloatArray], number: int, chance: np.random.Generator
) -> int:
    """Run one drive; returns the number of looks with a wrong pose."""
    crowd = _crowd(poses, chance)
    grid = _grid(store)
    atlas, keeping = Atlas(), Keeping(store, lambda: (number + 1) * (APART_S + 60.0))
    atlas.know({"a": grid})
    odometry, wrong = np.zeros(3), 0
    atlas.place("a", poses[0], odometry, 0)
    stands = [poses[-1]] * 100  # until it is stored
    for step, pose in enumerate([*poses, *stands]):
        moved = between(poses[max(0, min(step, len(poses)) - 1)], pose)
        odometry = compose(odometry, moved * (1.0 + chance.normal(0.0, _ODOMETRY, 3)))
        seen = Seen(look(home, pose, chance, crowd=crowd), odometry, _estimate(_LOOK_S * step))
        location = atlas.look(seen)
        wrong += location is not None and not is_right(location, pose)
        if location is None or not atlas.sure:
            keeping.unsure()
        elif keeping.look("a", atlas.grid, seen, location):
            atlas.know({"a": _grid(store)})
    return wrong


def _crowd(poses: list[FloatArray], chance: np.random.Generator) -> FloatArray:
    """People who stand beside the route, not in its way: rows x, y, radius."""
    found: list[tuple[float, float, float]] = []
    while len(found) < _PEOPLE:
        pose = poses[int(chance.integers(len(poses)))]
        bearing, away_m = chance.uniform(-math.pi, math.pi), chance.uniform(*_ASIDE_M)
        at = pose[:2] + away_m * np.array((math.cos(bearing), math.sin(bearing)))
        if all(math.dist(at, one[:2]) > _ASIDE_M[0] for one in poses):
            found.append((float(at[0]), float(at[1]), _PERSON_M))
    return np.array(found)


def _estimate(at_s: float) -> Estimate:
    return Estimate(at_s, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.1, 0.1, 0.1, 1.0, (), 0)


def _grid(store: MapStore) -> OccupancyGrid:
    stored = store.get("a")
    assert stored is not None
    assert stored.map is not None
    return stored.map.grid


def _centres(grid: OccupancyGrid, cells: np.ndarray) -> FloatArray:
    return np.asarray((np.argwhere(cells) + 0.5) * grid.cell_m + grid.low_m)
