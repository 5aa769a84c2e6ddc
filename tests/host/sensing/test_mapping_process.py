"""From a drive to a stored map and back: made, found again, distinguished, deleted in use."""

from __future__ import annotations

import json
import math
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from gazechair.base.health import Health
from gazechair.base.poses import between, compose
from gazechair.config.settings import LidarConfig
from gazechair.sensing.mapping import keeping
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.desk import MapDesk
from gazechair.sensing.mapping.making import Making
from gazechair.sensing.mapping.service import MappingService
from gazechair.sensing.mapping.stored.home_map import HomeMap, load
from gazechair.sensing.mapping.stored.places import EditRefused
from gazechair.sensing.mapping.stored.store import MapStore
from gazechair.sensing.odometry.estimate import Estimate
from maprig import START_S, Chair, made
from patience import wait_until

# What it is made of takes longer than the tests: one process makes it.
pytestmark = pytest.mark.xdist_group("mapping_process")

HOME, OTHER = 3, 1
MADE_S, FOUND_S = 26.0, 9.0


@pytest.fixture(scope="module")
def maker(tmp_path_factory: pytest.TempPathFactory) -> Chair:
    return made(tmp_path_factory.mktemp("maps"), HOME, "a", MADE_S)


@pytest.fixture(scope="module")
def found(maker: Chair) -> Chair:
    """The chair in the same home, where it was made, and started anew; there is another map."""
    made(maker.folder, OTHER, "b", 8.0)
    return Chair(maker.folder, HOME, HOME)


def test_a_drive_becomes_a_map_with_its_name(maker: Chair) -> None:
    assert maker.told.ended == [{"n": 2, "reason": "", "detail": "", "map": "a"}]
    assert maker.told.newest["making"] is None
    assert len(maker.told.pictures) >= 3
    place, png = maker.told.pictures[-1]
    assert png.startswith(b"\x89PNG")
    assert place["width"] > 50
    assert maker.told.newest["state"] == "known"  # who made it knows where it is
    maker.go(1.0)
    assert maker.told.newest["fix"]["map"] == "a"
    home = load(maker.folder / "a.map")
    assert home.name == "home a"
    assert home.grid.free.sum() * home.grid.cell_m**2 > 10.0
    assert len(home.track) > 10
    # Walls lie along the axes: at a slant they would fill all rows and columns alike.
    occupied = home.grid.occupied
    assert max(occupied.sum(axis=0).max(), occupied.sum(axis=1).max()) > 50


def test_it_notes_what_drives_find_and_knows_its_place_through_a_change(
    maker: Chair, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keeping, "_STORED_S", 1.0)
    maker.go(3.0)
    assert maker.told.newest["state"] == "known"
    store = MapStore(maker.folder)
    assert store.ledger_path("a").exists()
    grid = store.get("a").map.grid  # type: ignore[union-attr]
    hits = grid.hits.copy()
    hits[0, 0] += 1
    other = OccupancyGrid(grid.cell_m, grid.low_m, hits, grid.passes)
    assert store.update("a", grid, other, "2026-11-23T10:00:00Z")
    states = set()
    maker.go(3.0, lambda _: states.add(maker.told.newest["state"]))
    assert states == {"known"}
    assert maker.told.newest["fix"]["map"] == "a"


def test_the_chair_is_found_in_its_map_and_in_no_other(found: Chair) -> None:
    pairs = []

    def look(_: Estimate) -> None:
        newest = found.told.newest["fix"]
        if newest is not None:
            assert newest["map"] == "a"
            true = found.drive.truth(newest["time_s"] - START_S)
            pose = np.array((newest["x_m"], newest["y_m"], math.radians(newest["heading_deg"])))
            heading = math.radians(true.heading_deg)
            pairs.append((newest, pose, np.array((true.x_m, true.y_m, heading))))

    found.go(FOUND_S, look)
    assert pairs, found.told.newest
    # The map's frame in the home's, by the first pose; all others agree.
    _, first, true = pairs[0]
    frame = compose(true, between(first, np.zeros(3)))
    for newest, pose, true in pairs:
        off = between(true, compose(frame, pose))
        assert math.hypot(off[0], off[1]) < 0.05
        assert abs(off[2]) < math.radians(2.0)
        assert 0.005 < newest["sigma_m"] < 0.1
    times = sorted({newest["time_s"] for newest, *_ in pairs})
    assert len(times) > 5
    assert np.diff(times).max() < 0.2  # at least five poses a second


def test_two_maps_of_the_same_rooms_are_told_and_end_no_known_pose(maker: Chair) -> None:
    folder = maker.folder / "twins"
    folder.mkdir()
    for name in ("a", "c"):
        (folder / f"{name}.map").write_bytes((maker.folder / "a.map").read_bytes())
    chair = Chair(folder, HOME, HOME)
    chair.go(FOUND_S)
    assert chair.told.newest["fix"] is None
    assert chair.told.newest["twins"]
    kept = (folder / "a.map").read_bytes()
    (folder / "a.map").unlink()
    while chair.told.newest["fix"] is None:
        assert chair.now_s < START_S + 3.0 * FOUND_S
        chair.go(1.0)
    assert not chair.told.newest["twins"]
    # Lost where it was known, with its odometry unbroken: it knows which of them it is in.
    (folder / "a.map").write_bytes(kept)
    chair.go(1.5)
    chair.worker._atlas.id = ""
    chair.worker._atlas._forget_looks()
    while chair.told.newest["fix"] is None:
        assert chair.now_s < START_S + 4.0 * FOUND_S
        chair.go(1.0)
    assert chair.told.newest["fix"]["map"] == "c"


def test_the_health_names_the_twins_once_the_pose_is_long_unknown(tmp_path: Path) -> None:
    health = Health("map")
    service = MappingService((), tmp_path, health)
    told = {"state": "unknown", "making": None, "fix": None, "problem": "", "askew": False}
    for passed_s, twins, reason in (
        (0, True, "ok"),
        (11, True, "map_twins"),
        (0, False, "map_unknown"),
    ):
        if service._lost_s is not None:
            service._lost_s -= passed_s
        service._on_data(json.dumps({**told, "twins": twins}).encode())
        assert health.reason == reason


def test_drawn_on_made_anew_and_deleted_while_it_is_in_use(found: Chair) -> None:
    """Only the last of these changes makes the pose unknown."""
    while found.told.newest.get("fix") is None:
        assert found.now_s < START_S + 2.0 * FOUND_S
        found.go(1.0)
    MapStore(found.folder).draw("a", "home", {"x": 0.0, "y": 0.0, "heading": 0.0})
    found.go(2.0)
    assert found.told.newest["fix"]["map"] == "a"
    found.word("make")
    found.go(2.0)
    assert found.told.newest["state"] == "making"
    assert found.told.newest["fix"] is None
    keys = found.told.newest["making"]["keys"]
    assert keys >= 1
    found.track = 1  # carried
    found.go(1.0)
    assert found.told.newest["making"]["doubt"] == "broken"
    assert found.told.newest["making"]["keys"] <= keys + 1
    found.word("know")
    found.word("make")
    found.now_s += 3.0  # the lidar is pulled
    found.worker.tick()
    assert found.told.newest["making"]["doubt"] == "silent"
    found.word("know")
    assert found.told.newest["making"] is None
    (found.folder / "a.map").unlink()
    (found.folder / "b.map").unlink()
    found.go(2.0)
    assert found.told.newest["state"] == "no_maps"


def test_without_anything_seen_nothing_is_stored_and_it_says_so(tmp_path: Path) -> None:
    chair = Chair(tmp_path, HOME, HOME)
    chair.word("make")
    chair.word("save", path=str(tmp_path / "a.map"), name="a")
    chair.until(lambda: bool(chair.told.ended))
    assert chair.told.ended[0]["reason"] == "map_empty"
    # Its process was killed after it had stored: the next one finds it done; before: it is gone.
    again = Chair(tmp_path, HOME, HOME)
    again.word("save", path=str(tmp_path / "b.map"), name="a")
    assert again.told.ended[0]["reason"] == "map_making_lost"
    HomeMap("b", grid()).save(tmp_path / "b.map")
    again.word("save", path=str(tmp_path / "b.map"), name="b")
    assert again.told.ended[1] == {"n": 2, "reason": "", "detail": "", "map": "b"}


def test_a_map_is_stored_by_the_rules_of_the_store(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    chair = Chair(tmp_path, HOME, HOME)
    monkeypatch.setattr(Making, "finished", lambda _, name: HomeMap(name, grid()))
    other = np.full((50, 40), 5, dtype=np.uint16)
    for number in range(MapStore.MOST):  # somebody imports while it is finished
        HomeMap("a", OccupancyGrid(0.05, np.zeros(2), other, other)).save(
            tmp_path / f"b{number}.map"
        )
    chair.word("make")
    chair.word("save", path=str(tmp_path / "a.map"), name="a")
    chair.until(lambda: bool(chair.told.ended))
    assert chair.told.ended[0]["reason"] == "map_full"
    assert not (tmp_path / "a.map").exists()
    for number in range(1, MapStore.MOST):
        (tmp_path / f"b{number}.map").unlink()
    chair.word("save", path=str(tmp_path / "a.map"), name="a")  # what was collected is still there
    chair.until(lambda: len(chair.told.ended) > 1)
    assert chair.told.ended[1]["reason"] == ""
    assert load(tmp_path / "a.map").name == "a 2"


def grid() -> OccupancyGrid:
    cells = np.full((40, 40), 5, dtype=np.uint16)
    return OccupancyGrid(0.05, np.zeros(2), cells, cells)


@pytest.fixture
def service(tmp_path: Path) -> Iterator[MappingService]:
    lidar = LidarConfig(kind="s2", port="/nowhere", x_m=0.5)
    made = MappingService((lidar,), tmp_path, Health("map"))
    made.start()
    yield made
    made.stop()


@pytest.mark.parametrize("stored", [True, False])
def test_with_other_lidars_while_a_map_is_stored_it_says_what_became_of_it(
    service: MappingService, stored: bool
) -> None:
    wait_until(lambda: service.state == "no_maps", "its process")
    service.make()
    wait_until(lambda: service.state == "making", "it makes a map")
    assert service.pid is not None
    os.kill(service.pid, signal.SIGSTOP)  # it never ends the storing
    path = service._folder / "a.map"
    assert service.save(path, "home")
    if stored:
        HomeMap("home", grid()).save(path)
    service.renew(service._lidars)
    wait_until(lambda: service.ended is not None, "how it ended")
    assert service.ended is not None
    assert service.ended.reason == ("" if stored else "map_making_lost")
    assert service.wants == "know"
    assert service.make()


def test_killed_while_a_map_is_made_it_says_so_and_goes_on(service: MappingService) -> None:
    desk = MapDesk(MapStore(service._folder), service)
    wait_until(lambda: service.state == "no_maps", "its process")
    assert service._health.state == "ok"
    assert desk.as_json()["wants"] == "know"
    desk.change({"make": True})
    wait_until(lambda: desk.as_json()["making"] is not None, "it makes a map")
    with pytest.raises(EditRefused, match="something else"):
        desk.change({"make": True})
    assert service.pid is not None
    os.kill(service.pid, signal.SIGKILL)
    wait_until(lambda: service.ended is not None, "that it is gone")
    assert desk.as_json()["ended"]["reason"] == "map_making_lost"
    assert desk.as_json()["making"] is None
    wait_until(lambda: service._health.state == "ok" and service.state == "no_maps", "it is back")
    desk.change({"make": True})
    wait_until(lambda: service.state == "making", "it makes another")
    desk.change({"save": "home"})
    wait_until(lambda: service.ended is not None, "an empty map")
    assert desk.as_json()["ended"]["reason"] == "map_empty"
    assert desk.as_json()["wants"] == "make"  # drive on, and try again
    desk.change({"discard": True})
    assert desk.as_json()["wants"] == "know"
