"""The picture sockets: one frame in flight, the next only after the page has drawn the last.

Each viewer gets pictures as large as its own link carries in time; see gazechair.picture.
"""

from __future__ import annotations

import contextlib
import logging
import struct
import threading
import time

from gazechair.base.latest_value import Latest
from gazechair.base.throttled_log import ThrottledLog
from gazechair.people.pairing import Device
from gazechair.picture import Pacing, Reducer
from gazechair.picture.camera import Frame
from gazechair.web.role_limits import ConnectedPage, Full, makes_way
from gazechair.web.websocket import CLOSE_POLICY, CLOSE_TRY_LATER, CLOSE_UNSUPPORTED, WebSocket

PICTURES = {"driver": 3, "caretaker": 3, "viewer": 2}
"""Connections at a time, by role."""
HEADER = struct.Struct("<II")  # sequence, expected age_ms at arrival; a JPEG follows
_TOO_OLD_S = 1.0  # the page greys the picture at 0.5 s: older ones are not sent
_ACK_S = 5.0
_WAIT_S = 0.2

throttled = ThrottledLog(logging.getLogger(__name__))


class PictureHub:
    """All picture sockets of one server."""

    def __init__(self, pictures: Latest[Frame] | None) -> None:
        self._pictures: Latest[Frame] = Latest() if pictures is None else pictures
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

    def serve(self, ws: WebSocket, peer: str, device: Device) -> None:
        """Serve one page until its socket ends; runs on the request's own thread."""
        viewer = _Viewer(ws, self._pictures, self._reducer, device)
        if not self._admit(viewer):
            most = PICTURES[device.role]
            throttled.warn("refused picture for %s: %d are connected already", peer, most)
            with contextlib.suppress(OSError):
                ws.close(CLOSE_TRY_LATER, f"at most {most} pictures of a {device.role}")
            return
        try:
            viewer.run()
        except OSError:
            pass
        finally:
            viewer.end()
            with self._lock:
                self._clients.discard(viewer)
                self._lock.notify_all()

    def _admit(self, viewer: _Viewer) -> bool:
        device = viewer.device
        with self._lock:
            same_role = [v for v in self._clients if v.device.role == device.role and not v.gone]
            connected = [ConnectedPage(v, v.device.id, v.since_s) for v in same_role]
            try:
                goes = makes_way(connected, PICTURES[device.role], device.id)
            except Full:
                return False
            if self._stopping:
                return False
            if goes is not None:
                goes.cut()
            self._clients.add(viewer)
        return True


class _Viewer:
    def __init__(
        self, ws: WebSocket, pictures: Latest[Frame], reducer: Reducer, device: Device
    ) -> None:
        self._ws = ws
        self.device = device
        self.since_s = time.monotonic()
        self.gone = False
        self._pictures = pictures
        self._reducer = reducer
        self._pacing = Pacing(reducer.top)
        self._acked = threading.Condition()
        self._in_flight = 0
        self._drawn = 0
        self._ended = False
        self._sender = threading.Thread(target=self._send_all, name="web-picture", daemon=True)

    def run(self) -> None:
        """Receive acknowledgements until the socket ends. Raises OSError."""
        self._sender.start()
        while True:
            text = self._ws.receive(_WAIT_S)
            if text is None:
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
        self.gone = True
        self._ws.hang_up()

    def end(self) -> None:
        with self._acked:
            self._ended = True
            self._acked.notify()
        self._ws.hang_up()
        self._sender.join(2.0)

    def _send_all(self) -> None:
        version = 0
        try:
            while not self._ended:
                entry = self._pictures.wait(_WAIT_S, version)
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
        except OSError:
            self._ws.hang_up()
