"""The stored maps: names and drawings, damaged files, two who edit at once, a kill in a save."""

from __future__ import annotations

import fcntl
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from fulldisk import full
from gazechair.cli import main
from gazechair.sensing.mapping.desk import MapDesk
from gazechair.sensing.mapping.stored import home_map
from gazechair.sensing.mapping.stored.places import EditRefused, name_of
from gazechair.sensing.mapping.stored.store import MapStore
from patience import wait_until
from storedmaps import BED, home, refused

SQUARE = [[0.1, 0.1], [1.0, 0.1], [1.0, 1.0]]


@pytest.fixture
def store(tmp_path: Path) -> MapStore:
    home().save(tmp_path / "a.map")
    home("other").save(tmp_path / "b.map")
    return MapStore(tmp_path)


def test_what_is_drawn_is_stored_and_read_back(store: MapStore, tmp_path: Path) -> None:
    store.draw("a", "place", BED)
    store.draw("a", "place", {**BED, "name": "Desk", "icon": "desk"})
    store.draw("a", "place", {**BED, "number": 1, "name": "My bed"})
    store.draw("a", "no_go", SQUARE)
    store.draw("a", "home", {"x": 1, "y": 1, "heading": 0})
    store.draw("a", "remove_place", 2)
    store.rename("a", "  my \t home ")
    found = home_map.load(tmp_path / "a.map")
    assert found.name == "my home"
    assert found.drawn.as_json() == {
        "places": [{**BED, "number": 1, "name": "My bed", "heading": 270.0}],
        "no_go": [{"number": 1, "corners": SQUARE}],
        "home": {"x": 1.0, "y": 1.0, "heading": 0.0},
        "last_place": 2,
        "last_area": 0,
    }
    before = home_map.load(tmp_path / "a.before")
    assert (before.name, before.drawn) == ("home", found.drawn)


@pytest.mark.parametrize(
    ("act", "value", "reason"),
    [
        ("place", {**BED, "x": 50.0}, "map_outside"),
        ("place", {**BED, "x": float("nan")}, "map_request"),
        ("place", {**BED, "y": True}, "map_request"),
        ("place", {**BED, "heading": "north"}, "map_request"),
        ("place", {**BED, "icon": "../../bed"}, "map_request"),
        ("place", {**BED, "name": ""}, "map_name"),
        ("place", {**BED, "number": 7}, "map_gone"),
        ("place", [1], "map_request"),
        ("remove_place", 1, "map_gone"),
        ("remove_place", "x", "map_gone"),
        ("no_go", SQUARE[:2], "map_area"),
        ("no_go", [[0.1, 0.1]] * 3, "map_area"),
        ("no_go", SQUARE * 20, "map_area"),
        ("no_go", [[0.1], 1, 2], "map_area"),
        ("no_go", [[0.1, 0.1], [1e9, 0.1], [1.0, 1.0]], "map_request"),
        ("remove_no_go", None, "map_gone"),
        ("home", {"x": -1.0, "y": 0.0, "heading": 0.0}, "map_outside"),
    ],
)
def test_a_drawing_that_makes_no_sense_is_refused(
    store: MapStore, tmp_path: Path, act: str, value: Any, reason: str
) -> None:
    data = (tmp_path / "a.map").read_bytes()
    assert refused(store.draw, "a", act, value) == reason
    assert (tmp_path / "a.map").read_bytes() == data


@pytest.mark.parametrize(
    "name", ["", "  ", "\U0001f3e0" * 10_000, "x" * 41, "a\x00b", "a\u202eb", 7, None, ["a"]]
)
def test_a_name_that_is_none(store: MapStore, name: Any) -> None:
    assert refused(store.rename, "a", name) == "map_name"


def test_names_may_be_what_they_like_and_name_no_file(store: MapStore, tmp_path: Path) -> None:
    for name in ("../../etc/passwd", "\U0001f468\u200d\U0001f469\u200d\U0001f467 thuis", "C:\\"):
        store.rename("a", name)
        assert store.get("a").map.name == name_of(name)  # type: ignore[union-attr]
    assert sorted(one.name for one in tmp_path.iterdir()) == ["a.before", "a.map", "b.map"]
    assert refused(store.rename, "a", "OTHER") == "map_name_taken"
    for id_ in ("../b", "c", ""):
        assert store.get(id_) is None
        assert refused(store.delete, id_) == "map_gone"


@pytest.mark.parametrize("spoilt", [b"", b"\xff" * 5000, b"half", b"PK\x03\x04"])
def test_a_file_that_cannot_be_used_is_told_and_the_one_before_serves(
    store: MapStore, tmp_path: Path, spoilt: bytes
) -> None:
    store.draw("a", "place", BED)
    path = tmp_path / "a.map"
    path.write_bytes(path.read_bytes()[:-40] if spoilt == b"half" else spoilt)
    stored = store.get("a")
    assert stored is not None
    assert stored.map is not None  # the one before
    assert stored.map.drawn.places == ()
    assert "a.map" in stored.problem
    assert store.get("b").problem == ""  # type: ignore[union-attr]
    # A change goes on from there, and what was damaged is kept aside.
    store.draw("a", "place", BED)
    assert store.get("a").problem == ""  # type: ignore[union-attr]
    assert (tmp_path / "a.damaged").exists()
    # Without one before it, the map cannot be used, and is told.
    (tmp_path / "a.before").unlink()
    path.write_bytes(spoilt)
    assert store.get("a").map is None  # type: ignore[union-attr]
    assert refused(store.draw, "a", "place", BED) == "map_damaged"
    desk = MapDesk(store, None)
    assert [row["problem"] for row in desk.as_json()["maps"]] == ["map_damaged", ""]
    assert refused(desk.details, "a") == "map_damaged"
    store.delete("a")
    assert [one.id for one in store.all()] == ["b"]
    assert [one.name for one in tmp_path.iterdir() if one.is_file()] == ["b.map"]


def test_a_map_is_deleted_with_all_that_was_damaged_of_it(store: MapStore, tmp_path: Path) -> None:
    for name in ("a.damaged", "a.damaged1", "b.damaged"):
        (tmp_path / name).write_bytes(b"a home")
    (tmp_path / "a.damaged2").mkdir()
    store.delete("a")
    left = sorted(one.name for one in tmp_path.iterdir())
    assert left == ["a.damaged2", "b.damaged", "b.map"]


def test_a_file_of_a_newer_version_is_left_alone(store: MapStore, tmp_path: Path) -> None:
    path = tmp_path / "a.map"
    newer = b"gazechair-map 3\n" + path.read_bytes()
    path.write_bytes(newer)
    assert refused(store.rename, "a", "mine") == "map_damaged"
    assert path.read_bytes() == newer


def test_a_file_of_the_first_version_is_read(tmp_path: Path) -> None:
    import json
    import zlib

    home().save(tmp_path / "a.map")
    _, line, rest = (tmp_path / "a.map").read_bytes().split(b"\n", 2)
    header = json.loads(line)
    del header["drawn"]
    data = b"gazechair-map 1\n" + json.dumps(header).encode() + b"\n" + rest[:-4]
    (tmp_path / "a.map").write_bytes(data + zlib.crc32(data).to_bytes(4, "little"))
    assert home_map.load(tmp_path / "a.map").name == "home"


def test_two_who_edit_at_once_lose_nothing(store: MapStore) -> None:
    wrong: list[Exception] = []

    def draw(who: str) -> None:
        try:
            for number in range(10):
                store.draw("a", "place", {**BED, "name": f"{who} {number}"})
        except Exception as error:
            wrong.append(error)

    threads = [threading.Thread(target=draw, args=(who,)) for who in ("anna", "bert")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
    places = store.get("a").map.drawn.places  # type: ignore[union-attr]
    assert len(places) == 20
    assert len({one.number for one in places}) == 20


SAVES = """
import sys
from pathlib import Path
from gazechair.sensing.mapping.stored.store import MapStore
store = MapStore(Path(sys.argv[1]))
number = 0
while True:
    number += 1
    store.rename("a", f"home {number}")
    print(number, flush=True)
"""


def test_killed_in_the_middle_of_a_save_the_map_is_whole(store: MapStore, tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    for _ in range(2):
        child = subprocess.Popen(
            [sys.executable, "-c", SAVES, str(tmp_path)], env=environment, stdout=subprocess.PIPE
        )
        assert child.stdout is not None
        for _ in range(5):
            assert child.stdout.readline()
        child.send_signal(signal.SIGKILL)
        child.wait()
        child.stdout.close()
        assert home_map.load(tmp_path / "a.map").name.startswith("home ")
        assert home_map.load(tmp_path / "a.before").name.startswith("home")
    (tmp_path / "c.map.new").write_bytes(b"half")
    MapDesk(store, None).tidy()
    assert not list(tmp_path.glob("*.new"))


def test_at_most_20_maps(store: MapStore, tmp_path: Path) -> None:
    for number in range(25):
        home(f"h{number}").save(tmp_path / f"m{number:02}.map")
    assert len(store.all()) == 20
    assert refused(store.check_name, "one more") == "map_full"
    wait_until(lambda: len(store.all()) == 20, "it stays so")


def test_a_full_disk_is_told(store: MapStore, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(home_map, "replace_file", full)
    assert refused(store.draw, "a", "place", BED) == "map_not_stored"
    assert store.get("a").map.drawn.places == ()  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "posted",
    [
        {},
        {"map": "a"},
        {"map": 7, "rename": "x"},
        {"map": "a", "rename": "x", "delete": True},
        {"map": "a", "delete": 1},
        {"map": "a", "make": True},
        {"fly": True},
        {"discard": "yes"},
    ],
)
def test_a_request_that_is_none(store: MapStore, posted: dict[str, Any]) -> None:
    assert refused(MapDesk(store, None).change, posted) == "map_request"


def test_without_a_lidar_maps_are_kept_and_none_is_made(store: MapStore) -> None:
    desk = MapDesk(store, None)
    assert refused(desk.change, {"make": True}) == "map_no_lidar"
    desk.change({"map": "a", "rename": "mine"})
    rows = desk.as_json()["maps"]
    assert [(row["map"], row["name"]) for row in rows] == [("a", "mine"), ("b", "other")]
    assert desk.where() is None
    details = desk.details("a")
    assert details["picture"] == {"cell_m": 0.05, "x": 0.0, "y": 0.0, "width": 40, "height": 40}
    assert desk.picture("a").startswith(b"\x89PNG")


def test_another_process_that_changes_maps_is_waited_for(store: MapStore, tmp_path: Path) -> None:
    code = (
        "import fcntl, os, sys, time\n"
        f"handle = os.open({str(tmp_path)!r}, os.O_RDONLY)\n"
        "fcntl.flock(handle, fcntl.LOCK_EX)\n"
        "print('locked', flush=True)\n"
        "sys.stdin.read()\n"
    )
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", code], **pipes) as other:  # type: ignore[call-overload]
        assert other.stdout.readline()
        thread = threading.Thread(target=store.rename, args=("a", "mine"))
        thread.start()
        thread.join(0.3)
        assert thread.is_alive()
        assert store.get("b") is not None  # reading never waits for it
        other.stdin.close()
        thread.join(20.0)
    assert store.get("a").map.name == "mine"  # type: ignore[union-attr]


def test_a_late_request_does_not_remove_what_another_person_drew(store: MapStore) -> None:
    for act, value, remove in (("place", BED, "remove_place"), ("no_go", SQUARE, "remove_no_go")):
        store.draw("a", act, value)
        store.draw("a", remove, 1)
        fresh = MapStore(store.folder)
        fresh.draw("a", act, value)
        assert refused(fresh.draw, "a", remove, 1) == "map_gone"
        fresh.draw("a", remove, 2)


def test_a_row_shows_that_something_was_drawn(store: MapStore) -> None:
    desk = MapDesk(store, None)
    rows = [desk.as_json()["maps"]]
    store.draw("a", "place", BED)
    rows.append(desk.as_json()["maps"])
    store.draw("a", "remove_place", 1)
    rows.append(desk.as_json()["maps"])
    assert rows[0][0] != rows[1][0] != rows[2][0] != rows[0][0]
    assert rows[0][1] == rows[1][1] == rows[2][1]


@pytest.mark.parametrize("id_", ["where", "growing"])
def test_a_map_whose_address_is_another_pages_is_refused(store: MapStore, id_: str) -> None:
    assert refused(store.add, home("c"), f"{id_}.map") == "map_name"


CHANGES = [
    lambda store: store.rename("a", "mine"),
    lambda store: store.draw("a", "place", BED),
    lambda store: store.delete("a"),
    lambda store: store.take_back("a"),
    lambda store: store.note("a", lambda path: None),
]


@pytest.mark.parametrize("act", [lambda store: store.add(home()), *CHANGES])
def test_a_folder_that_takes_nothing_is_told(tmp_path: Path, act: Any) -> None:
    (tmp_path / "file").write_bytes(b"")
    assert refused(act, MapStore(tmp_path / "file" / "maps")) == "map_not_stored"


def test_a_mistyped_path_makes_no_folders(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["map", "back", str(tmp_path / "mpas" / "deep" / "a.map")]) == 2
    assert "No such file" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("act", CHANGES)
def test_where_no_map_was_ever_stored_it_is_gone(tmp_path: Path, act: Any) -> None:
    assert refused(act, MapStore(tmp_path / "maps")) == "map_gone"
    assert list(tmp_path.iterdir()) == []


def test_two_who_rename_at_once_give_no_two_maps_one_name(store: MapStore, tmp_path: Path) -> None:
    wrong: list[str] = []

    def rename(own: MapStore, id_: str) -> None:
        try:
            own.rename(id_, "mine")
        except EditRefused as error:
            wrong.append(error.reason)

    threads = [
        threading.Thread(target=rename, args=args)
        for args in ((store, "a"), (MapStore(tmp_path), "b"))
    ]
    handle = os.open(tmp_path, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        for thread in threads:
            thread.start()
        threads[0].join(0.5)
        assert all(thread.is_alive() for thread in threads)
    finally:
        os.close(handle)
    for thread in threads:
        thread.join(20.0)
    assert wrong == ["map_name_taken"]
    assert len({one.map.name for one in store.all() if one.map is not None}) == 2
