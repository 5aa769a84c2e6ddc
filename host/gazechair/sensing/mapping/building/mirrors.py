"""Finds mirrors along the walls of a finished map, and removes the rooms seen in them.

A mirror shows the room in front of it, reflected at the mirror's line: a piece of a line is a
mirror if nearly all beams that cross it, reflected there, end on known surfaces in front of it, or
on what only the mirror shows: the far side of furniture. A doorway is none: the chair has driven
through it, or the room behind is another one. Nor is the middle of a symmetrical room: what is
behind it is also seen past it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray, IntArray
from gazechair.base.poses import to_frame
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, along_beams, marked

_MOST_BEAMS = 60_000  # looked at
_LINE_M = 0.025  # from one line to the next
_BEHIND_M = 0.12  # ends nearer behind a line are ignored
_NEAR_M = 0.075  # an end this near to a known surface lies on it
_BIN_M = 0.05
_MATCHED = 0.9  # of the beams that cross a bin
_AROUND, _MATCHED_AROUND = 2, 0.85  # bins at each side, and of the beams that cross all of them
_SHORTEST_M, _LONGEST_M = 0.3, 3.0
_DEEP_M = 0.4  # average depth of the room behind: less is a niche, or something at the wall
_SPREAD_M = 0.4  # of the depths: a single wall may lie as far behind as another does in front
_LEAST_BEAMS = 60
_OFF_M = 0.15  # from a line to those beside it
_TELLS, _AGAINST = 0.1, 2.5  # of the beams match only at it; the more, the more cannot be
_CLOSE_M = 0.1  # to a beam's end: what is this near is not in its way
_WALL_M, _WALL_SHARE = 0.35, 0.6  # this far from an end, a wall continues or nothing is seen
_BEHIND_WALL_M = 0.0, 0.1  # a mirror hangs before its wall
_WIDER_M = 0.1  # than what was found
_LEAST_HITS = 2  # of a cell in which something stood at any time
_PAST = 0.25  # of what is behind it: more is seen past it, too


@dataclass(frozen=True)
class Mirror:
    """A piece of a line `axis` = `at_m` (0: x, 1: y), seen from the side `side` (-1: below)."""

    axis: int
    at_m: float
    low_m: float
    high_m: float
    side: int
    beams: int

    def at(self, along: FloatArray, behind_m: float = 0.0) -> FloatArray:
        """(N, 2): these places of its line, or behind it."""
        across = np.full(len(along), self.at_m - self.side * behind_m)
        return np.stack((across, along) if self.axis == 0 else (along, across), axis=1)

    def crossed(self, starts_m: FloatArray, ends_m: FloatArray) -> BoolArray:
        """(N,): which beams cross it."""
        beyond, along = _crossing(self.axis, self.at_m, self.side, starts_m, ends_m)
        inside = (along > self.low_m - _WIDER_M) & (along < self.high_m + _WIDER_M)
        return np.asarray(beyond & inside)


def without_mirrored(keys: Sequence[KeyScan], grid: OccupancyGrid) -> list[KeyScan]:
    """The key scans without what they saw in mirrors."""
    kept = list(keys)
    for mirror in found(keys, grid):
        for number, key in enumerate(kept):
            beams = to_frame(key.origins_m, key.pose), to_frame(key.points_m, key.pose)
            stays = ~mirror.crossed(*beams)
            if not stays.all():
                points, origins = key.points_m[stays], key.origins_m[stays]
                kept[number] = replace(key, points_m=points, origins_m=origins)
    return kept


def found(keys: Sequence[KeyScan], grid: OccupancyGrid) -> list[Mirror]:
    """Mirrors seen in these key scans, the clearest first; one for each stretch of wall."""
    starts = np.concatenate([to_frame(key.origins_m, key.pose) for key in keys])
    ends = np.concatenate([to_frame(key.points_m, key.pose) for key in keys])
    every = max(1, len(ends) // _MOST_BEAMS)
    starts, ends = starts[::every], ends[::every]
    track = np.array([key.pose[:2] for key in keys])
    seen = _Seen(starts, ends, track, grid)
    candidates: list[Mirror] = []
    for axis in (0, 1):
        low, high = ends[:, axis].min(), ends[:, axis].max()
        for at_m in np.arange(low, high, _LINE_M).tolist():
            for side in (-1, 1):
                candidates += _on_line(axis, at_m, side, seen)
    candidates.sort(key=lambda mirror: -mirror.beams)
    chosen: list[Mirror] = []
    while more := _not_seen_past(candidates, seen, chosen):
        chosen += more
    return chosen


class _Known:
    """Tells whether a place lies on one of the cells, or near it."""

    def __init__(
        self, cells: BoolArray, low_m: FloatArray, cell_m: float, near_m: float = _NEAR_M
    ) -> None:
        """`cells`: (nx, ny) of `cell_m`; (0, 0) begins at `low_m`."""
        reach = round(near_m / cell_m)
        wide = np.pad(cells, reach)
        near = np.zeros(wide.shape, dtype=bool)
        for di in range(-reach, reach + 1):
            for dj in range(-reach, reach + 1):
                near |= np.roll(wide, (di, dj), axis=(0, 1))
        self._near: BoolArray = near
        self._low_m, self._cell_m = low_m - reach * cell_m, cell_m

    def at(self, places_m: FloatArray) -> BoolArray:
        """(N,), of places (N, 2)."""
        cells = np.floor((places_m - self._low_m) / self._cell_m).astype(np.int64)
        return marked(self._near, cells)


class _Seen:
    """What the key scans saw: from `starts` to `ends`, from the chair's places on `track`."""

    def __init__(
        self, starts: FloatArray, ends: FloatArray, track: FloatArray, grid: OccupancyGrid
    ) -> None:
        self.starts, self.ends, self.track = starts, ends, track
        place = grid.low_m, grid.cell_m
        # Something that was moved since is in the mirror, too; what it hangs on was not moved.
        self.known, self.walls = (
            _Known(grid.hits >= _LEAST_HITS, *place),
            _Known(grid.occupied, *place),
        )
        self._stands, self._free = (
            _Known(cells, *place, 0.0) for cells in (grid.occupied, grid.free)
        )
        self._cell_m = grid.cell_m

    def cannot_be(self, from_m: FloatArray, to_m: FloatArray) -> BoolArray:
        """(N,): which of these beams end where the floor is free, or have something in the way."""
        beam, at = along_beams(from_m / self._cell_m, to_m / self._cell_m, _CLOSE_M / self._cell_m)
        at *= self._cell_m
        begun = np.hypot(*(at - from_m[beam]).T) > _CLOSE_M
        ends = self._free.at(to_m)
        ends[beam[begun & self._stands.at(at)]] = True
        return ends


def _on_line(axis: int, at_m: float, side: int, seen: _Seen) -> list[Mirror]:
    beyond, along = _crossing(axis, at_m, side, seen.starts, seen.ends)
    if np.count_nonzero(beyond) < _LEAST_BEAMS:
        return []
    along, behind = along[beyond], seen.ends[beyond].copy()
    depth = np.abs(behind[:, axis] - at_m)
    behind[:, axis] = 2.0 * at_m - behind[:, axis]
    matched = seen.known.at(behind)
    begin_m = float(along.min())
    bins = ((along - begin_m) / _BIN_M).astype(np.int64)
    mirrors = []
    for first, last in _stretches(bins, matched):
        low_m, high_m = begin_m + first * _BIN_M, begin_m + last * _BIN_M
        inside = (bins >= first) & (bins < last)
        if not _SHORTEST_M <= high_m - low_m <= _LONGEST_M or inside.sum() < _LEAST_BEAMS:
            continue
        if depth[inside].mean() < _DEEP_M or depth[inside].std() < _SPREAD_M:
            continue
        mirror = Mirror(axis, at_m, low_m, high_m, side, int(matched[inside].sum()))
        if not _hangs(mirror, seen.walls, along):
            continue
        if not _matches_here(mirror, along[inside], behind[inside], matched[inside], seen):
            continue
        if not _driven(mirror, seen.track):
            mirrors.append(mirror)
    return mirrors


def _stretches(bins: IntArray, matched: BoolArray) -> set[tuple[int, int]]:
    """Stretches of bins that may be mirrors: (first, first that is not in it).

    Nearly all beams match there: in each bin alone, or with those beside it, as few beams cross one
    and people match nothing. Or it is a whole opening: of what is in the room, some may have been
    seen in the mirror only.
    """
    count, matches = np.bincount(bins), np.bincount(bins, matched)
    found = set()
    for wide, share in ((1, _MATCHED), (2 * _AROUND + 1, _MATCHED_AROUND)):
        ones, cut = np.ones(wide), slice(wide // 2, wide // 2 + len(count))
        enough = np.convolve(matches, ones)[cut] >= share * np.convolve(count, ones)[cut]
        found |= _runs((count > 0) & enough)
    return found | _runs(count > 0)


def _runs(bins: BoolArray) -> set[tuple[int, int]]:
    """Each run of set bins: (first, first that is not in it)."""
    edges = np.flatnonzero(np.diff(np.pad(bins, 1).astype(np.int8)))
    return set(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _matches_here(
    mirror: Mirror, along: FloatArray, behind: FloatArray, matched: BoolArray, seen: _Seen
) -> bool:
    """Whether enough of what is behind the line, reflected at it, matches at this line only.

    `along`, `behind`: where the beams cross the line, and their reflected ends. Walls at right
    angles to it match themselves when reflected at any line.
    """
    beside = np.zeros(len(behind), dtype=bool)
    for off_m in (-_OFF_M, _OFF_M):
        moved = behind.copy()
        moved[:, mirror.axis] += 2.0 * off_m
        beside |= seen.known.at(moved)
    tells = (matched & ~beside).mean()
    if tells < _TELLS:
        return False
    against = seen.cannot_be(mirror.at(along)[~matched], behind[~matched])
    return bool(tells >= _AGAINST * against.sum() / len(behind))


def _hangs(mirror: Mirror, walls: _Known, through: FloatArray) -> bool:
    """Whether a wall continues at an end of it, and nothing else is seen at the other.

    `through`: where beams that end behind the line cross it.
    """
    beside = np.arange(0.5 * _BIN_M, _WALL_M, 0.5 * _BIN_M)
    share, closed = [], []
    for along in (mirror.low_m - beside, mirror.high_m + beside):
        wall = np.zeros(len(along), dtype=bool)
        for behind_m in _BEHIND_WALL_M:
            wall |= walls.at(mirror.at(along, behind_m))
        seen = (np.abs(along[:, None] - through) < 0.5 * _BIN_M).any(axis=1)
        share.append(wall.mean())
        closed.append((wall | ~seen).mean())
    return bool(max(share) >= _WALL_SHARE and min(closed) >= _WALL_SHARE)


def _not_seen_past(
    candidates: Sequence[Mirror], seen: _Seen, chosen: Sequence[Mirror]
) -> list[Mirror]:
    """The candidates on other walls of which little is seen past them, one for each.

    What the chosen mirrors show is seen past nothing: two on one wall may show the same.
    """
    shown = np.zeros(len(seen.ends), dtype=bool)
    for mirror in chosen:
        shown |= mirror.crossed(seen.starts, seen.ends)
    more: list[Mirror] = []
    for one in candidates:
        alone = not any(_same_wall(one, other) for other in (*chosen, *more))
        if alone and _seen_past(one, seen, shown) < _PAST:
            more.append(one)
    return more


def _seen_past(mirror: Mirror, seen: _Seen, shown: BoolArray) -> float:
    """Share of what is seen through it that is also seen past it: there is no mirror, then.

    `shown`: (N,), what other mirrors show.
    """
    through = mirror.crossed(seen.starts, seen.ends)
    cells = np.round(seen.ends / _NEAR_M).astype(np.int64)
    lowest = cells.min(axis=0)
    cells -= lowest
    past = np.zeros(cells.max(axis=0) + 1, dtype=bool)
    past[tuple(cells[~through & ~shown].T)] = True
    near_past = _Known(past, (lowest - 0.5) * _NEAR_M, _NEAR_M)
    return float(near_past.at(seen.ends[through]).mean())


def _driven(mirror: Mirror, track: FloatArray) -> bool:
    """Whether the chair drove through it, or was right behind it."""
    off = -mirror.side * (track[:-1, mirror.axis] - mirror.at_m)
    along = track[:-1, 1 - mirror.axis]
    behind = (off > 0.0) & (off < _LONGEST_M) & (along > mirror.low_m) & (along < mirror.high_m)
    return bool((mirror.crossed(track[:-1], track[1:]) | behind).any())


def _crossing(
    axis: int, at_m: float, side: int, starts: FloatArray, ends: FloatArray
) -> tuple[BoolArray, FloatArray]:
    """(beams that come from `side` of the line and end behind it, where each beam crosses it)."""
    before, after = side * (starts[:, axis] - at_m), side * (ends[:, axis] - at_m)
    beyond = (before > 0.0) & (after < -_BEHIND_M)
    share = np.where(beyond, before / np.where(beyond, before - after, 1.0), 0.0)
    other = 1 - axis
    return beyond, starts[:, other] + share * (ends[:, other] - starts[:, other])


def _same_wall(one: Mirror, other: Mirror) -> bool:
    if one.axis != other.axis or abs(one.at_m - other.at_m) > 4.0 * _WIDER_M:
        return False
    return one.low_m < other.high_m and other.low_m < one.high_m
