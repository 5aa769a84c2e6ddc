"""The camera service end to end: its child process reading MJPEG over HTTP from a small server."""

from __future__ import annotations

import os
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from gazechair.base.health import Health
from gazechair.config.settings import CameraConfig
from gazechair.picture.camera import CameraError, CameraService, http_stream

LONG_S = 60.0


class Source(ThreadingHTTPServer):
    """Sends numbered pictures at 50 Hz, stamped with the time they were made."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.kind = "multipart/x-mixed-replace; boundary=frame"
        self.silent = threading.Event()
        self.garbage = False
        self.stopping = threading.Event()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}/stream"


class Handler(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        source = self.server
        assert isinstance(source, Source)
        if self.path != "/stream":
            self.send_error(404)
            return
        self.send_response(200)
        self.send_header("Content-Type", source.kind)
        self.end_headers()
        number = 0
        while not source.stopping.wait(0.02):
            if source.silent.is_set():
                continue
            number += 1
            body = b"\xff\xd8%d\xff\xd9" % number if not source.garbage else b"no picture"
            head = b"--frame\r\nContent-Length: %d\r\nX-Timestamp: %.6f\r\n\r\n"
            try:
                self.wfile.write(head % (len(body), time.monotonic()) + body + b"\r\n")
            except OSError:
                return

    def log_message(self, *args: object) -> None:
        pass


@pytest.fixture
def source() -> Iterator[Source]:
    source = Source()
    thread = threading.Thread(target=source.serve_forever, args=(0.05,), daemon=True)
    thread.start()
    yield source
    source.stopping.set()
    source.shutdown()
    source.server_close()


class Watched:
    def __init__(self, url: str) -> None:
        self.health = Health("camera")
        self.service = CameraService(CameraConfig(kind="http", url=url), self.health)
        self.service.start()

    def wait(self, condition: Callable[[], bool]) -> None:
        deadline_s = time.monotonic() + LONG_S
        while not condition():
            assert time.monotonic() < deadline_s, self.health.now()
            time.sleep(0.02)

    def wait_picture(self) -> None:
        """Wait for a picture that is taken from now on."""
        now_s = time.monotonic()

        def fresh() -> bool:
            frame = self.service.latest().get()
            return frame is not None and frame.acquired_monotonic > now_s

        self.wait(fresh)


@pytest.fixture
def watched(source: Source) -> Iterator[Watched]:
    watched = Watched(source.url)
    yield watched
    watched.service.stop()


def test_the_newest_picture_is_there_with_its_own_time(watched: Watched) -> None:
    watched.wait_picture()
    entry = watched.service.latest().entry()
    assert entry is not None
    assert entry.value.jpeg.startswith(b"\xff\xd8")
    assert entry.born_s == entry.value.acquired_monotonic <= time.monotonic()
    assert watched.health.state == "ok"


def test_a_killed_child_is_replaced(watched: Watched) -> None:
    watched.wait_picture()
    pid = watched.service.pid
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    watched.wait(lambda: watched.service.restarts > 0)
    watched.wait_picture()


def test_a_stopped_child_is_killed_and_replaced(watched: Watched) -> None:
    watched.wait_picture()
    pid = watched.service.pid
    assert pid is not None
    os.kill(pid, signal.SIGSTOP)
    watched.wait(lambda: watched.service.restarts == 1)  # it is lost for a moment only
    watched.wait_picture()
    assert watched.service.pid != pid


def test_a_silent_camera_is_lost_and_comes_back(watched: Watched, source: Source) -> None:
    watched.wait_picture()
    source.silent.set()
    watched.wait(lambda: watched.health.state == "lost")
    assert watched.health.reason == "camera_lost"
    source.silent.clear()
    watched.wait_picture()
    watched.wait(lambda: watched.health.state == "ok")


def test_a_stream_without_pictures_is_said(watched: Watched, source: Source) -> None:
    watched.wait_picture()
    source.garbage = True
    watched.wait(lambda: "no whole JPEG" in watched.health.detail)


def test_something_else_than_a_stream_is_said(source: Source) -> None:
    source.kind = "text/html"
    watched = Watched(source.url)
    watched.wait(lambda: "is it the address of the MJPEG stream itself?" in watched.health.detail)
    watched.service.stop()


def test_a_wrong_path_is_said(source: Source) -> None:
    watched = Watched(source.url + "/other?pwd=S3cret")
    watched.wait(lambda: "refuses: 404" in watched.health.detail)
    assert "S3cret" not in watched.health.detail
    watched.service.stop()


def test_nobody_there_is_said(source: Source) -> None:
    source.stopping.set()
    url = source.url
    source.server_close()
    watched = Watched(url)
    watched.wait(lambda: "does not answer" in watched.health.detail)
    assert "camera.url" in watched.health.detail
    watched.service.stop()


@pytest.mark.parametrize(
    "answer",
    [b"RTSP/1.0 400 Bad Request\r\n\r\n", b"HTTP/1.1 " + b"x" * 70_000 + b"\r\n\r\n"],
    ids=["RTSP", "endless"],
)
def test_what_is_no_web_server_is_said(answer: bytes) -> None:
    def serve() -> None:
        connection, _ = server.accept()
        with connection:
            connection.recv(1 << 16)
            connection.sendall(answer)

    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        at = f"http://127.0.0.1:{server.getsockname()[1]}"
        with pytest.raises(CameraError) as caught:
            http_stream.connect(f"{at}/stream?pwd=S3cret")
        thread.join(LONG_S)
    text = f"the camera at {at} answers, but not as a web server (HTTP); check camera.url"
    assert str(caught.value) == text


def test_no_camera_is_no_fault() -> None:
    health = Health("camera")
    service = CameraService(CameraConfig(), health)
    service.start()
    service.stop()
    assert (health.state, health.reason) == ("ok", "ok")
    assert service.latest().get() is None
