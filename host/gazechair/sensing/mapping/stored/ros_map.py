"""Maps in ROS's format, as nav2's map server reads and writes them: `map.yaml` and a PGM image.

ROS's format has no places: what people drew goes into `places.json` in the same folder.
"""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gazechair.base import json_text
from gazechair.base.arrays import BoolArray, FloatArray
from gazechair.base.output_file import write_output
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.stored.home_map import DAMAGE, MOST_CELLS, MOST_M2, HomeMap, MapError
from gazechair.sensing.mapping.stored.places import FARTHEST_M, Drawn, drawn_of

PLACES = "places.json"
_OCCUPIED, _FREE, _UNKNOWN = 0, 254, 205  # grey values of the map server's mode `trinary`
_OCCUPIED_THRESH, _FREE_THRESH = 0.65, 0.196
_MOST_SIDE = 8192  # cells; browsers show no longer pictures
_MOST_SIDE_M = 500.0
_SKIN_M = 0.05  # of a solid: deeper cells are inside it
_SURE = 10  # key scans that an imported cell stands for
_NUMBER = re.compile(rb"(?:\s|#[^\n]*\n)*([0-9]{1,9})(?=[\s#])")
_COMMENT = re.compile(r"(?:^|(?<=\s))#.*", re.MULTILINE)
_LIST = re.compile(r"\[[^\]]*\]")

Beside = Callable[[str], bytes]
"""Content of the named file in the folder of `map.yaml`. Raises OSError."""


class RosMapError(MapError):
    """Raised when ROS's files cannot be used: reason (a key of the texts), one plain line."""

    def __init__(self, reason: str, detail: str) -> None:
        super().__init__(detail)
        self.reason = reason


def write(home: HomeMap, folder: Path) -> Path:
    """Write `map.pgm`, `map.yaml` and `places.json` into the folder; the path of `map.yaml`.

    Raises UserError.
    """
    for name, content in files_of(home).items():
        write_output(folder / name, content)
    return folder / "map.yaml"


def files_of(home: HomeMap) -> dict[str, bytes]:
    """Contents by file name; `map.yaml`, which the others depend on, is last."""
    grid = home.grid
    grey = np.full(grid.hits.shape, _UNKNOWN, dtype=np.uint8)
    grey[grid.free], grey[grid.occupied] = _FREE, _OCCUPIED
    x_m, y_m = grid.low_m.tolist()
    yaml = (
        f"image: map.pgm\nmode: trinary\nresolution: {grid.cell_m}\n"
        f"origin: [{x_m:.4f}, {y_m:.4f}, 0]\nnegate: 0\n"
        f"occupied_thresh: {_OCCUPIED_THRESH}\nfree_thresh: {_FREE_THRESH}\n"
    )
    image = b"P5\n%d %d\n255\n" % grid.hits.shape[:2] + grey.T[::-1].tobytes()
    places = json.dumps({"name": home.name, **home.drawn.as_json()}, indent=1).encode()
    return {"map.pgm": image, PLACES: places, "map.yaml": yaml.encode()}


@dataclass(frozen=True)
class RosCells:
    """Content of a `map.yaml` and its image."""

    cell_m: float
    x_m: float
    y_m: float
    """Of the image's lower left corner."""
    yaw_rad: float
    """By which the image is turned about that corner."""
    occupied: BoolArray
    """(nx, ny), y upwards."""
    free: BoolArray


def read(path: Path, name: str) -> HomeMap:
    """The map of a `map.yaml`. Raises MapError."""
    return home_of(_content(path), _beside(path), str(path), name, MOST_CELLS)


def home_of(yaml: bytes, beside: Beside, where: str, name: str, most_cells: int) -> HomeMap:
    """The map `name` of a `map.yaml`; `where`: its name in messages. Raises RosMapError."""
    found = _cells(yaml, beside, where, plain=False)
    why = _unusable(found, most_cells)
    if why:
        raise RosMapError("map_file_cells", f"{where}: {why}")
    floor = found.free & ~found.occupied
    if not 0 < found.occupied.sum() <= floor.sum():
        raise RosMapError("map_file_cells", f"{where}: it has no walls, or less floor than walls")
    hits, passes = (one * np.uint16(_SURE) for one in (_surfaces(found), floor))
    grid = OccupancyGrid(found.cell_m, np.array((found.x_m, found.y_m)), hits, passes)
    home = HomeMap(name, grid, drawn=_drawn(beside, where))
    if not home.holds(home.drawn):
        raise RosMapError("map_file_places", f"{where}: {PLACES} names places outside the map")
    return home


def _surfaces(found: RosCells) -> BoolArray:
    """Occupied cells without those inside solids.

    No beam reaches those. In a drawn plan with solid walls they would outweigh the surfaces that
    localization uses.
    """
    reach = max(1, round(_SKIN_M / found.cell_m))
    nx, ny = found.occupied.shape
    around = np.pad(found.occupied, reach)
    inside = found.occupied.copy()
    for i, j in itertools.product(range(2 * reach + 1), repeat=2):
        inside &= around[i : i + nx, j : j + ny]
    return found.occupied & ~inside


def _unusable(found: RosCells, most_cells: int) -> str:
    """Reason key for refusing it; "": it is usable."""
    if found.yaw_rad:
        return f"a turned origin (yaw {found.yaw_rad:g}) is not supported"
    if not 0.005 <= found.cell_m <= 0.5:
        return f"cells of {found.cell_m:g} m are not supported (0.005..0.5)"
    if not all(abs(one) <= FARTHEST_M for one in (found.x_m, found.y_m)):
        return f"an origin farther away than {FARTHEST_M:g} m is not supported"
    width, height = found.occupied.shape
    if width * height > most_cells or max(width, height) > _MOST_SIDE:
        return f"{width} x {height} cells are too many ({most_cells}, {_MOST_SIDE} along a side)"
    wide_m, high_m = width * found.cell_m, height * found.cell_m
    if wide_m * high_m > MOST_M2 or max(wide_m, high_m) > _MOST_SIDE_M:
        return f"{wide_m:.0f} m x {high_m:.0f} m are too much ({MOST_M2:.0f} m2)"
    return ""


def _drawn(beside: Beside, where: str) -> Drawn:
    try:
        return drawn_of(json_text.parse(beside(PLACES)))
    except FileNotFoundError:
        return Drawn()
    except OSError as error:
        raise _unread(PLACES, error, "map_file_places") from None
    except DAMAGE as error:
        line = f"{where}: {PLACES} can't be used: {error}"
        raise RosMapError("map_file_places", line) from None


def cells(path: Path, plain: bool = False) -> RosCells:
    """Read a `map.yaml`; `plain`: its image may be written in digits (P2), too. Raises MapError."""
    return _cells(_content(path), _beside(path), str(path), plain)


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise _unread(str(path), error, "map_file_yaml") from None


def _beside(path: Path) -> Beside:
    def content(name: str) -> bytes:
        named = path.parent / name  # ROS's saver writes the path as it was typed
        return (named if named.exists() else path.parent / named.name).read_bytes()

    return content


def _unread(name: str, error: OSError, reason: str) -> RosMapError:
    return RosMapError(reason, f"{error.filename or name} can't be read: {error.strerror}")


def _cells(yaml: bytes, beside: Beside, where: str, plain: bool) -> RosCells:
    try:
        fields = _fields(yaml.decode("utf-8-sig"))
        image = fields["image"].strip("\"'")
        cell_m = float(fields["resolution"])
        x_m, y_m, yaw_rad = (float(one) for one in fields["origin"].strip("[] ").split(","))
        negate = fields.get("negate", "0").lower() in ("1", "true")
        mode = _mode(fields.get("mode", "trinary").strip("\"'").lower())
        occupied = float(fields.get("occupied_thresh", _OCCUPIED_THRESH))
        free = float(fields.get("free_thresh", _FREE_THRESH))
        if not free <= occupied:
            raise ValueError(f"free_thresh {free:g} is above occupied_thresh {occupied:g}")
    except KeyError as error:
        line = f"{where} has no field {error.args[0]!r}"
        raise RosMapError("map_file_yaml", line) from None
    except ValueError as error:
        raise RosMapError("map_file_yaml", f"{where} can't be used: {error}") from None
    try:
        grey = _pgm(beside(image), plain)
    except OSError as error:
        raise _unread(image, error, "map_file_image") from None
    except ValueError as error:
        raise RosMapError("map_file_image", f"{where} can't be used: {error}") from None
    if mode == "raw":
        percent = np.rint(255.0 * grey)
        taken = np.where(percent <= 100.0, percent / 100.0, np.nan)
    else:
        taken = grey if negate else 1.0 - grey
    if mode == "trinary" and not negate:  # below the saver's own `free_thresh` of 0.25
        taken[grey == _UNKNOWN / 255.0] = np.nan
    return RosCells(cell_m, x_m, y_m, yaw_rad, taken > occupied, taken < free)


def _mode(mode: str) -> str:
    """Checked. In `raw` grey values are percentages, above 100 unknown; else black is occupied.

    `trinary` and `scale` differ between the thresholds alone: those cells are unknown here.
    """
    if mode not in ("trinary", "scale", "raw"):
        raise ValueError(f"mode {mode!r} is not supported")
    return mode


def _fields(text: str) -> dict[str, str]:
    """Values by key; lines "- x" below a key are joined by commas, lines within [] by spaces."""
    found: dict[str, str] = {}
    last = ""
    text = _LIST.sub(lambda found: " ".join(found[0].split()), _COMMENT.sub("", text))
    for line in text.splitlines():
        plain = line.strip()
        if plain.startswith("- "):
            found[last] = ",".join(filter(None, (found.get(last), plain[2:].strip())))
            continue
        key, _, value = plain.partition(":")
        last = key.strip() or last
        if value.strip():
            found[last] = value.strip()
    return found


def _pgm(data: bytes, plain: bool) -> FloatArray:
    """Shares of white (nx, ny), y upwards."""
    kind, at, numbers = data[:2], 2, []
    if kind != b"P5" and not (kind == b"P2" and plain):
        raise ValueError("its image is no binary PGM (P5)")
    for _ in range(3):
        found = _NUMBER.match(data, at)
        if found is None:
            raise ValueError("its image is no binary PGM (P5)")
        numbers.append(int(found[1]))
        at = found.end()
    width, height, most = numbers
    if not 0 < most < 256:
        raise ValueError(f"images with {most} grey values are not supported")
    if kind == b"P5":
        values = np.frombuffer(data, dtype=np.uint8, offset=at + 1)
    else:
        values = np.array(data[at:].split(), dtype=np.float64)
    if not 0 < width * height <= len(values):
        raise ValueError("its image is cut short")
    return np.asarray(values[: width * height].reshape(height, width)[::-1].T / most)
