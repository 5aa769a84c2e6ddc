"""Costmap: where the chair's true footprint fits, by the map, no-go areas and what is seen now.

Cells that no beam has passed count as occupied. Obstacles that are seen but not in the map ("live")
are kept until beams pass through their place, and for some seconds when out of sight.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray, IntArray
from gazechair.base.footprint import Footprint, inside
from gazechair.going.beams import looked_through
from gazechair.going.distance_field import Distances, discs_of, distances
from gazechair.going.outline import outline, wider
from gazechair.going.standing import Ahead, standing_m
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid

FAR_M = 0.9  # the distance field ends here
_SPECK_M = 0.06  # unknown cells this near to free ones are gaps between beams
_KNOWN_M = 0.12  # a return this near to what the map holds is explained by it
KEPT_S = 6.0  # how long a live obstacle is kept after it was last seen
_GAP_M, _GAP_FREE_M = 0.2, 0.15  # the same limit where nothing stands within the second one
_PAD_M = 1.2
_LIVE_FAR_M = 4.0  # returns farther from the chair are not overlaid


class Costmap:
    """Distances to obstacles on the floor, in the map's frame."""

    def __init__(
        self,
        occupied: BoolArray,
        free: BoolArray,
        cell_m: float,
        low_m: FloatArray,
        footprint: Footprint,
        no_go: Sequence[FloatArray] = (),
    ) -> None:
        """`no_go`: polygons (N, 2) in the map's frame."""
        pad = int(np.ceil(_PAD_M / cell_m))
        self.cell_m = cell_m
        self.low_m = np.asarray(low_m, dtype=np.float64) - pad * cell_m
        stands = np.pad(occupied, pad)
        unknown = np.pad(~(occupied | free), pad, constant_values=True)
        seen = distances(~unknown, cell_m, 4 * _SPECK_M)
        self.known_m = distances(stands, cell_m, FAR_M)
        near_m = np.where(self.known_m > _GAP_FREE_M, _GAP_M, _SPECK_M)
        self._static = stands | (unknown & (seen > near_m)) | self._within(no_go, stands)
        self.static_m = distances(self._static, cell_m, FAR_M)
        self.ahead = Ahead(footprint)
        self.standing_in_map_m = standing_m(stands, cell_m, self.low_m)
        """Those of `standing_m` that the map holds."""
        self._standing_m = {"map": self.standing_in_map_m}
        self.standing_m = self.standing_in_map_m
        """Cell centres (N, 2) of what the board may take for a standing person."""
        self._seen_s = np.full(stands.shape, -np.inf)
        self._live = np.zeros(stands.shape, dtype=np.bool_)
        self.distances_m: Distances = self.static_m
        self.changes = 0
        """Incremented after each change: who reads it first, on another thread, misses none."""
        parts = outline(footprint)
        discs = np.concatenate([discs_of(part) for part in parts])
        in_cells = discs[:, :2].astype(np.float32) / np.float32(cell_m)
        self._disc_cells = in_cells[:, 0], in_cells[:, 1], discs[:, 2].astype(np.float32)
        self.disc_m = float(discs[:, 2].max())
        """Radius of the largest disc that covers the footprint."""
        self.reach_m = float(np.hypot(*np.concatenate(parts).T).max())
        self.wider_m = max(wider(footprint.margins).widths_m)
        """The most by which a margin is wider than the default one."""

    def suspect(self, points_m: FloatArray) -> None:
        """Replace the points, in the map's frame, that may be persons as seen now."""
        cells = np.unique(np.stack(self._cells(points_m), axis=1), axis=0)
        self._may_stand("seen", self._centres_m(cells))

    def _may_stand(self, source: str, places_m: FloatArray) -> None:
        if not np.array_equal(self._standing_m.get(source, np.zeros((0, 2))), places_m):
            self._standing_m[source] = places_m
            self.standing_m = np.concatenate(list(self._standing_m.values()))
            self.changes += 1

    def _centres_m(self, cells: IntArray) -> FloatArray:
        """(N, 2) of cells (N, 2)."""
        return np.asarray((cells + 0.5) * self.cell_m + self.low_m)

    @property
    def shape(self) -> tuple[int, int]:
        """Cells along x and y."""
        nx, ny = self.known_m.shape
        return nx, ny

    def _within(self, no_go: Sequence[FloatArray], like: BoolArray) -> BoolArray:
        found = np.zeros(like.shape, dtype=np.bool_)
        cells = _cells_of(~found)
        centres = (cells + 0.5) * self.cell_m + self.low_m
        for polygon in no_go:
            # A drawn strip may be thinner than a cell: its outline counts, too.
            found.reshape(-1)[inside(np.asarray(polygon), centres)] = True
            ends = np.roll(polygon, -1, axis=0)
            for a, b in zip(np.asarray(polygon), ends, strict=True):
                count = int(np.hypot(*(b - a)) / self.cell_m * 2.0) + 2
                found[self._cells(a + (b - a) * np.linspace(0.0, 1.0, count)[:, None])] = True
        return found

    def _cells(self, points_m: FloatArray) -> tuple[np.ndarray, np.ndarray]:
        cells = np.floor((points_m - self.low_m) / self.cell_m).astype(np.int64)
        nx, ny = self.shape
        return np.clip(cells[:, 0], 0, nx - 1), np.clip(cells[:, 1], 0, ny - 1)

    def see(self, points_m: FloatArray, at_s: float, chair_m: tuple[float, float]) -> FloatArray:
        """Take in a scan's returns, in the map's frame; returns those the map does not explain."""
        near = np.hypot(points_m[:, 0] - chair_m[0], points_m[:, 1] - chair_m[1]) < _LIVE_FAR_M
        points_m = points_m[near]
        cells = self._cells(points_m)
        new = self.known_m[cells] > _KNOWN_M
        found = points_m[new]
        self._seen_s[cells[0][new], cells[1][new]] = at_s
        return np.asarray(found)

    def clear(self, points_m: FloatArray, origins_m: FloatArray, at_s: float) -> None:
        """Remove live obstacles that the beams of a scan, in the map's frame, pass through."""
        cells = _cells_of(self._seen_s > at_s - KEPT_S)
        left = cells[looked_through(self._centres_m(cells), points_m, origins_m)]
        self._seen_s[left[:, 0], left[:, 1]] = -np.inf

    def forget(self, x_m: float, y_m: float, within_m: float) -> None:
        """Remove live obstacles within a distance of a point, until they are seen again."""
        cells = _cells_of(np.isfinite(self._seen_s))
        off_m = self._centres_m(cells) - (x_m, y_m)
        near = cells[np.hypot(off_m[:, 0], off_m[:, 1]) < within_m]
        self._seen_s[near[:, 0], near[:, 1]] = -np.inf

    def refresh(self, now_s: float) -> bool:
        """Bring the distances up to date with what was seen; True when they have changed."""
        live = self._seen_s > now_s - KEPT_S
        if np.array_equal(live, self._live):
            return False
        self._live = live
        self._may_stand("live", standing_m(live, self.cell_m, self.low_m))
        self.distances_m = self._with(live)
        self.changes += 1
        return True

    def _with(self, live: BoolArray) -> Distances:
        """Distances to what the map has and to the `live` cells."""
        if not live.any():
            return self.static_m
        # Only near live cells can a distance be less than the map's.
        reach = int(np.ceil(FAR_M / self.cell_m)) + 1
        xs, ys = _cells_of(live).T
        x0, x1 = max(0, xs.min() - reach), xs.max() + reach + 1
        y0, y1 = max(0, ys.min() - reach), ys.max() + reach + 1
        found = self.static_m.copy()
        own = distances(live[x0:x1, y0:y1], self.cell_m, FAR_M)
        np.minimum(found[x0:x1, y0:y1], own, out=found[x0:x1, y0:y1])
        return found

    def clearance_m(
        self, x_m: FloatArray, y_m: FloatArray, heading_rad: FloatArray | float
    ) -> FloatArray:
        """Metres from the outline to the nearest obstacle, below 0 inside; arrays of any shape."""
        if isinstance(heading_rad, float):
            return self._clearance_at(x_m, y_m, heading_rad)
        x, y, heading = np.broadcast_arrays(x_m, y_m, heading_rad)
        c, s = np.cos(heading)[..., None], np.sin(heading)[..., None]
        ahead, left, radii = self._disc_cells
        x0, y0 = (x - self.low_m[0]) / self.cell_m, (y - self.low_m[1]) / self.cell_m
        found = self._distances_at(
            x0[..., None] + c * ahead - s * left, y0[..., None] + s * ahead + c * left
        )
        return np.asarray((found - radii).min(axis=-1, initial=np.float32(FAR_M)))

    def _clearance_at(self, x_m: FloatArray, y_m: FloatArray, heading_rad: float) -> FloatArray:
        """Of many poses with one heading."""
        c, s = math.cos(heading_rad), math.sin(heading_rad)
        x0, y0 = (x_m - self.low_m[0]) / self.cell_m, (y_m - self.low_m[1]) / self.cell_m
        least = np.full(x0.shape, np.float32(FAR_M))
        for ahead, left, radius in zip(*self._disc_cells, strict=True):
            found = self._distances_at(x0 + (c * ahead - s * left), y0 + (s * ahead + c * left))
            np.minimum(least, found - radius, out=least)
        return least

    def _distances_at(self, x: FloatArray, y: FloatArray) -> Distances:
        """Distances at places given in cells."""
        field = self.distances_m
        i, j = x.astype(np.int32), y.astype(np.int32)
        np.minimum(np.maximum(i, 0, out=i), field.shape[0] - 1, out=i)
        np.minimum(np.maximum(j, 0, out=j), field.shape[1] - 1, out=j)
        i *= field.shape[1]
        i += j
        return np.asarray(field.reshape(-1).take(i))


def _cells_of(mask: BoolArray) -> IntArray:
    """(N, 2): the cells that are set, as np.argwhere, which takes eight times as long."""
    return np.stack(np.divmod(np.flatnonzero(mask), mask.shape[1]), axis=1)


def costmap_of(
    grid: OccupancyGrid, footprint: Footprint, no_go: Sequence[FloatArray] = ()
) -> Costmap:
    """Costmap of `grid` for the planner; `no_go`: polygons (N, 2) in its frame."""
    return Costmap(grid.occupied, grid.free, grid.cell_m, grid.low_m, footprint, no_go)
