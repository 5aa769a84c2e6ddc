"""Updates a map by the differences that several later drives have found.

Known surfaces are never moved or thickened: returns within 0.1 m of one count as that surface. A
new surface counts where the map has free floor and three drives in a row have seen it, most of it
each time; a surface is gone when two drives in a row have seen free floor there and nothing near
it. A single drive changes nothing, so that people who stand and doors that are closed for once
leave no trace.
"""

from __future__ import annotations

import json
import zlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gazechair.base import json_text
from gazechair.base.arrays import BoolArray, FloatArray, IntArray
from gazechair.base.state_folder import replace_file
from gazechair.sensing.mapping.building.occupancy_grid import (
    Counts,
    OccupancyGrid,
    along_beams,
    through_middle,
)
from gazechair.sensing.mapping.locating.map_match import Look

Drives = NDArray[np.uint8]

NEW_AFTER, GONE_AFTER = 3, 2  # drives in a row
_SEEN_M = 4.0  # points farther away are too uncertain
_SHORT_M = 0.06  # a beam clears nothing this close to its end
_NEAR_M = 0.1  # a return this near to a known surface counts as that surface
_BEHIND_M = 0.15  # returns this far behind a known surface are ignored
_LOOKS, _TAKEN, _BLOCKS = 3, 0.3, 0.2  # of a drive, and shares of the looks at a cell
_SAME = 2  # cells
_FIRM = 0.6  # share of hits of a solid cell: glass and thin legs have less
_CLUSTER_M, _CLUSTER = 0.1, 3  # cells that change together; fewer are noise
# Of all that drives in a row found around a new surface, the share that lies within a cell of it:
# people who stood at nearly the same place overlap in a small part.
_AROUND_M, _REPEATED = 0.15, 0.7
_DEPTH_M = 0.7  # of furniture: floor this near to where it stood counts once it is seen
_MOST = 0.2  # share of all surfaces: more at once is another home, or needs a new map
_SURE = 10  # looks that a changed cell stands for
_MAGIC = b"gazechair-drives 1\n"


@dataclass(frozen=True)
class Ledger:
    """Number of drives in a row in which each cell differed from the map."""

    taken: Drives
    free: Drives
    grid_crc: int
    drive_s: float = 0.0
    """When the newest of them was, in seconds since 1970."""

    @staticmethod
    def of(grid: OccupancyGrid) -> Ledger:
        """An empty ledger of `grid`."""
        none = np.zeros(grid.hits.shape, dtype=np.uint8)
        return Ledger(none, none, _crc(grid))

    def save(self, path: Path) -> None:
        """Replace the file atomically. Raises OSError."""
        head = {"grid_crc": self.grid_crc, "drive_s": self.drive_s}
        counts = np.stack((self.taken, self.free)).tobytes()
        data = _MAGIC + json.dumps(head).encode() + b"\n" + zlib.compress(counts)
        replace_file(path, data + zlib.crc32(data).to_bytes(4, "little"))


def load_ledger(path: Path, grid: OccupancyGrid) -> Ledger:
    """The ledger of this map; empty when the file is absent, damaged or of another map."""
    fresh = Ledger.of(grid)
    try:
        data = path.read_bytes()
        data, crc = data[:-4], data[-4:]
        if not data.startswith(_MAGIC) or zlib.crc32(data).to_bytes(4, "little") != crc:
            return fresh
        line, _, body = data[len(_MAGIC) :].partition(b"\n")
        head = json_text.parse(line)
        if head["grid_crc"] != fresh.grid_crc:
            return replace(fresh, drive_s=float(head["drive_s"]))
        shape = (2, *grid.hits.shape)
        counts = zlib.decompressobj().decompress(body, 2 * grid.hits.size)
        taken, free = np.frombuffer(counts, dtype=np.uint8).reshape(shape)
        return Ledger(taken, free, fresh.grid_crc, float(head["drive_s"]))
    except (OSError, ValueError, KeyError, TypeError, OverflowError, zlib.error):
        return fresh


class Upkeep:
    """One drive in a known map: feed it looks at their places in the map."""

    def __init__(self, grid: OccupancyGrid, before: Ledger) -> None:
        self._grid = grid
        self._before = before
        occupied, cell_m = grid.occupied, grid.cell_m
        self._occupied = occupied
        self._near = round(_NEAR_M / cell_m)
        self._known = _wide(occupied, self._near)
        self._floor = _wide(grid.free, 1) & ~self._known
        seen = np.maximum(1, grid.hits.astype(np.int64) + grid.passes)
        self._firm = occupied & (grid.hits >= _FIRM * seen)
        shape = grid.hits.shape
        self._new, self._ends, self._passes = (np.zeros(shape, dtype=np.uint16) for _ in range(3))
        self._recent: list[tuple[IntArray, ...]] = []  # cells of each look
        self.too_much = False
        """So much differs that the map is not updated."""

    def look(self, look: Look, pose: FloatArray) -> None:
        """Take a look from a new place; it counts once `settle` is called."""
        grid = self._grid
        placed = look.moved(pose)
        start, end = (
            (one - grid.low_m) / grid.cell_m for one in (placed.origins_m, placed.points_m)
        )
        length = np.hypot(*(end - start).T)
        near = length < _SEEN_M / grid.cell_m
        short = _SHORT_M / grid.cell_m
        cut = np.where(near, 1.0, (_SEEN_M / grid.cell_m + short) / np.maximum(length, 1e-9))
        reach = start + (end - start) * cut[:, None]
        inside = np.ones(len(start), dtype=bool)
        for one in (start, reach):
            inside &= ((one >= 0) & (one < grid.hits.shape)).all(axis=1)
        start, end, near = start[inside], reach[inside], near[inside]
        beam, at = along_beams(start, end, short)
        cells = at.astype(np.int64)
        away = np.hypot(*(end[beam] - at).T) > _BEHIND_M / grid.cell_m
        through = self._occupied[cells[:, 0], cells[:, 1]] & away
        behind = np.bincount(beam[through], minlength=len(start)) > 0
        ends = end.astype(np.int64)
        floor = self._floor[ends[:, 0], ends[:, 1]]
        found = (ends[near & floor & ~behind], ends[near], through_middle(at))
        new, met, passed = (np.unique(one @ (grid.hits.shape[1], 1)) for one in found)
        self._recent.append((new, met, np.setdiff1d(passed, met, assume_unique=True)))

    def settle(self) -> None:
        """Accept all looks so far: the pose was known well."""
        for seen in self._recent:
            for counts, cells in zip((self._new, self._ends, self._passes), seen, strict=True):
                counts.ravel()[cells] += 1
        self._recent = []

    def drop(self) -> None:
        """Discard the looks since `settle`: the pose is no longer known well."""
        self._recent = []

    def ledger(self, drive_s: float) -> Ledger:
        """The ledger including this drive so far; `drive_s`: its time, seconds since 1970."""
        seen = np.maximum(1, self._ends.astype(np.int64) + self._passes)
        taken = (self._new >= _LOOKS) & (self._new >= _TAKEN * seen)
        blocked = (self._ends > 0) & (self._ends >= _BLOCKS * seen)
        free = (self._passes >= _LOOKS) & ~_wide(blocked, self._near)
        before = self._before
        # Poses are accurate to a cell or two: the same surface may be in another cell today.
        again = taken | (_wide(taken, _SAME) & (before.taken > 0))
        counts = np.where(again, before.taken + 1, np.where(free, 0, before.taken))
        absent = np.where(_wide(blocked, 1), 0, before.free + (free & ~self._grid.free))
        most = 2 * NEW_AFTER
        clipped = [np.minimum(one, most).astype(np.uint8) for one in (counts, absent)]
        return Ledger(clipped[0], clipped[1], before.grid_crc, drive_s)

    def updated(self, drive_s: float) -> tuple[OccupancyGrid, Ledger] | None:
        """The map updated by what enough drives found, and the ledger of the rest; None: no change.

        See `ledger`, `too_much`.
        """
        ledger, grid = self.ledger(drive_s), self._grid
        cluster = round(_CLUSTER_M / grid.cell_m)
        new = _clustered(ledger.taken >= NEW_AFTER, cluster) & self._floor
        new &= _is_most(new, ledger.taken > 0, round(_AROUND_M / grid.cell_m))
        gone = _clustered(self._firm & (ledger.free >= GONE_AFTER), cluster)
        changed = int(new.sum() + gone.sum())
        self.too_much = bool(changed > _MOST * self._occupied.sum())
        if not changed or self.too_much:
            return None
        opened = _wide(gone, round(_DEPTH_M / grid.cell_m)) & ~self._occupied
        opened &= (grid.passes == 0) & (ledger.free >= GONE_AFTER)
        hits: Counts = np.where(new, _SURE, np.where(gone | opened, 0, grid.hits)).astype(np.uint16)
        passes: Counts = np.where(new, 0, grid.passes).astype(np.uint16)
        passes = np.where(gone | opened, np.maximum(passes, _SURE), passes).astype(np.uint16)
        made = OccupancyGrid(grid.cell_m, grid.low_m, hits, passes)
        near = _wide(new | gone, self._near)
        near |= opened
        taken, free = (
            np.where(near, 0, one).astype(np.uint8) for one in (ledger.taken, ledger.free)
        )
        return made, Ledger(taken, free, _crc(made), drive_s)


def _crc(grid: OccupancyGrid) -> int:
    return zlib.crc32(grid.passes.tobytes(), zlib.crc32(grid.hits.tobytes()))


def _wide(marks: BoolArray, cells: int) -> BoolArray:
    """Whether any cell within `cells` along both axes is marked."""
    return np.asarray(_sums(marks, cells) > 0)


def _clustered(marks: BoolArray, cells: int) -> BoolArray:
    return np.asarray(marks & (_sums(marks, cells) >= _CLUSTER))


def _is_most(marks: BoolArray, of: BoolArray, cells: int) -> BoolArray:
    """Whether, within `cells` along both axes, most of `of` lies within a cell of marked ones."""
    return np.asarray(_sums(of & _wide(marks, 1), cells) >= _REPEATED * _sums(of, cells))


def _sums(marks: BoolArray, cells: int) -> NDArray[np.signedinteger]:
    """Number of marked cells within `cells` of each cell along both axes."""
    side = 2 * cells + 1
    total = np.pad(marks.astype(np.int32), cells).cumsum(axis=0).cumsum(axis=1)
    total = np.pad(total, ((1, 0), (1, 0)))
    return np.asarray(
        total[side:, side:] - total[:-side, side:] - total[side:, :-side] + total[:-side, :-side]
    )
