"""Maps over HTTP: caretakers change them, every page sees where the chair is, nobody else edits."""

from __future__ import annotations

import io
import json
import threading
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gazechair.sensing.mapping.stored import ros_map
from gazechair.sensing.mapping.stored.home_map import load
from gazechair.sensing.mapping.stored.packed_map import MOST_BYTES
from gazechair.sensing.mapping.stored.store import MapStore
from gazechair.web import handler
from patience import PATIENCE_S

P = (0.7, 0.25, 0.05)  # of floor, of what is not known, of walls


def test_a_caretaker_draws_and_everybody_sees(visitor: Any, maps: Any) -> None:
    caretaker, driver = visitor("caretaker"), visitor("driver")
    place = {"name": "Bed", "icon": "bed", "x": 1.0, "y": 1.0, "heading": 0}
    status, _, answer = caretaker.post("/maps", {"map": "a", "place": place})
    assert (status, [row["name"] for row in answer["maps"]]) == (200, ["home"])
    status, _, raw = driver.get("/maps/a")
    details = json.loads(raw)
    assert (status, details["places"][0]["name"]) == (200, "Bed")
    assert details["picture"]["width"] == 40
    status, headers, png = driver.get("/maps/a.png")
    assert (status, headers["Content-Type"], png[:4]) == (200, "image/png", b"\x89PNG")
    assert driver.get("/maps/a.png", **{"If-None-Match": headers["ETag"]})[0] == 304
    assert json.loads(driver.get("/maps/where")[2]) == {"where": None}
    assert caretaker.get("/maps/growing.png")[0] == 404
    assert json.loads(caretaker.get("/maps/growing")[2]) == {"picture": None}


@pytest.mark.parametrize(
    ("posted", "status", "reason"),
    [
        ({"map": "a", "rename": "\U0001f3e0" * 60}, 400, "map_name"),
        ({"map": "../../a", "rename": "x"}, 404, "map_gone"),
        ({"map": "a", "place": 1}, 400, "map_request"),
        ({"make": True}, 409, "map_no_lidar"),
        ({"map": "zz", "delete": True}, 404, "map_gone"),
    ],
)
def test_a_refusal_has_its_reason(
    visitor: Any, maps: Any, posted: dict[str, Any], status: int, reason: str
) -> None:
    answered, _, answer = visitor("caretaker").post("/maps", posted)
    assert (answered, answer["reason"]) == (status, reason)


def test_a_name_of_10000_signs_is_not_even_read(visitor: Any) -> None:
    posted = {"map": "a", "rename": "\U0001f3e0" * 10_000}
    assert visitor("caretaker").post("/maps", posted)[0] == 413


def test_a_caretaker_takes_a_map_home_as_files_that_make_the_same_map(
    visitor: Any, maps: Any, tmp_path: Path
) -> None:
    caretaker = visitor("caretaker")
    place = {"name": "Bed", "icon": "bed", "x": 1.0, "y": 1.0, "heading": 0}
    caretaker.post("/maps", {"map": "a", "place": place})
    status, headers, data = caretaker.get("/maps/a.zip")
    assert (status, headers["Content-Type"]) == (200, "application/zip")
    assert headers["Content-Disposition"] == 'attachment; filename="map-a.zip"'
    with zipfile.ZipFile(io.BytesIO(data)) as pack:
        pack.extractall(tmp_path / "files")
    found = ros_map.read(tmp_path / "files" / "map.yaml", "again")
    kept = load(tmp_path / "maps" / "a.map")
    assert (found.grid.occupied == kept.grid.occupied).all()
    assert found.drawn.as_json() == kept.drawn.as_json()
    for role in ("driver", "viewer"):
        assert visitor(role).get("/maps/a.zip")[0] == 403
    assert caretaker.get("/maps/b.zip")[0] == 404


def test_a_caretaker_brings_a_map_as_the_file_that_was_taken_home(
    visitor: Any, maps: Any, tmp_path: Path
) -> None:
    caretaker = visitor("caretaker")
    data = caretaker.get("/maps/a.zip")[2]
    status, answer = caretaker.send("/maps/import", data)
    assert (status, answer["reason"]) == (409, "map_known")
    stored = load(tmp_path / "maps" / "a.map")
    moved = replace(stored, grid=replace(stored.grid, low_m=stored.grid.low_m + 1.0))
    moved.save(tmp_path / "maps" / "a.map")
    status, answer = caretaker.send("/maps/import", data)
    assert (status, sorted(row["name"] for row in answer["maps"])) == (200, ["home", "home 2"])
    assert answer["most_file_bytes"] == MOST_BYTES
    added = load(tmp_path / "maps" / f"{answer['added']}.map")
    assert (added.grid.occupied == stored.grid.occupied).all()


def test_a_file_of_megabytes_is_taken_while_the_driver_goes_on(visitor: Any, maps: Any) -> None:
    grey = np.random.default_rng(1).choice(np.array((254, 205, 0), np.uint8), (1900, 1900), p=P)
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w") as pack:
        pack.writestr("map.yaml", "image: map.pgm\nresolution: 0.025\norigin: [0, 0, 0]\n")
        pack.writestr("map.pgm", b"P5\n1900 1900\n255\n" + grey.tobytes())
    page = visitor("driver").open()
    page.next_of("welcome")
    status, answer = visitor("caretaker").send("/maps/import", whole.getvalue())
    assert (status, len(answer["maps"])) == (200, 2)
    assert visitor("driver").get("/maps/where")[0] == 200


@pytest.mark.parametrize("role", ["driver", "viewer", None])
def test_nobody_elses_file_is_even_received(visitor: Any, maps: Any, role: str | None) -> None:
    other = visitor(role)
    status, answer = other.send("/maps/import", None, length=MOST_BYTES)  # and nothing follows
    assert (status, answer["reason"]) in ((403, "not_allowed"), (401, "not_paired"))
    status, _ = other.send("/maps/import", b"PK" * 100)
    assert status in (401, 403)
    assert len(maps.as_json()["maps"]) == 1


def test_a_file_comes_from_this_site_alone_is_a_zip_and_not_too_long(
    visitor: Any, maps: Any
) -> None:
    caretaker = visitor("caretaker")
    data = caretaker.get("/maps/a.zip")[2]
    for headers in (
        {"Origin": "https://evil.example"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Host": "evil.example"},
    ):
        assert caretaker.send("/maps/import", data + bytes(2000), **headers)[0] == 403
    for kind in ("multipart/form-data", "text/plain", "application/x-www-form-urlencoded"):
        assert caretaker.send("/maps/import", data, **{"Content-Type": kind})[0] == 400
    assert caretaker.send("/maps/import", None, length=MOST_BYTES + 1)[0] == 413
    for path in ("/maps", "/settings", "/pair", "/maps/import/", "//maps/import"):
        assert caretaker.send(path, None, length=2000)[0] == 413
    assert len(maps.as_json()["maps"]) == 1
    status, answer = caretaker.send("/maps/import", data[:-1])
    assert (status, answer["reason"]) == (400, "map_file_zip")


def test_a_file_that_stops_halfway_ends_and_so_does_that_of_a_revoked_device(
    visitor: Any, maps: Any, desk: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(handler, "_FILE_S", 0.2)
    caretaker = visitor("caretaker")
    assert caretaker.send("/maps/import", b"PK", length=5000)[0] == 408
    monkeypatch.setattr(handler, "_FILE_S", 600.0)
    receiving = threading.Event()
    receive = handler.Exchange._read_file

    def read_file(*requested: Any) -> bytes:
        receiving.set()
        return receive(*requested)

    monkeypatch.setattr(handler.Exchange, "_read_file", read_file)
    line = caretaker.line("/maps/import", b"PK", length=5000)
    assert receiving.wait(PATIENCE_S)
    desk.revoke(caretaker.id)
    assert line.recv(10) == b""
    assert len(maps.as_json()["maps"]) == 1


def test_an_update_by_drives_is_taken_back_once(visitor: Any, maps: Any, tmp_path: Path) -> None:
    caretaker = visitor("caretaker")
    store = MapStore(tmp_path / "maps")
    was = store.all()[0].map
    assert was is not None
    changed = replace(was.grid, hits=was.grid.hits + 1)
    assert store.update("a", was.grid, changed, "2026-11-23T10:00:00Z")
    row = json.loads(caretaker.get("/maps")[2])["maps"][0]
    assert (row["updates"], row["updated"]) == (1, "2026-11-23T10:00:00Z")
    for posted in ({"map": "a", "back": 1}, {"map": "b", "back": True}):
        assert caretaker.post("/maps", posted)[0] in (400, 404)
    assert visitor("driver").post("/maps", {"map": "a", "back": True})[0] == 403
    assert load(tmp_path / "maps" / "a.map").grid.same_as(changed)
    status, _, answer = caretaker.post("/maps", {"map": "a", "back": True})
    assert (status, answer["maps"][0]["updates"]) == (200, 0)
    assert load(tmp_path / "maps" / "a.map").grid.same_as(was.grid)
    status, _, answer = caretaker.post("/maps", {"map": "a", "back": True})
    assert (status, answer["reason"]) == (409, "map_no_update")


@pytest.mark.parametrize(
    "path", ["/maps/..%2fa", "/maps/%2e%2e", "/maps/b", "/maps/b.png", "/maps/..%2fa.zip"]
)
def test_a_map_that_is_not_there(visitor: Any, path: str) -> None:
    assert visitor("driver").get(path)[0] == 404


@pytest.mark.parametrize("role", ["driver", "viewer"])
def test_nobody_else_may_change_them(visitor: Any, maps: Any, role: str) -> None:
    other = visitor(role)
    assert other.get("/maps")[0] == 403
    assert other.get("/maps/growing")[0] == 403
    for posted in ({"map": "a", "rename": "x"}, {"make": True}, {"map": "a", "delete": True}):
        assert other.post("/maps", posted)[0] == 403
    assert maps.as_json()["maps"][0]["name"] == "home"


def test_who_is_not_paired_sees_nothing(visitor: Any) -> None:
    stranger = visitor(None)
    for path in ("/maps", "/maps/where", "/maps/a", "/maps/a.png", "/maps/a.zip"):
        assert stranger.get(path)[0] == 401
