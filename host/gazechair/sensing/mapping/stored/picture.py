"""A map as a picture: SVG with the track of the drive, or PNG for the pages, growing maps too."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

from gazechair.base.arrays import BoolArray, FloatArray
from gazechair.base.poses import to_frame
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.stored.home_map import HomeMap

_PIXELS_PER_M = 40.0
_STYLE = (
    "<style>.floor{fill:#dbe7f0}.stands{fill:#222}.track{fill:none;stroke:#d55e00}"
    ".bar{stroke:#666}text{font:14px sans-serif;fill:#666}</style>"
)

# Colours of a PNG: unknown (transparent), free floor, occupied, the track.
_PALETTE = bytes.fromhex("ffffff dbe7f0 222222 d55e00")
_OPACITY = bytes((0, 255, 255, 255))
_FLOOR, _STANDS, _TRACK = 1, 2, 3
_MOST_PIXELS = 1000  # a side
_SKETCH_M = 0.05
_SKETCH_EVERY = 4  # points
_SKETCH_FARTHEST_M = 8.0


@dataclass(frozen=True)
class Picture:
    """A PNG, and its position: cell size and lower left corner in the map, m."""

    png: bytes
    cell_m: float
    x_m: float
    y_m: float
    width: int
    height: int

    def as_json(self) -> dict[str, float]:
        """Everything but the PNG."""
        place = {"cell_m": self.cell_m, "x": self.x_m, "y": self.y_m}
        return {**place, "width": self.width, "height": self.height}


def drawn(home: HomeMap) -> Picture:
    """The map, scaled down to at most 1000 pixels a side; a pixel is a square of cells."""
    grid = home.grid
    many = -(-max(grid.hits.shape) // _MOST_PIXELS)
    stands, floor = _merged(grid.occupied, many), _merged(grid.free, many)
    pixels = np.where(stands, _STANDS, np.where(floor, _FLOOR, 0))
    x_m, y_m = grid.low_m.tolist()
    return _picture(pixels, grid.cell_m * many, x_m, y_m)


def sketched(keys: Sequence[KeyScan]) -> Picture:
    """A map that is being made: what was seen, and the track. ValueError without a key scan."""
    if not keys:
        raise ValueError("nothing to draw yet")
    track = np.array([key.pose[:2] for key in keys])
    parts = [to_frame(_near(key.points_m)[::_SKETCH_EVERY], key.pose) for key in keys]
    points = np.concatenate([*parts, track])
    cell_m = _SKETCH_M * max(1, -(-int(np.ptp(points, axis=0).max() / _SKETCH_M) // _MOST_PIXELS))
    cells = np.floor(points / cell_m).astype(np.int64)
    low = cells.min(axis=0) - 2
    shape = cells.max(axis=0) + 3 - low
    pixels = np.zeros(tuple(shape.tolist()), dtype=np.uint8)
    i, j = (cells - low).T
    pixels[i, j] = _STANDS
    pixels[i[-len(track) :], j[-len(track) :]] = _TRACK
    x_m, y_m = (low * cell_m).tolist()
    return _picture(pixels, cell_m, x_m, y_m)


def _near(points_m: FloatArray) -> FloatArray:
    return points_m[np.hypot(points_m[:, 0], points_m[:, 1]) < _SKETCH_FARTHEST_M]


def _merged(cells: BoolArray, many: int) -> BoolArray:
    """Squares of `many` cells: whether any of them is set."""
    if many == 1:
        return cells
    nx, ny = (-(-side // many) for side in cells.shape)
    whole = np.zeros((nx * many, ny * many), dtype=bool)
    whole[: cells.shape[0], : cells.shape[1]] = cells
    return np.asarray(whole.reshape(nx, many, ny, many).any(axis=(1, 3)))


def _picture(pixels: NDArray[np.integer], cell_m: float, x_m: float, y_m: float) -> Picture:
    width, height = pixels.shape
    rows = np.zeros((height, width + 1), dtype=np.uint8)  # each begins with its filter: none
    rows[:, 1:] = pixels.T[::-1]
    head = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    parts = ((b"IHDR", head), (b"PLTE", _PALETTE), (b"tRNS", _OPACITY))
    png = b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in (*parts, (b"IDAT", zlib.compress(rows.tobytes())), (b"IEND", b""))
    )
    return Picture(png, cell_m, x_m, y_m, width, height)


def svg(home: HomeMap) -> str:
    """The whole picture, y upwards; the bar at its foot is one metre."""
    grid = home.grid
    nx, ny = grid.hits.shape
    scale = grid.cell_m * _PIXELS_PER_M
    width, height = nx * scale, ny * scale + 30.0
    points = (home.track[:, :2] - grid.low_m) / grid.cell_m
    track = " ".join(f"{x:.1f},{ny - y:.1f}" for x, y in points)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}">{_STYLE}'
        f"<title>{escape(home.name)}</title>"
        f'<g transform="scale({scale:g})" shape-rendering="crispEdges">'
        f'<path class="floor" d="{_runs(grid.free)}"/>'
        f'<path class="stands" d="{_runs(grid.occupied)}"/>'
        f'<polyline class="track" stroke-width="{0.04 / grid.cell_m:g}" points="{track}"/></g>'
        f'<path class="bar" d="M10 {height - 12:.0f}h{_PIXELS_PER_M:g}"/>'
        f'<text x="{20 + _PIXELS_PER_M:g}" y="{height - 8:.0f}">1 m &#183; {escape(home.name)}'
        "</text></svg>\n"
    )


def _runs(cells: BoolArray) -> str:
    """One rectangle for each run of cells along x."""
    ny = cells.shape[1]
    edges = np.diff(np.pad(cells.T, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    rows, begins = np.nonzero(edges == 1)
    ends = np.nonzero(edges == -1)[1]
    return "".join(
        f"M{begin} {ny - 1 - row}h{end - begin}v1h{begin - end}z"
        for row, begin, end in zip(rows, begins, ends, strict=True)
    )
