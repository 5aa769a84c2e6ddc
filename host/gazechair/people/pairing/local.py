"""The daemon's local socket for the command line: a unix socket in the state folder.

Only the daemon's own user may use it. One request per connection, one line of JSON in each
direction: {"ask": "code", "role", "valid_s"}, {"ask": "open", "code"}, {"ask": "list"} or
{"ask": "revoke", "id"}.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import socket
import struct
import threading
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gazechair.base import json_text
from gazechair.base.state_folder import set_aside
from gazechair.base.throttled_log import ThrottledLog
from gazechair.base.user_error import UserError
from gazechair.people.pairing.desk import PairingDesk
from gazechair.people.pairing.one_time import VALID_S
from gazechair.people.pairing.store import ROLES, StoreError

SOCKET_NAME = "pair.sock"
LONGEST_VALID_S = 12 * 3600.0
_DEADLINE_S = 2.0
_MOST_BYTES = 4096
_LOOK_S = 0.2

log = logging.getLogger(__name__)
throttled = ThrottledLog(log)


class NotRunning(Exception):
    """Raised when no daemon listens in that state folder."""


class RequestRefused(UserError):
    """Raised when the daemon answers with the reason why it did not do it."""


class LocalDoor:
    """Serves the local socket on its own thread; makes it again when somebody has removed it."""

    def __init__(self, desk: PairingDesk, folder: Path, url: Callable[[], str]) -> None:
        """`url` returns the address of the pairing page, without a code."""
        self._desk = desk
        self._folder = folder
        self._url = url
        self._socket: socket.socket | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="pairing-door", daemon=True)

    def start(self) -> None:
        """Listen. A folder that cannot be written is only logged, and tried again: nobody can be
        paired until then."""
        self._listen()
        self._thread.start()

    def _listen(self) -> None:
        door = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if (self._folder / SOCKET_NAME).is_dir():
                set_aside(self._folder / SOCKET_NAME)
            with _short(self._folder) as path:
                with contextlib.suppress(FileNotFoundError):
                    os.unlink(path)
                os.fchmod(door.fileno(), 0o600)
                door.bind(path)
            door.listen(8)
        except OSError as error:
            door.close()
            at = self._folder / SOCKET_NAME
            throttled.warn("%s: %s; nobody can be paired", at, error.strerror)
            return
        door.settimeout(_LOOK_S)
        if self._socket is not None:
            self._socket.close()
        self._socket = door

    def stop(self) -> None:
        """End the thread, and remove the socket. Safe to call when start failed."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(5.0)
        if self._socket is None:
            return
        self._socket.close()
        with contextlib.suppress(OSError):
            (self._folder / SOCKET_NAME).unlink()
        self._socket = None

    def _run(self) -> None:
        while not self._stopping.is_set():
            if self._socket is None or not os.path.lexists(self._folder / SOCKET_NAME):
                self._listen()
            if self._socket is None:
                self._stopping.wait(_LOOK_S)
                self._desk.note_uses()
                continue
            try:
                connection, _ = self._socket.accept()
            except TimeoutError:
                self._desk.note_uses()
                continue
            except OSError:  # too many files are open just now
                self._stopping.wait(_LOOK_S)
                continue
            with connection, contextlib.suppress(OSError):
                connection.settimeout(_DEADLINE_S)
                if _user_of(connection) not in (0, os.getuid()):
                    continue
                answer = self._answer(_read_line(connection))
                connection.sendall(json.dumps(answer).encode() + b"\n")

    def _answer(self, line: bytes) -> dict[str, Any]:
        try:
            request = json_text.parse(line)
            what = request["ask"]
            if what == "code":
                return self._code(str(request["role"]), float(request.get("valid_s", VALID_S)))
            if what == "open":
                return {"open": self._desk.is_open(str(request["code"]))}
            if what == "list":
                devices = [asdict(device) for device in self._desk.devices()]
                return {"devices": devices, "problem": self._desk.problem}
            if what == "revoke":
                return {"revoked": self._desk.revoke(str(request["id"]))}
        except StoreError as error:
            return {"error": str(error)}
        except (ValueError, TypeError, KeyError, OverflowError):
            pass
        return {"error": "no such request; is gazechair pair of the daemon's version?"}

    def _code(self, role: str, valid_s: float) -> dict[str, Any]:
        if role not in ROLES or not 1.0 <= valid_s <= LONGEST_VALID_S:
            raise ValueError
        code = self._desk.new_code(role, valid_s)
        return {"code": code.text, "role": role, "valid_s": valid_s, "url": self._url()}


def ask(folder: Path, request: dict[str, Any]) -> dict[str, Any]:
    """The answer of the daemon of a state folder.

    Raises NotRunning, also without access, and RequestRefused.
    """
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as door:
            door.settimeout(_DEADLINE_S)
            with _short(folder) as path:
                door.connect(path)
            door.sendall(json.dumps(request).encode() + b"\n")
            answer = json_text.parse(_read_line(door))
    except (OSError, ValueError) as error:
        raise NotRunning(f"no gazechair run answers at {folder / SOCKET_NAME} ({error})") from None
    if not isinstance(answer, dict) or "error" in answer:
        reason = answer["error"] if isinstance(answer, dict) else "an answer that is none"
        raise RequestRefused(f"gazechair run refuses: {reason}")
    return answer


@contextlib.contextmanager
def _short(folder: Path) -> Iterator[str]:
    # A unix socket's path must be under 108 bytes; a folder's handle makes any path short.
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        yield f"/proc/self/fd/{handle}/{SOCKET_NAME}"
    finally:
        os.close(handle)


def _user_of(connection: socket.socket) -> int:
    size = struct.calcsize("3i")
    credentials = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, size)
    user: int = struct.unpack("3i", credentials)[1]
    return user


def _read_line(connection: socket.socket) -> bytes:
    line = b""
    while not line.endswith(b"\n"):
        data = connection.recv(_MOST_BYTES)
        line += data
        if not data or len(line) > 16 * _MOST_BYTES:
            break
    return line
