"""The pairing desk: exchanges codes for tokens, identifies a token's device, revokes devices."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from gazechair.base.health import Health
from gazechair.base.latest_value import Clock
from gazechair.base.throttled_log import ThrottledLog
from gazechair.people.pairing.lockout import Lockout
from gazechair.people.pairing.one_time import VALID_S, OneTimeCode, OneTimeCodes
from gazechair.people.pairing.store import Device, DeviceStore, StoreError

MOST_NAME = 40
_NOTE_USE_S = 3600  # "last used" is written to disk at most this often
_NOTE_S = 60.0  # and tried this often
_NO_CODE = "no such code, or it was used or is too old"

log = logging.getLogger(__name__)
throttled = ThrottledLog(log)


@dataclass(frozen=True)
class Paired:
    """The code was right: the device's new token, shown only once."""

    device: Device
    token: str


@dataclass(frozen=True)
class Rejected:
    """Why a device is not paired."""

    reason: str
    """wrong_code or too_many_guesses."""
    detail: str
    wait_s: float


class PairingDesk:
    """Thread-safe. Lock-out and codes live in memory, devices in a file of the state folder."""

    def __init__(
        self,
        folder: Path,
        clock: Clock = time.monotonic,
        wall: Callable[[], float] = time.time,
        health: Health | None = None,
    ) -> None:
        """`folder`: the state folder, created if missing; `health`: see DeviceStore.

        Raises StoreError.
        """
        self._store = DeviceStore(folder, health)
        self._clock = clock
        self._wall = wall
        self._lock = threading.Lock()
        self._changing = threading.Lock()  # taken while writing to disk; known devices do not wait
        self._codes = OneTimeCodes()
        self._lockout = Lockout()
        self._seen: dict[str, int] = {}  # id -> last use, newer than on disk
        self._note_at_s = float("-inf")
        self._on_revoke: list[Callable[[str], None]] = []

    def on_revoke(self, act: Callable[[str], None]) -> None:
        """Have `act(id)` called after each revocation, on the revoking thread."""
        self._on_revoke.append(act)

    def new_code(self, role: str, valid_s: float = VALID_S) -> OneTimeCode:
        """A code with which one device becomes a `role`."""
        with self._lock:
            return self._codes.new(role, self._clock(), valid_s)

    def is_open(self, code: str) -> bool:
        """True while that code could still be used."""
        with self._lock:
            return self._codes.is_open(code, self._clock())

    def pair(self, code: str, name: str, address: str) -> Paired | Rejected:
        """Use a code from `address` for a device called `name`. Raises StoreError."""
        with self._lock:
            found = self._code(code, address)  # a wrong one waits for no disk
        if isinstance(found, Rejected):
            return found
        with self._changing:
            if not self.is_open(code):
                return Rejected("wrong_code", _NO_CODE, 0.0)
            name = _plain(name) or found.role
            device, token = self._store.add(found.role, name, int(self._wall()))
            with self._lock:
                self._codes.use(found)  # only now: the code survives a full list or disk
                self._lockout.right(address)
        log.info("paired %s %s (%s) from %s", device.role, device.id, device.name, address)
        return Paired(device, token)

    def _code(self, code: str, address: str) -> OneTimeCode | Rejected:
        now_s = self._clock()
        wait_s = self._lockout.wait_s(address, code, now_s)
        if wait_s > 0:
            detail = f"too many wrong codes; ask again in {wait_s:.1f} s"
            return Rejected("too_many_guesses", detail, wait_s)
        found = self._codes.find(code, now_s)
        if found is None:
            self._lockout.wrong(address, now_s)
            throttled.warn("wrong pairing code from %s", address)
            return Rejected("wrong_code", _NO_CODE, 0.0)
        return found

    def who(self, token: str) -> Device | None:
        """The device with that token; notes its use. Never waits for the disk."""
        device = self._store.find(token)
        if device is not None:
            with self._lock:
                self._seen[device.id] = int(self._wall())
        return device

    def note_uses(self) -> None:
        """Store when devices were last used; called now and then."""
        now_s = self._clock()
        if now_s < self._note_at_s:
            return
        self._note_at_s = now_s + _NOTE_S
        with self._lock:
            seen = dict(self._seen)
        with self._changing:
            for device in self._store.all():
                # Less than before: the clock was ahead.
                if abs(seen.get(device.id, device.last_used) - device.last_used) >= _NOTE_USE_S:
                    try:
                        self._store.used(device.id, seen[device.id])
                    except StoreError as error:  # a full disk must not lock anybody out
                        throttled.warn("%s", error)

    def is_paired(self, id: str) -> bool:
        """True until the device is revoked."""
        return any(device.id == id for device in self._store.all())

    def devices(self) -> list[Device]:
        """Every paired device, oldest first."""
        with self._lock:
            return [
                replace(device, last_used=self._seen.get(device.id, device.last_used))
                for device in self._store.all()
            ]

    @property
    def problem(self) -> str:
        """Which devices are not known, in one line; "" when all are."""
        return self._store.problem

    def revoke(self, id: str) -> bool:
        """Forget a device; its sockets close at once. False: unknown id. Raises StoreError."""
        with self._changing:
            found = self._store.remove(id)
        if found:
            log.info("revoked %s", id)
            for act in self._on_revoke:
                act(id)
        return found


def _plain(name: str) -> str:
    return "".join(sign for sign in name if sign.isprintable()).strip()[:MOST_NAME]
