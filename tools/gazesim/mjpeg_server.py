"""A camera on the network: pictures as MJPEG over HTTP, newest frame only.

Each part carries Content-Length and X-Timestamp (CLOCK_MONOTONIC seconds when the scene was taken).
"""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

_PERIOD_S = 0.1
_SEND_TIMEOUT_S = 10.0  # a reader that takes nothing for this long is dropped
_SEND_BUFFER = 32768  # a slow reader gets newer frames, not more of them

# Takes a picture now: a JPEG.
Shoot = Callable[[], bytes]


class MjpegServer:
    """Serves the picture on a free loopback port; 10 frames/s, only while somebody looks."""

    def __init__(self, shoot: Shoot) -> None:
        self._shoot = shoot
        self._changed = threading.Condition()
        self._frame = (0, 0.0, b"")  # number, time taken, JPEG
        self._readers = 0
        self._stopping = False
        self.stalled = False  # fault: no new frames
        self.off = False  # fault: refuses all readers
        self._server = _Server(self)
        self.url = f"http://127.0.0.1:{self._server.server_address[1]}/"
        self._threads = (
            threading.Thread(target=self._take, name="camera-shoot", daemon=True),
            threading.Thread(
                target=self._server.serve_forever, args=(0.2,), name="camera-http", daemon=True
            ),
        )

    def start(self) -> None:
        """Begin to serve."""
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """End its threads, its readers included; also when it was never started."""
        self._stopping = True
        with self._changed:
            self._changed.notify_all()
        running = [thread for thread in self._threads if thread.is_alive()]
        if running:
            self._server.shutdown()  # without its thread this would wait for ever
        self._server.server_close()
        for thread in running:
            thread.join(timeout=5.0)

    @property
    def readers(self) -> int:
        """Number of present readers."""
        return self._readers

    def _take(self) -> None:
        while not self._stopping:
            begin_s = time.monotonic()
            if not self._readers or self.stalled or self.off:
                with self._changed:
                    self._changed.wait(timeout=_PERIOD_S)
                continue
            jpeg = self._shoot()
            with self._changed:
                self._frame = (self._frame[0] + 1, begin_s, jpeg)
                self._changed.notify_all()
            time.sleep(max(0.0, begin_s + _PERIOD_S - time.monotonic()))

    def send_frames(self, send: Callable[[float, bytes], None]) -> None:
        """A reader's loop: pass each new frame to `send`; skips those that arrive meanwhile."""
        with self._changed:
            self._readers += 1
            last = self._frame[0]
            self._changed.notify_all()
        try:
            while not self._stopping and not self.off:
                with self._changed:
                    if self._frame[0] == last:
                        self._changed.wait(timeout=0.5)
                    number, taken_s, jpeg = self._frame
                if number != last:
                    last = number
                    send(taken_s, jpeg)
        finally:
            with self._changed:
                self._readers -= 1


class _Server(ThreadingHTTPServer):
    daemon_threads = False  # server_close joins them

    def __init__(self, camera: MjpegServer) -> None:
        self.camera = camera
        super().__init__(("127.0.0.1", 0), _Handler)

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore readers that disconnect."""


class _Handler(BaseHTTPRequestHandler):
    server: _Server
    timeout = _SEND_TIMEOUT_S

    def log_message(self, format: str, *args: object) -> None:
        """No access log."""

    def do_GET(self) -> None:
        """Any path is the stream."""
        threading.current_thread().name = "camera-reader"
        camera = self.server.camera
        if camera.off:
            self.send_error(503, "camera is off")
            return
        self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        self.send_response(200)
        self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        camera.send_frames(self._send)

    def _send(self, taken_s: float, jpeg: bytes) -> None:
        head = (
            f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n"
            f"X-Timestamp: {taken_s:.6f}\r\n\r\n"
        )
        self.wfile.write(head.encode() + jpeg + b"\r\n")
