"""Maps in ROS's format, as nav2's map server reads and writes them: `map.yaml` and a PGM image.

ROS's format knows no places: what people drew goes into a file beside it, `places.json`.
"""

from __future__ import annotations

import io
import json
import re
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gazechair.base.state_folder import replace_file
from gazechair.sensing.mapping.home_map import HomeMap, MapError
from gazechair.sensing.mapping.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.places import Drawn, EditRefused, drawn_of

_OCCUPIED, _FREE, _UNKNOWN = 0, 254, 205  # grey values of the map server's mode `trinary`
_OCCUPIED_THRESH, _FREE_THRESH = 0.65, 0.196
_PLACES = "places.json"
_SURE = 10  # key scans that an imported cell stands for
_HEAD = re.compile(
    rb"(P[25])(?:\s+#[^\n]*)*\s+(\d+)(?:\s+#[^\n]*)*\s+(\d+)(?:\s+#[^\n]*)*\s+(\d+)\s"
)


def packed(home: HomeMap) -> bytes:
    """The three files that `write` writes, as a zip file."""
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as pack:
        for name, content in _files(home).items():
            pack.writestr(name, content)
    return whole.getvalue()


def write(home: HomeMap, folder: Path) -> Path:
    """Write `map.pgm`, `map.yaml` and `places.json` into the folder; the path of `map.yaml`.

    Raises MapError.
    """
    try:
        for name, content in _files(home).items():
            replace_file(folder / name, content)
    except OSError as error:
        raise MapError(f"{folder} can't be written: {error.strerror}") from None
    return folder / "map.yaml"


def _files(home: HomeMap) -> dict[str, bytes]:
    """By name; `map.yaml`, without which the others mean nothing, last."""
    grid = home.grid
    grey = np.full(grid.hits.shape, _UNKNOWN, dtype=np.uint8)
    grey[grid.free], grey[grid.occupied] = _FREE, _OCCUPIED
    x_m, y_m = grid.low_m.tolist()
    yaml = (
        f"image: map.pgm\nmode: trinary\nresolution: {grid.cell_m:g}\n"
        f"origin: [{x_m:.4f}, {y_m:.4f}, 0]\nnegate: 0\n"
        f"occupied_thresh: {_OCCUPIED_THRESH}\nfree_thresh: {_FREE_THRESH}\n"
    )
    image = b"P5\n%d %d\n255\n" % grid.hits.shape[:2] + grey.T[::-1].tobytes()
    places = json.dumps(home.drawn.as_json(), indent=1).encode()
    return {"map.pgm": image, _PLACES: places, "map.yaml": yaml.encode()}


@dataclass(frozen=True)
class RosCells:
    """What a `map.yaml` and its image say."""

    cell_m: float
    x_m: float
    y_m: float
    """Of the image's lower left corner."""
    yaw_rad: float
    """By which the image is turned about that corner."""
    occupied: NDArray[np.bool_]
    """(nx, ny), y upwards."""
    free: NDArray[np.bool_]


def read(path: Path, name: str) -> HomeMap:
    """The map of a `map.yaml`. Raises MapError."""
    found = cells(path)
    if found.yaw_rad:
        raise MapError(f"{path}: a turned origin (yaw {found.yaw_rad:g}) is not supported")
    if not 0.005 <= found.cell_m <= 0.5:
        raise MapError(f"{path}: cells of {found.cell_m:g} m are not supported (0.005..0.5)")
    hits = np.where(found.occupied, _SURE, 0).astype(np.uint16)
    passes = np.where(found.free, _SURE, 0).astype(np.uint16)
    low_m = np.array((found.x_m, found.y_m))
    grid = OccupancyGrid(found.cell_m, low_m, hits, passes)
    return HomeMap(name, grid, drawn=_drawn(path.parent / _PLACES))


def _drawn(path: Path) -> Drawn:
    if not path.exists():
        return Drawn()
    try:
        return drawn_of(json.loads(path.read_bytes()))
    except OSError as error:
        raise MapError(f"{path} can't be read: {error.strerror}") from None
    except (ValueError, KeyError, TypeError, EditRefused) as error:
        raise MapError(f"{path} can't be used: {error}") from None


def cells(path: Path, plain: bool = False) -> RosCells:
    """Read a `map.yaml`; `plain`: its image may be written in digits (P2), too. Raises MapError."""
    try:
        fields = _fields(path.read_text())
        image = path.parent / fields["image"].strip("\"'")
        grey = _pgm(image.read_bytes(), plain)
        cell_m = float(fields["resolution"])
        x_m, y_m, yaw_rad = (float(one) for one in fields["origin"].strip("[] ").split(","))
        negate = fields.get("negate", "0") in ("1", "true")
        occupied = float(fields.get("occupied_thresh", _OCCUPIED_THRESH))
        free = float(fields.get("free_thresh", _FREE_THRESH))
    except OSError as error:
        raise MapError(f"{error.filename} can't be read: {error.strerror}") from None
    except KeyError as error:
        raise MapError(f"{path} has no field {error.args[0]!r}") from None
    except (ValueError, UnicodeDecodeError) as error:
        raise MapError(f"{path} can't be used: {error}") from None
    taken = grey if negate else 1.0 - grey
    return RosCells(cell_m, x_m, y_m, yaw_rad, taken > occupied, taken < free)


def _fields(text: str) -> dict[str, str]:
    rows = (line.split("#")[0].partition(":") for line in text.splitlines())
    return {key.strip(): value.strip() for key, _, value in rows if value.strip()}


def _pgm(data: bytes, plain: bool) -> NDArray[np.float64]:
    """Shares of white (nx, ny), y upwards."""
    head = _HEAD.match(data)
    if head is None or (head[1] == b"P2" and not plain):
        raise ValueError("its image is no binary PGM (P5)")
    width, height, most = (int(one) for one in head.groups()[1:])
    if not 0 < most < 256:
        raise ValueError(f"images with {most} grey values are not supported")
    if head[1] == b"P5":
        values = np.frombuffer(data, dtype=np.uint8, offset=head.end())
    else:
        values = np.array(data[head.end() :].split(), dtype=np.float64)
    if not 0 < width * height <= len(values):
        raise ValueError("its image is cut short")
    return np.asarray(values[: width * height].reshape(height, width)[::-1].T / most)
