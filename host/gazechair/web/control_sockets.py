"""The control sockets of one server, with a connection limit per role."""

from __future__ import annotations

import contextlib
import logging
import threading
import time
from collections.abc import Callable

from gazechair.base.throttled_log import ThrottledLog
from gazechair.driving.driver_port import DriverPort
from gazechair.people.pairing import Device
from gazechair.web.page_client import Ending, PageClient
from gazechair.web.role_limits import ConnectedPage, Full, makes_way
from gazechair.web.websocket import CLOSE_REVOKED, CLOSE_TRY_LATER, WebSocket

PAGES = {"driver": 4, "caretaker": 4, "viewer": 4}
REVOKED = Ending(CLOSE_REVOKED, "this device is not paired any more")
_FALLEN_SILENT_S = 1.0
_LOOK_S = 0.2

log = logging.getLogger(__name__)
throttled = ThrottledLog(log)
visits = ThrottledLog(log)


class ControlHub:
    """All control sockets of one server, and the thread that watches for changes."""

    def __init__(
        self, port: DriverPort, still_paired: Callable[[str], bool], insecure: bool
    ) -> None:
        """`still_paired`: whether a device id is; `insecure`: see PageClient."""
        self._port = port
        self._still_paired = still_paired
        self._insecure = insecure
        self._lock = threading.Condition()
        self._clients: set[PageClient] = set()
        self._stopping = threading.Event()
        self._watcher = threading.Thread(target=self._watch, name="web-watch", daemon=True)

    def start(self) -> None:
        """Start watching for changes."""
        self._watcher.start()

    def stop(self) -> None:
        """Cut every socket (which stops what it commanded) and end the thread."""
        self._stopping.set()
        with self._lock:
            for client in self._clients:
                client.cut()
            self._lock.wait_for(lambda: not self._clients, 3.0)
        if self._watcher.is_alive():
            self._watcher.join(2.0)

    def serve(self, ws: WebSocket, peer: str, device: Device) -> None:
        """Serve one page until its socket ends; runs on the request's own thread."""
        client = self._admit(ws, device)
        if client is None:
            throttled.warn("refused page %s: too many pages of a %s", peer, device.role)
            with contextlib.suppress(OSError):
                ws.close(CLOSE_TRY_LATER, f"at most {PAGES[device.role]} pages of a {device.role}")
            return
        visits.info("page %s of %s connected as client %d", peer, device.id, client.id)
        ending = Ending(None, "its socket closed")
        try:
            if not self._still_paired(device.id):
                client.dismiss(REVOKED)  # revoked while connecting
            ending = client.run()
        except OSError as gone:
            ending = Ending(None, str(gone))
        finally:
            # First: stop what it commanded.
            self._port.disconnect(client.id)
            client.end(ending)
            with self._lock:
                self._clients.discard(client)
                self._lock.notify_all()
            visits.info("page %s, client %d, gone: %s", peer, client.id, ending.why)

    def revoked(self, device_id: str) -> None:
        """Disconnect every page of that device: what it commanded stops before this returns."""
        with self._lock:
            clients = [client for client in self._clients if client.device.id == device_id]
        for client in clients:
            client.dismiss(REVOKED)

    def _admit(self, ws: WebSocket, device: Device) -> PageClient | None:
        # Each role has its own connection limit, so that viewers cannot keep the driver out. A
        # silent page of the same device is left over from before it reconnected.
        replaced = Ending(CLOSE_TRY_LATER, "this device has come back on another connection")
        with self._lock:
            if self._stopping.is_set():
                return None
            now_s = time.monotonic()
            same_role = [
                c for c in self._clients if c.device.role == device.role and not c.dismissed
            ]
            leaving = [
                c
                for c in same_role
                if c.device.id == device.id and now_s - c.received_s > _FALLEN_SILENT_S
            ]
            connected = [
                ConnectedPage(c, c.device.id, c.received_s, c.drives)
                for c in same_role
                if c not in leaving
            ]
            try:
                goes = makes_way(connected, PAGES[device.role], device.id)
            except Full:
                return None
            if goes is not None:
                leaving.append(goes)
            client = PageClient(ws, self._port, device, self._insecure)
            self._clients.add(client)
        for old in leaving:
            old.dismiss(replaced)
        return client

    def _watch(self) -> None:
        version = 0
        while not self._stopping.is_set():
            now = self._port.wait_change(_LOOK_S, version)
            if now != version:
                version = now
                with self._lock:
                    clients = list(self._clients)
                for client in clients:
                    client.changed()
