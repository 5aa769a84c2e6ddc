"""A home's map and its file: occupancy grid, track, what people drew on it; written atomically.

The file: a line `gazechair-map 2`, a line of JSON (name, made, cell_m, low_m, shape, track, drawn,
updated), then zlib of the hits and passes (u16, little-endian, row by row), then u32 CRC-32 of
everything before. Version 1 has no `drawn`, and older files no `updated`.
"""

from __future__ import annotations

import json
import struct
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gazechair.base import json_text
from gazechair.base.arrays import FloatArray
from gazechair.base.state_folder import replace_file
from gazechair.base.user_error import UserError
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.stored.places import Drawn, EditRefused, drawn_of

_MAGIC = b"gazechair-map 2\n"
_FIRST_MAGIC = b"gazechair-map 1\n"
_ANY_VERSION = b"gazechair-map "
_LARGEST = 64 << 20  # bytes
MOST_CELLS = 16 << 20
MOST_M2 = 10_000.0  # localization takes memory for each square metre
_CRC = struct.Struct("<I")
DAMAGE = (
    *(ValueError, KeyError, TypeError, OverflowError),
    *(EditRefused, zlib.error),
)


class MapError(UserError):
    """Raised when a map cannot be used; the text is one plain line."""


class NewerMapError(MapError):
    """Raised for a file that a newer gazechair has written."""


@dataclass(frozen=True)
class HomeMap:
    """A map with its name."""

    name: str
    grid: OccupancyGrid
    made: str = ""
    """When: ISO 8601, UTC."""
    track: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    """(N, 3): key poses of the drive that made it; none of an imported one."""
    drawn: Drawn = field(default_factory=Drawn)
    updated: str = ""
    """When drives last changed it, as `made`; "": never, or not known."""

    def holds(self, drawn: Drawn) -> bool:
        """Whether all of that lies on the map."""
        (low_x, low_y), (nx, ny) = self.grid.low_m.tolist(), self.grid.hits.shape
        wide_m, high_m = nx * self.grid.cell_m, ny * self.grid.cell_m
        spots = drawn.spots_m
        return all(0.0 <= x - low_x <= wide_m and 0.0 <= y - low_y <= high_m for x, y in spots)

    def save(self, path: Path) -> None:
        """Replace the file as a whole, on the disk when this returns. Raises MapError."""
        if self.grid.hits.size > MOST_CELLS:
            raise MapError(f"{path}: {self.grid.hits.size} cells are too many ({MOST_CELLS})")
        header = {
            "name": self.name,
            "made": self.made,
            "cell_m": self.grid.cell_m,
            "low_m": self.grid.low_m.tolist(),
            "shape": list(self.grid.hits.shape),
            "track": np.round(self.track, 4).tolist(),
            "drawn": self.drawn.as_json(),
            "updated": self.updated,
        }
        counts = np.stack((self.grid.hits, self.grid.passes)).astype("<u2").tobytes()
        data = _MAGIC + json.dumps(header).encode() + b"\n" + zlib.compress(counts)
        try:
            replace_file(path, data + _CRC.pack(zlib.crc32(data)))
        except OSError as error:
            raise MapError(f"{path} can't be written: {error.strerror}") from None


def load(path: Path) -> HomeMap:
    """Read a map's file. Raises MapError."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise MapError(f"{path} can't be read: {error.strerror}") from None
    if not data.startswith((_MAGIC, _FIRST_MAGIC)):
        if data.startswith(_ANY_VERSION):
            raise NewerMapError(f"{path} was written by a newer version of gazechair")
        raise MapError(f"{path} is no map of gazechair")
    data, crc = data[: -_CRC.size], data[-_CRC.size :]
    if len(data) > _LARGEST or crc != _CRC.pack(zlib.crc32(data)):
        raise MapError(f"{path} is damaged")
    try:
        return _parsed(data[len(_MAGIC) :])
    except DAMAGE:
        raise MapError(f"{path} is damaged") from None


def _parsed(data: bytes) -> HomeMap:
    line, _, body = data.partition(b"\n")
    header = json_text.parse(line)
    nx, ny = (int(one) for one in header["shape"])
    if min(nx, ny) <= 0 or nx * ny > MOST_CELLS:
        raise ValueError("shape")
    inflated = zlib.decompressobj().decompress(body, 4 * nx * ny)
    hits, passes = np.frombuffer(inflated, dtype="<u2").reshape(2, nx, ny).astype(np.uint16)
    cell_m, low_m = float(header["cell_m"]), np.array(header["low_m"], dtype=np.float64)
    track = np.array(header["track"], dtype=np.float64).reshape(-1, 3)
    if low_m.shape != (2,) or not 0.005 <= cell_m <= 0.5:
        raise ValueError("cells")
    if not (np.isfinite(low_m).all() and np.isfinite(track).all()):
        raise ValueError("numbers")
    grid = OccupancyGrid(cell_m, low_m, hits, passes)
    drawn = drawn_of(header["drawn"]) if "drawn" in header else Drawn()
    made, updated = str(header["made"]), str(header.get("updated", ""))
    return HomeMap(str(header["name"]), grid, made, track, drawn, updated)
