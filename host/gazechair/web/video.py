"""The picture sockets: one frame in flight, the next only after the page has drawn the last.

Each viewer gets pictures as large as its own link carries in time; see gazechair.picture.
"""

from __future__ import annotations

import contextlib
import logging
import struct
import threading
import time
from typing import Any

from gazechair.camera import Frame
from gazechair.picture import Pacing, Reducer
from gazechair.slots import Latest
from gazechair.web.sockets import (
    CLOSE_POLICY,
    CLOSE_TRY_LATER,
    CLOSE_UNSUPPORTED,
    GONE,
    hang_up,
    prepare,
)

MAX_CLIENTS = 8
HEADER = struct.Struct("<II")  # sequence, expected age_ms at arrival; a JPEG follows
_TOO_OLD_S = 1.0  # the page greys the picture at 0.5 s: older ones are not worth the way
_ACK_S = 5.0
_WAIT_S = 0.2

log = logging.getLogger(__name__)


class VideoHub:
    """All picture sockets of one server."""

    def __init__(self, video: Latest[Frame] | None) -> None:
        self._video: Latest[Frame] = Latest() if video is None else video
        self._reducer = Reducer()
        self._lock = threading.Condition()
        self._clients: set[_Viewer] = set()
        self._stopping = False

    def stop(self) -> None:
        """Cut every socket."""
        with self._lock:
            self._stopping = True
            for viewer in self._clients:
                viewer.cut()
            self._lock.wait_for(lambda: not self._clients, 3.0)

    def serve(self, ws: Any, peer: str) -> None:
        """Serve one page until its socket ends; runs on the request's own thread."""
        prepare(ws)
        viewer = _Viewer(ws, self._video, self._reducer)
        with self._lock:
            full = len(self._clients) >= MAX_CLIENTS or self._stopping
            if not full:
                self._clients.add(viewer)
        if full:
            log.warning("refused picture for %s: %d are connected already", peer, MAX_CLIENTS)
            with contextlib.suppress(*GONE):
                ws.close(CLOSE_TRY_LATER, f"at most {MAX_CLIENTS} pictures at once")
            return
        try:
            viewer.run()
        except GONE:
            pass
        finally:
            viewer.end()
            with self._lock:
                self._clients.discard(viewer)
                self._lock.notify_all()


class _Viewer:
    def __init__(self, ws: Any, video: Latest[Frame], reducer: Reducer) -> None:
        self._ws = ws
        self._video = video
        self._reducer = reducer
        self._pacing = Pacing(reducer.top)
        self._acked = threading.Condition()
        self._in_flight = 0
        self._drawn = 0
        self._ended = False
        self._sender = threading.Thread(target=self._send_all, name="web-video", daemon=True)

    def run(self) -> None:
        """Receive acknowledgements until the socket ends. Raises one of GONE."""
        self._sender.start()
        while True:
            text = self._ws.receive(_WAIT_S)
            if text is None:
                if not self._ws.thread.is_alive():
                    return
                continue
            with self._acked:
                expected = str(self._in_flight)
                if text == expected:
                    self._drawn = self._in_flight
                    self._acked.notify()
            if text != expected:
                self._ws.close(CLOSE_UNSUPPORTED, f"expected the frame number {expected}")
                return

    def cut(self) -> None:
        hang_up(self._ws)

    def end(self) -> None:
        with self._acked:
            self._ended = True
            self._acked.notify()
        hang_up(self._ws)
        self._sender.join(2.0)

    def _send_all(self) -> None:
        version = 0
        try:
            while not self._ended:
                entry = self._video.wait(_WAIT_S, version)
                if entry is None:
                    continue
                version = entry.version
                frame = entry.value
                if time.monotonic() - frame.acquired_monotonic > _TOO_OLD_S:
                    continue
                jpeg = self._reducer.reduced(frame, self._pacing.level)
                with self._acked:
                    self._in_flight += 1
                    sequence = self._in_flight
                sent_s = time.monotonic()
                age_s = sent_s - frame.acquired_monotonic + self._pacing.way_s
                age_ms = max(0, round(age_s * 1000))
                self._ws.send(HEADER.pack(sequence & 0xFFFFFFFF, age_ms) + jpeg)
                with self._acked:
                    done = self._acked.wait_for(
                        lambda: self._drawn == self._in_flight or self._ended, _ACK_S
                    )
                if not done:
                    self._ws.close(CLOSE_POLICY, "the picture was not acknowledged")
                    return
                now_s = time.monotonic()
                self._pacing.acknowledged(now_s - sent_s, now_s)
        except GONE:
            hang_up(self._ws)
