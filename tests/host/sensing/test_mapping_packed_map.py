"""A map as one zip file: an export is imported unchanged; any other file is a map or refused."""

from __future__ import annotations

import contextlib
import io
import json
import struct
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.desk import MapDesk
from gazechair.sensing.mapping.stored import packed_map
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.packed_map import pack, unpack
from gazechair.sensing.mapping.stored.places import Drawn, EditRefused
from gazechair.sensing.mapping.stored.ros_map import RosMapError, files_of
from gazechair.sensing.mapping.stored.store import MapStore

YAML = b"image: map.pgm\nresolution: 0.05\norigin: [-1, -2, 0]\n"
GREY = np.full((8, 10), 254, dtype=np.uint8)
GREY[0] = 0
IMAGE = b"P5\n10 8\n255\n" + GREY.tobytes()
BED = {"number": 1, "name": "Bed", "icon": "bed", "x": -0.9, "y": -1.8, "heading": 0}
EMPTY: dict[str, Any] = {"places": [], "no_go": [], "home": None}


def zipped(files: dict[str, bytes], how: int = zipfile.ZIP_DEFLATED) -> bytes:
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", how) as pack:
        for name, content in files.items():
            pack.writestr(name, content)
    return whole.getvalue()


def files(**others: bytes) -> bytes:
    """A good map, with these in place of its own."""
    return zipped({"map.yaml": YAML, "map.pgm": IMAGE} | others)


def yaml(line: bytes) -> bytes:
    """A good map, but for this line."""
    key = line.split(b":")[0]
    rest = [one for one in YAML.splitlines() if not one.startswith(key)]
    return files(**{"map.yaml": b"\n".join([*rest, line])})


def places(**fields: Any) -> bytes:
    return files(**{"places.json": json.dumps(EMPTY | fields).encode()})


def home(shorter: int = 0) -> HomeMap:
    hits = np.zeros((60 - shorter, 30), dtype=np.uint16)
    hits[0] = 5
    grid = OccupancyGrid(0.025, np.array((-1.5, 2.25)), hits, (7 * (hits == 0)).astype(np.uint16))
    drawn = Drawn().with_place({**BED, "number": None, "x": -1.0, "y": 2.5})
    return HomeMap("Ons huis 🏠", grid, drawn=drawn)


def test_what_is_packed_comes_back_with_its_name_and_places() -> None:
    found, was = unpack(pack(home())), home()
    assert (found.name, found.drawn) == (was.name, was.drawn)
    assert (found.grid.occupied == was.grid.occupied).all()
    assert (found.grid.free == was.grid.free).all()
    assert found.grid.lies_as(was.grid)


def test_a_map_of_another_program_is_named_by_its_yaml() -> None:
    other = {"office/floor 2.yaml": YAML, "office/map.pgm": IMAGE, "__MACOSX/._map.pgm": b"x"}
    found = unpack(zipped(other, zipfile.ZIP_STORED))
    assert found.name == "floor 2"
    assert found.grid.low_m.tolist() == [-1.0, -2.0]
    assert found.grid.occupied.T[::-1].tolist() == (GREY == 0).tolist()
    assert unpack(places(name="\u202e" * 9)).name == "map"  # no name; map.yaml


NEGATIVE = b"P5\n10 8\n255\n" + (254 - GREY).tobytes()
PERCENT = b"P5\n10 8\n255\n" + np.where(GREY, 0, 100).astype(np.uint8).tobytes()
VARIANTS = {
    "scale": yaml(b"mode: scale"),
    "raw": files(**{"map.yaml": YAML + b"mode: Raw\n", "map.pgm": PERCENT}),
    "negate": files(**{"map.yaml": YAML + b"negate: True\n", "map.pgm": NEGATIVE}),
    "list over lines": yaml(b"origin: [  # the corner\n  -1,\n  -2,  # and the yaw\n  0.0\n]"),
    "where it was saved": yaml(b"image: /home/ros/maps/map.pgm"),
    "block list": yaml(b"origin:\n- -1\n  # y\n- -2  # and the yaw\n- 0.0"),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_other_ways_to_write_the_same_map(name: str) -> None:
    grid = unpack(VARIANTS[name]).grid
    assert grid.low_m.tolist() == [-1.0, -2.0]
    assert grid.occupied.T[::-1].tolist() == (GREY == 0).tolist()
    assert grid.free.T[::-1].tolist() == (GREY == 254).tolist()


def test_percentages_above_100_are_unknown() -> None:
    some = np.where(GREY, 0, 100).astype(np.uint8)
    some[-1] = 101, 101, 101, 205, 205, 254, 255, 255, 50, 0
    image = b"P5\n10 8\n255\n" + some.tobytes()
    grid = unpack(files(**{"map.yaml": YAML + b"mode: raw\n", "map.pgm": image})).grid
    last = grid.free.T[0] | grid.occupied.T[0]
    assert last.tolist() == [False] * 9 + [True]


def bomb() -> bytes:
    return files(**{"map.pgm": b"P5\n10 8\n255\n" + bytes(40_000_000)})


def liar() -> bytes:
    """A file whose image is larger than declared."""
    data = bytearray(bomb())
    long = struct.pack("<L", len(IMAGE) - len(GREY.tobytes()) + 40_000_000)
    assert data.count(long) == 2
    return bytes(data.replace(long, struct.pack("<L", 100)))


def pile() -> bytes:
    """Each of its files is small enough."""
    return files(**{f"{number}": bytes(4 << 20) for number in range(40)})


def crowd() -> bytes:
    return zipped({f"{number}": b"" for number in range(10_000)})


def twice() -> bytes:
    return zipped({"a/map.yaml": YAML, "b/map.yaml": YAML, "map.pgm": IMAGE})


def locked() -> bytes:
    """Its files are marked as encrypted."""
    data = bytearray(files())
    for sign, at in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        start = data.find(sign)
        data[start + at] |= 1
    return bytes(data)


DEEP = b"[" * 100_000
HUGE = b"P5\n65535 65535\n255\n" + bytes(100)
WIDE = b"P5\n100000 1\n255\n" + bytes([0] + [254] * 99_999)
WALLS = np.full((700, 700), 254, dtype=np.uint8)
WALLS[0] = 0
LARGE = b"P5\n700 700\n255\n" + WALLS.tobytes()
COMMENTS = b"P5" + b" #" * 40 + b"\n255\n"
# Large ones are made by their own test: every process of the tests reads this table.
HOSTILE: dict[str, tuple[bytes | Callable[[], bytes], str]] = {
    "nothing": (b"", "map_file_zip"),
    "no zip": (b"x" * 1000, "map_file_zip"),
    "a picture": (b"\x89PNG\r\n\x1a\n" + bytes(500), "map_file_zip"),
    "half": (files()[:200], "map_file_zip"),
    "too long": (bytes(packed_map.MOST_BYTES + 1), "map_file_large"),
    "bomb": (bomb, "map_file_large"),
    "liar": (liar, "map_file_zip"),
    "pile": (pile, "map_file_large"),
    "crowd": (crowd, "map_file_zip"),
    "twice": (twice(), "map_file_zip"),
    "locked": (locked(), "map_file_zip"),
    "lzma": (zipped({"map.yaml": YAML}, zipfile.ZIP_LZMA), "map_file_zip"),
    "outside": (files(**{"../../map.json": b""}), "map_file_zip"),
    "from the root": (files(**{"/etc/x.yaml": b""}), "map_file_zip"),
    "backslash": (files(**{"..\\x.yaml": b""}), "map_file_zip"),
    "no yaml": (zipped({"map.pgm": IMAGE}), "map_file_yaml"),
    "two yamls": (files(**{"other.yml": YAML}), "map_file_yaml"),
    "long yaml": (files(**{"map.yaml": YAML + b"#" * 300_000}), "map_file_large"),
    "no text": (files(**{"map.yaml": b"\xff\xfe\x00"}), "map_file_yaml"),
    "no field": (files(**{"map.yaml": b"image: map.pgm"}), "map_file_yaml"),
    "no number": (yaml(b"resolution: 1e"), "map_file_yaml"),
    "unknown mode": (yaml(b"mode: other"), "map_file_yaml"),
    "two in a list": (yaml(b"origin:\n- 0\n- 0"), "map_file_yaml"),
    "list of nothing": (files(**{"map.yaml": b"- 1\n- 2\n" + YAML[:14]}), "map_file_yaml"),
    "image elsewhere": (yaml(b"image: /etc/passwd"), "map_file_image"),
    "image above": (yaml(b"image: ../other.pgm"), "map_file_image"),
    "image itself": (yaml(b"image: map.yaml"), "map_file_image"),
    "image nul": (yaml(b"image: a\0b"), "map_file_image"),
    "png": (files(**{"map.pgm": b"\x89PNG"}), "map_file_image"),
    "short image": (files(**{"map.pgm": HUGE}), "map_file_image"),
    "comments": (files(**{"map.pgm": COMMENTS}), "map_file_image"),
    "digits": (files(**{"map.pgm": b"P5 " + b"9" * 50_000 + b" 1 255\n"}), "map_file_image"),
    "spaces": (files(**{"map.pgm": b"P5" + b" " * 500_000}), "map_file_image"),
    "wide image": (files(**{"map.pgm": WIDE}), "map_file_cells"),
    "a village": (
        zipped({"map.yaml": YAML.replace(b"0.05", b"0.5"), "map.pgm": LARGE}),
        "map_file_cells",
    ),
    "nan cells": (yaml(b"resolution: nan"), "map_file_cells"),
    "no cells": (yaml(b"resolution: 0"), "map_file_cells"),
    "nan origin": (yaml(b"origin: [0, nan, 0]"), "map_file_cells"),
    "inf origin": (yaml(b"origin: [-inf, 0, 0]"), "map_file_cells"),
    "far origin": (yaml(b"origin: [500000, 0, 0]"), "map_file_cells"),
    "turned": (yaml(b"origin: [0, 0, 0.5]"), "map_file_cells"),
    "nan turn": (yaml(b"origin: [0, 0, nan]"), "map_file_cells"),
    "no walls": (yaml(b"occupied_thresh: 2"), "map_file_cells"),
    "a photo": (files(**{"map.pgm": IMAGE[:-48] + bytes(48)}), "map_file_cells"),
    "all walls": (yaml(b"occupied_thresh: -1\nfree_thresh: -1"), "map_file_cells"),
    "deep places": (files(**{"places.json": DEEP}), "map_file_places"),
    "list": (files(**{"places.json": b"[1]"}), "map_file_places"),
    "place outside": (places(places=[{**BED, "x": 40.0}]), "map_file_places"),
    "nan place": (places(places=[{**BED, "x": float("nan")}]), "map_file_places"),
    "inf number": (places(places=[{**BED, "number": float("inf")}]), "map_file_places"),
    "same number": (places(places=[BED, {**BED, "name": "b"}]), "map_file_places"),
    "many places": (
        places(places=[{**BED, "number": n, "name": f"{n}"} for n in range(1, 60)]),
        "map_file_places",
    ),
    "home a text": (places(home="here"), "map_file_places"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_what_is_no_map_is_refused_with_its_reason_and_nothing_is_stored(
    name: str, tmp_path: Path
) -> None:
    content, reason = HOSTILE[name]
    data = content() if callable(content) else content
    home().save(tmp_path / "a.map")
    before = (tmp_path / "a.map").read_bytes()
    with pytest.raises(EditRefused) as refused:
        MapDesk(MapStore(tmp_path), None).add(data)
    assert refused.value.reason == reason, str(refused.value)
    assert "\n" not in str(refused.value)
    assert [one.name for one in tmp_path.iterdir()] == ["a.map"]
    assert (tmp_path / "a.map").read_bytes() == before


@settings(deadline=None, max_examples=300)
@given(st.data())
def test_any_bytes_are_a_map_or_refused(data: st.DataObject) -> None:
    good = bytearray(pack(home()))
    for _ in range(data.draw(st.integers(0, 6))):
        good[data.draw(st.integers(0, len(good) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(good)))
    raw = bytes(good[:cut] if data.draw(st.booleans()) else good)
    with contextlib.suppress(RosMapError):
        assert np.isfinite(unpack(raw).grid.low_m).all()


def test_a_map_is_added_under_a_name_of_its_own_and_at_most_20(tmp_path: Path) -> None:
    store = MapStore(tmp_path / "maps")
    desk = MapDesk(store, None)
    for number in range(MapStore.MOST):
        assert store.get(desk.add(pack(home(number)))) is not None
    names = sorted(one.map.name for one in store.all() if one.map is not None)
    assert len(set(names)) == MapStore.MOST
    assert {"Ons huis 🏠", "Ons huis 🏠 2", "Ons huis 🏠 20"} <= set(names)
    with pytest.raises(EditRefused) as refused:
        desk.add(pack(home(MapStore.MOST)))
    assert refused.value.reason == "map_full"


@pytest.mark.parametrize("cell_m", [0.05, 0.05000000074505806])  # as written by C++ as a float
def test_a_stored_map_is_not_added_again(tmp_path: Path, cell_m: float) -> None:
    """Localization would find the chair in neither."""
    mine = home()
    mine = replace(mine, grid=replace(mine.grid, cell_m=cell_m))
    mine.save(tmp_path / "a.map")
    exact = files_of(mine)
    older = exact["map.yaml"].replace(repr(cell_m).encode(), b"0.05")  # of an earlier version
    for yaml in (exact["map.yaml"], older):
        with pytest.raises(EditRefused, match="Ons huis") as refused:
            MapDesk(MapStore(tmp_path), None).add(zipped({**exact, "map.yaml": yaml}))
        assert refused.value.reason == "map_known"
    assert [one.name for one in tmp_path.iterdir()] == ["a.map"]


def test_the_grey_of_the_unknown_is_no_floor_whatever_the_threshold() -> None:
    grey = GREY.copy()
    grey[4:] = 205  # 0.196, below the `free_thresh` that nav2 writes
    image = b"P5\n10 8\n255\n" + grey.tobytes()
    yaml = YAML + b"mode: trinary\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"
    grid = unpack(files(**{"map.yaml": yaml, "map.pgm": image})).grid
    assert grid.free.sum() == (grey == 254).sum()
    scaled = unpack(files(**{"map.yaml": yaml.replace(b"trinary", b"scale"), "map.pgm": image}))
    assert scaled.grid.free.sum() == (grey != 0).sum()


def test_thresholds_that_overlap_are_refused() -> None:
    overlap = YAML + b"occupied_thresh: 0.2\nfree_thresh: 0.3\n"
    with pytest.raises(RosMapError, match="is above occupied_thresh"):
        unpack(files(**{"map.yaml": overlap}))
