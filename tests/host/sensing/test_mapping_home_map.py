"""Maps keep thin walls and forget people; their files are whole or refused; ROS reads them."""

from __future__ import annotations

import math
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gazechair.cli import main
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, occupancy_of
from gazechair.sensing.mapping.stored import home_map, ros_map
from gazechair.sensing.mapping.stored.home_map import HomeMap, MapError
from gazechair.sensing.mapping.stored.store import MapStore
from gazesim.rooms import Person, box
from homerig import flat, points, poses, scan

# What it is made of takes longer than the tests: one process makes it.
pytestmark = pytest.mark.xdist_group("mapping_home_map")

THIN = box(8.5, 1.0, 0.02, 1.6, 0.0, 2.5, "glazed")  # seen from both sides


def driven() -> list[KeyScan]:
    """A drive with poses known to 1 cm, and a person who walks to and fro."""
    chance = np.random.default_rng(5)
    person = Person(((1.0, 4.2), (9.0, 4.2)))
    room = flat(THIN, people=(person,))
    keys = []
    for number, pose in enumerate(poses()):
        for _ in range(10):
            person.x_m, person.y_m = person.walk(0.1)
        if math.hypot(person.x_m - pose[0], person.y_m - pose[1]) < 0.5:
            continue
        seen = points(*scan(room, pose, chance))
        known = pose + chance.normal(0.0, (0.01, 0.01, math.radians(0.2)))
        keys.append(KeyScan(known, seen, np.zeros_like(seen), float(pose[2]), number, 0.0))
    return keys


@pytest.fixture(scope="module")
def home() -> HomeMap:
    keys = driven()
    track = np.array([key.pose for key in keys])
    return HomeMap("flat & garden", occupancy_of(keys), "2026-11-22T20:00:00Z", track)


def near_surfaces_m(places_m: np.ndarray) -> np.ndarray:
    """Distance of each place from the nearest surface there is, people left out."""
    segments = flat(THIN).segments(0.25)
    begin, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    off = places_m[:, None] - begin
    share = np.clip((off * along).sum(2) / (along**2).sum(1), 0.0, 1.0)
    return np.asarray(np.hypot(*(off - share[..., None] * along).transpose(2, 0, 1)).min(axis=1))


def state(grid: OccupancyGrid, x_m: float, y_m: float) -> str:
    i, j = np.floor((np.array((x_m, y_m)) - grid.low_m) / grid.cell_m).astype(int)
    return "occupied" if grid.occupied[i, j] else "free" if grid.free[i, j] else "unknown"


def test_what_is_occupied_is_a_surface_and_nobody_who_walked_by(home: HomeMap) -> None:
    off_m = near_surfaces_m(home.grid.occupied_m())
    assert np.percentile(off_m, 95) < 0.03
    assert (off_m > 0.10).mean() < 0.002


def test_walls_that_were_seen_are_occupied_a_thin_one_too(home: HomeMap) -> None:
    stands = home.grid.occupied_m()
    for x in np.arange(5.6, 6.9, 0.05):
        assert np.hypot(*(stands - (x, 3.35)).T).min() < 0.05
    for y in np.arange(0.4, 1.7, 0.05):
        assert np.hypot(*(stands - (8.5, y)).T).min() < 0.05


def test_floor_is_free_and_the_inside_of_walls_is_unknown(home: HomeMap) -> None:
    for x in np.arange(1.2, 9.0, 0.3):
        assert state(home.grid, x, 4.0) == "free"
    assert state(home.grid, 0.7, 0.7) == "unknown"  # inside the sofa
    assert state(home.grid, *(home.grid.low_m + 0.03)) == "unknown"


def test_nothing_seen_makes_no_map() -> None:
    with pytest.raises(ValueError, match="no lidar points"):
        occupancy_of([])


def test_a_file_gives_back_the_map(home: HomeMap, tmp_path: Path) -> None:
    path = tmp_path / "home.gazemap"
    home.save(path)
    home.save(path)
    found = home_map.load(path)
    assert (found.name, found.made) == (home.name, home.made)
    assert (found.grid.hits == home.grid.hits).all()
    assert (found.grid.passes == home.grid.passes).all()
    assert found.grid.low_m == pytest.approx(home.grid.low_m)
    assert found.track == pytest.approx(home.track, abs=1e-4)
    assert [one.name for one in tmp_path.iterdir()] == ["home.gazemap"]


def test_a_damaged_file_is_refused_never_read_in_part(home: HomeMap, tmp_path: Path) -> None:
    path = tmp_path / "home.gazemap"
    home.save(path)
    data = path.read_bytes()
    chance = np.random.default_rng(6)
    cuts = [data[: int(at)] for at in chance.integers(20, len(data), 20)]
    flipped = []
    for at in chance.integers(20, len(data), 20):
        spoilt = bytearray(data)
        spoilt[at] ^= 0x20
        flipped.append(bytes(spoilt))
    for spoilt in (*cuts, *flipped):
        path.write_bytes(spoilt)
        with pytest.raises(MapError, match="is damaged"):
            home_map.load(path)
    for spoilt, why in ((b"gazechair-map 3\n" + data, "newer version"), (b"PK", "no map")):
        path.write_bytes(spoilt)
        with pytest.raises(MapError, match=why):
            home_map.load(path)


@pytest.mark.parametrize("header", [b"[" * 100_000, b"{}", b'{"shape": [1e400, 1]}', b"\xff"])
def test_a_file_of_another_hand_with_a_true_checksum_is_refused_too(
    header: bytes, tmp_path: Path
) -> None:
    data = b"gazechair-map 2\n" + header + b"\n" + zlib.compress(b"\0" * 4)
    path = tmp_path / "home.gazemap"
    path.write_bytes(data + zlib.crc32(data).to_bytes(4, "little"))
    with pytest.raises(MapError, match="is damaged"):
        home_map.load(path)


def test_ros_gets_the_same_map_and_gives_it_back(home: HomeMap, tmp_path: Path) -> None:
    place = {"name": "Bed", "icon": "bed", "x": 2.0, "y": 4.0, "heading": 90.0}
    drawn = home.drawn.with_place(place).with_area([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]])
    yaml = ros_map.write(replace(home, drawn=drawn), tmp_path)
    found = ros_map.read(yaml, "back")
    assert found.drawn == drawn
    assert (found.grid.occupied == home.grid.occupied).all()
    assert (found.grid.free == home.grid.free).all()
    assert found.grid.low_m == pytest.approx(home.grid.low_m, abs=1e-3)
    assert "resolution: 0.025\n" in yaml.read_text()
    (tmp_path / "places.json").write_text('{"places": 7}')
    with pytest.raises(MapError, match=r"places\.json can't be used"):
        ros_map.read(yaml, "back")
    (tmp_path / "places.json").unlink()
    assert ros_map.read(yaml, "back").drawn.places == ()


@pytest.mark.parametrize("image", ["/home/ros/maps/map#1.pgm", "maps/map#1.pgm"])
def test_the_image_may_be_named_where_it_was_saved(
    image: str, home: HomeMap, tmp_path: Path
) -> None:
    yaml = ros_map.write(home, tmp_path)
    (tmp_path / "map.pgm").rename(tmp_path / "map#1.pgm")
    yaml.write_text(yaml.read_text().replace("map.pgm", image))
    assert (ros_map.read(yaml, "back").grid.occupied == home.grid.occupied).all()


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("resolution: 0.05\norigin: [0, 0, 0]\n", "no field 'image'"),
        ("image: no.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n", r"no\.pgm can't be read"),
        ("image: bad.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n", "cut short"),
        ("image: map.pgm\nresolution: 0.05\norigin: [0, 0, 1.5]\n", "turned origin"),
        ("image: map.pgm\nresolution: 50\norigin: [0, 0, 0]\n", "cells of 50 m"),
        ("image: map.pgm\nresolution: fine\norigin: [0, 0, 0]\n", "can't be used"),
    ],
)
def test_a_ros_map_that_cannot_be_used_is_refused(text: str, why: str, tmp_path: Path) -> None:
    (tmp_path / "map.pgm").write_bytes(b"P5\n# by hand\n2 1\n255\n\x00\xfe")
    (tmp_path / "bad.pgm").write_bytes(b"P5\n20 20\n255\n\x00\xfe")
    (tmp_path / "map.yaml").write_text(text)
    with pytest.raises(MapError, match=why):
        ros_map.read(tmp_path / "map.yaml", "home")


def test_the_commands(home: HomeMap, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, again = tmp_path / "home.gazemap", tmp_path / "again.gazemap"
    home.save(path)
    assert main(["map", "show", str(path)]) == 0
    picture = (tmp_path / "home.svg").read_text()
    assert "<title>flat &amp; garden</title>" in picture
    assert picture.count('class="stands"') == 1
    assert main(["map", "export", str(path), str(tmp_path / "ros")]) == 0
    assert main(["map", "import", str(tmp_path / "ros" / "map.yaml"), str(again)]) == 0
    assert (home_map.load(again).grid.occupied == home.grid.occupied).all()
    imported = again.read_bytes()  # no map is replaced by another one
    assert main(["map", "import", str(tmp_path / "ros" / "map.yaml"), str(again)]) == 2
    assert again.read_bytes() == imported
    assert main(["map", "back", str(path)]) == 2  # no drive has changed it
    assert main(["map", "show", str(tmp_path / "none")]) == 2
    assert "can't be read" in capsys.readouterr().err


def test_what_a_command_draws_replaces_no_folder_and_can_be_read_by_others(
    home: HomeMap,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    home.save(Path("home.gazemap"))
    Path("pictures").mkdir()
    Path("pictures/mine.jpg").touch()
    for folder in ("pictures", ".", "/"):
        assert main(["map", "show", "home.gazemap", "--output", folder]) == 2
        assert f"{folder} can't be written: Is a directory" in capsys.readouterr().err
    assert Path("pictures/mine.jpg").exists()
    assert main(["map", "show", "home.gazemap"]) == 0
    assert main(["map", "export", "home.gazemap", "ros"]) == 0
    for made in (Path("home.svg"), Path("ros"), *Path("ros").iterdir()):
        assert made.stat().st_mode & 0o044 == 0o044, made
    assert main(["map", "export", "home.gazemap", "home.svg"]) == 2
    assert "can't be written" in capsys.readouterr().err


def test_a_map_imported_among_the_stored_ones_is_one_of_them(
    home: HomeMap, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "maps"
    folder.mkdir()
    ros_map.write(home, tmp_path)
    add = ["map", "import", str(tmp_path / "map.yaml")]
    assert main([*add, str(folder / "my home.map")]) == 2
    assert "1 to 40 letters" in capsys.readouterr().err
    assert main([*add, str(folder / "home.zip")]) == 2
    replace(other_home(), name="Ground").save(folder / "a.map")
    assert main([*add, str(folder / "ground.map")]) == 0
    store = MapStore(folder)
    assert {(one.id, one.map.name) for one in store.all() if one.map is not None} == {
        ("a", "Ground"),
        ("ground", "ground 2"),
    }
    assert main([*add, str(folder / "again.map")]) == 2
    assert "stored already: ground 2" in capsys.readouterr().err
    for number in range(MapStore.MOST):
        (folder / f"b{number}.map").write_bytes(b"")
    assert main([*add, str(folder / "more.map")]) == 2
    assert "at most 20 maps" in capsys.readouterr().err
    assert not (folder / "more.map").exists()


def other_home() -> HomeMap:
    cells = np.full((40, 40), 5, dtype=np.uint16)
    return HomeMap("other", OccupancyGrid(0.05, np.zeros(2), cells, cells))


def test_of_a_drawn_plan_with_solid_walls_the_surfaces_are_the_map(tmp_path: Path) -> None:
    grey = np.full((60, 50), 254, dtype=np.uint8)
    grey[10:20, 5:40] = 0  # a wall of 0.4 m, drawn solid
    grey[40:42, 5:40] = 0  # and one of 8 cm
    (tmp_path / "plan.pgm").write_bytes(b"P5\n60 50\n255\n" + grey.T[::-1].tobytes())
    lines = "image: plan.pgm", "resolution: 0.04", "origin: [0.0, 0.0, 0.0]", "negate: 0"
    yaml = tmp_path / "map.yaml"
    yaml.write_text("\n".join((*lines, "occupied_thresh: 0.65", "free_thresh: 0.196")) + "\n")
    grid = ros_map.read(yaml, "plan").grid
    assert grid.occupied[10, 5:40].all()
    assert grid.occupied[19, 5:40].all()
    assert not grid.occupied[11:19, 6:39].any()
    assert not grid.free[11:19, 6:39].any()
    assert grid.occupied[40:42, 5:40].all()
