"""The daemon: all parts together, with a fake board on a pseudo terminal."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from simple_websocket import Client

from gazechair.config import configuration, settings
from gazechair.daemon import Daemon
from gazechair.picture.camera import CameraService
from gazechair.sensing.lidar import LidarService
from gazechair.web.access import Access
from gazedemo.pairing import cookie
from gazelink import codes
from patience import wait_until

STATE_FILES = (
    *("alerts.jsonl", "camera_floor.json", "first_drive.json", "forward.json", "lock"),
    *("pair.sock", "paired.jsonl", "profiles.json", "speed_cap"),
)


def read_config(port: Path) -> settings.Config:
    state = port.parent / "state"
    return configuration.parse(
        f'[board]\nport = "{port}"\n[web]\nport = 0\nstate_folder = "{state}"\n'
    )


@pytest.fixture
def daemon(cable: Any) -> Iterator[Daemon]:
    daemon = Daemon(read_config(cable.path))
    daemon.start()
    yield daemon
    daemon.stop()


class Page:
    """A page that answers every state with a heartbeat."""

    def __init__(self, url: str, headers: dict[str, str]) -> None:
        self._socket = Client(url.replace("http", "ws") + "ws/control", headers=headers)
        self.state: dict[str, Any] = {}

    def say(self, **message: Any) -> None:
        self._socket.send(json.dumps(message))

    def saw(self, **expected: Any) -> bool:
        """Take one message; True if the newest state has all that is expected."""
        raw = self._socket.receive(timeout=1)
        if raw is not None:
            message = json.loads(raw)
            if message["k"] == "state":
                self.state = message
                self.say(k="hb", token=message["token"])
        return bool(self.state) and all(self.state[key] == expected[key] for key in expected)

    def close(self) -> None:
        self._socket.close()


@pytest.fixture
def page(daemon: Daemon, cable: Any) -> Iterator[Page]:
    page = Page(daemon.url, {"Cookie": cookie(cable.path.parent / "state")})
    yield page
    page.close()


def test_a_page_arms_drives_and_stops_through_all_parts(cable: Any, page: Page) -> None:
    wait_until(lambda: page.saw(board="ok", state="disarmed"), "the board is seen")
    page.say(k="arm", token=page.state["token"])
    wait_until(lambda: cable.received("order"), "the order to arm arrives")
    cable.state = {"status": codes.ARMED}
    wait_until(lambda: page.saw(state="armed", you=True), "the page sees it armed")
    token = page.state["token"]
    page.say(k="cmd", verb="left", mode="step", edge=1, token=token)
    wait_until(
        lambda: any(row["verb"] == codes.LEFT for row in cable.received("command")),
        "the command arrives",
    )
    page.say(k="stop")
    wait_until(lambda: cable.received("command")[-1]["verb"] == codes.STOP, "the stop arrives")


@pytest.mark.parametrize("content", [None, b"", b"\xff" * 10_000])
def test_a_driver_drives_whatever_is_in_the_place_of_the_files_of_the_state_folder(
    cable: Any, content: bytes | None
) -> None:
    """Content, or a folder: that is set aside, with what is in it."""
    state = cable.path.parent / "state"
    for name in STATE_FILES:
        file = state / name
        if content is None:
            file.mkdir(parents=True)
            (file / "something").write_text(name)
        else:
            state.mkdir(exist_ok=True)
            file.write_bytes(content)
    daemon = Daemon(read_config(cable.path))
    daemon.start()
    try:
        page = Page(daemon.url, {"Cookie": cookie(state)})
        wait_until(lambda: page.saw(board="ok", state="disarmed"), "the board is seen")
        page.say(k="arm", token=page.state["token"])
        wait_until(lambda: page.saw() and cable.received("order"), "the order to arm arrives")
        page.close()
    finally:
        daemon.stop()
    if content is None:
        left = {file.read_text() for file in state.rglob("something")}
        assert left == set(STATE_FILES)


def test_a_pulled_cable_is_told_to_the_page_and_found_again(cable: Any, page: Page) -> None:
    wait_until(lambda: page.saw(board="ok"), "the board is seen")
    cable.pull()
    wait_until(
        lambda: page.saw(board="lost", level="error", arm_reason="not_connected"),
        "the loss is seen",
    )
    cable.plug()
    wait_until(lambda: page.saw(board="ok"), "the board is seen again")


def test_without_a_lidar_the_page_is_told(page: Page) -> None:
    wait_until(lambda: page.saw(board="ok", lidar="lost", message="lidar_lost"), "it is told")


def test_stopping_disarms_the_board_and_leaves_no_thread(cable: Any) -> None:
    before = set(threading.enumerate())
    daemon = Daemon(read_config(cable.path))
    daemon.start()
    wait_until(lambda: daemon.link.state() is not None, "the board is found")
    daemon.stop()
    wait_until(
        lambda: any(row["action"] == codes.DISARM for row in cable.received("order")),
        "the order to disarm arrives",
    )
    left = [thread.name for thread in set(threading.enumerate()) - before]
    assert left == []
    daemon.stop()  # stopping twice is harmless


def test_what_an_earlier_daemon_was_storing_is_cleared_up_before_anybody_is_served(
    cable: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    half = cable.path.parent / "state" / "maps" / "a.map.new"
    half.parent.mkdir(parents=True)
    half.write_bytes(b"it ended while it stored this")
    daemon = Daemon(read_config(cable.path))
    there: list[bool] = []
    serve = Access.start

    def start(access: Access) -> None:
        there.append(half.exists())
        serve(access)

    monkeypatch.setattr(Access, "start", start)
    daemon.start()
    daemon.stop()
    assert there == [False]


def test_lidars_start_first_then_the_pages_and_what_driving_needs_not_after_their_first_scan(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[tuple[str, str]] = []
    daemon = Daemon(read_config(tmp_path / "none"))
    lidar = daemon.parts.part("lidar")
    serve, film = Access.start, CameraService.start

    def serves(access: Access) -> None:
        begun.append(("pages", lidar.state))
        serve(access)
        threading.Timer(0.1, lidar.set, ("ok",)).start()

    def films(camera: CameraService) -> None:
        begun.append(("camera", lidar.state))
        film(camera)

    monkeypatch.setattr(LidarService, "start", lambda _: begun.append(("lidar", lidar.state)))
    monkeypatch.setattr(Access, "start", serves)
    monkeypatch.setattr(CameraService, "start", films)
    daemon.start()
    daemon.stop()
    assert begun == [("lidar", "starting"), ("pages", "starting"), ("camera", "ok")]


def test_a_part_that_does_not_start_is_a_health_state(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_: LidarService) -> None:
        raise OSError("no processes left")

    monkeypatch.setattr(LidarService, "start", fail)
    daemon = Daemon(read_config(tmp_path / "none"))
    daemon.start()
    try:
        lidar = daemon.parts.part("lidar").now()
        assert (lidar.state, lidar.reason) == ("lost", "lidar_lost")
        assert "no processes left" in lidar.detail
    finally:
        daemon.stop()


@pytest.mark.parametrize(
    ("host", "more", "url"),
    [
        ("127.0.0.1", "", "http://127.0.0.1:"),
        ("127.0.0.1", 'name = "chair.local"', "http://chair.local:"),
        ("127.0.0.1", "tls = true", "https://127.0.0.1:"),
        ("::1", 'language = "en"', "http://[::1]:"),
    ],
)
def test_the_url_is_one_to_open(host: str, more: str, url: str, tmp_path: Path) -> None:
    text = f'[board]\nport = "{tmp_path}/none"\n[web]\nport = 0\nhost = "{host}"\n{more}\n'
    daemon = Daemon(configuration.parse(text + f'state_folder = "{tmp_path}/state"\n'))
    daemon.start()
    try:
        assert daemon.url.startswith(url)
        assert daemon.url.endswith("/?lang=en" if "en" in more else "/")
        assert f"open {daemon.url.split('?')[0]}pair and give the code" in daemon.invitation()
    finally:
        daemon.stop()


def test_a_driver_once_paired_is_not_invited_again(daemon: Daemon, cable: Any) -> None:
    assert "Pair a driver" in daemon.invitation()
    cookie(cable.path.parent / "state", "driver")
    assert daemon.invitation() == ""


@pytest.mark.parametrize("camera", ["off", "http"])
def test_a_spot_of_the_picture_needs_a_camera(tmp_path: Path, camera: str) -> None:
    text = f"""
[board]
port = "{tmp_path / "none"}"
[web]
port = 0
state_folder = "{tmp_path / "state"}"
[camera]
kind = "{camera}"
url = "http://127.0.0.1:9/none"
[lidar]
kind = "s2"
port = "{tmp_path / "none"}"
"""
    daemon = Daemon(configuration.parse(text))
    kinds = {service.kind for service in daemon._producers.services}
    assert kinds == {"place", "person"} | ({"look", "line"} if camera == "http" else set())
    assert daemon._producers.rows() == []
    assert not daemon._producers.choose("follow-line", (0.5, 0.5), 0.0)
    assert daemon._facts()["spot"] is None
