"""The paired devices on disk: one line each, in a file that is replaced atomically."""

from __future__ import annotations

import hashlib
import json
import logging
import secrets
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from gazechair.base import json_text
from gazechair.base.health import LOST, Health
from gazechair.base.reasons import DEVICES, DEVICES_DAMAGED
from gazechair.base.state_file import StateFile

FILE_NAME = "paired.jsonl"
MOST_DEVICES = 32
ROLES = ("driver", "caretaker", "viewer")

log = logging.getLogger(__name__)


class StoreError(Exception):
    """Raised when the file cannot be written, or is full: one line, what to do."""


@dataclass(frozen=True)
class Device:
    """One paired device. Times are seconds since 1970."""

    id: str
    """6 hexadecimal digits, by which people name it."""
    role: str
    name: str
    created: int
    last_used: int
    digest: str
    """SHA-256 of its token. A slow hash would protect passwords that people choose; a token is 256
    random bits, which no one finds by trying, however fast."""


def digest_of(token: str) -> str:
    """The stored digest of a token."""
    return hashlib.sha256(token.encode()).hexdigest()


class DeviceStore:
    """Not thread-safe. A device added or removed is on disk when the call returns."""

    def __init__(self, folder: Path, health: Health | None = None) -> None:
        """Reads `folder`/paired.jsonl; creates the folder (0700). Raises StoreError.

        Damaged lines are kept as they are, logged and ignored; a file that cannot be read at all
        stays where it is until a device is paired. `health` tells of both until then.
        """
        self._path = folder / FILE_NAME
        self._devices: dict[str, Device] = {}
        self._strange: list[str] = []
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        except FileExistsError:
            raise StoreError(f"{folder} is no folder; move it away") from None
        except OSError as error:
            raise StoreError(f"{folder}: {error.strerror}; who owns the folder?") from None
        self._file = StateFile(self._path, health or Health(DEVICES), DEVICES_DAMAGED)
        try:
            text = self._path.read_text(encoding="utf-8-sig", errors="replace")
        except FileNotFoundError:
            return
        except OSError as error:
            self._file.damaged(f"{error.strerror}; no device is known, pair them again", LOST)
            return
        self._read(text)

    def _read(self, text: str) -> None:
        for number, line in enumerate(text.splitlines(), 1):
            if not line.strip():
                continue
            device = _parse(line)
            if device is None:
                log.error("%s:%d is no paired device; ignored", self._path, number)
                self._strange.append(line)
            else:
                self._devices[device.id] = device
        if self._strange:
            what = f"{len(self._strange)} damaged lines; what is missing, pair again"
            self._file.damaged(what, aside=False)

    @property
    def problem(self) -> str:
        """Which devices are not known, in one line; "" when all are."""
        return self._file.problem

    def all(self) -> list[Device]:
        """Every device, oldest first."""
        return list(self._devices.values())

    def find(self, token: str) -> Device | None:
        """The device with that token."""
        digest = digest_of(token)
        return next((d for d in self._devices.values() if d.digest == digest), None)

    def add(self, role: str, name: str, now: int) -> tuple[Device, str]:
        """A new device and its token, shown only once. Raises StoreError."""
        if len(self._devices) >= MOST_DEVICES:
            raise StoreError(
                f"{MOST_DEVICES} devices are paired; revoke one first: gazechair pair --list"
            )
        token = secrets.token_urlsafe(32)
        id = secrets.token_hex(3)
        while id in self._devices:
            id = secrets.token_hex(3)
        device = Device(id, role, name, now, now, digest_of(token))
        self._change({**self._devices, id: device})
        return device, token

    def used(self, id: str, now: int) -> None:
        """Note when a device was last seen; a power cut may lose it. Raises StoreError."""
        device = self._devices.get(id)
        if device is not None:
            self._change({**self._devices, id: replace(device, last_used=now)}, durable=False)

    def remove(self, id: str) -> bool:
        """Forget a device; False when there is none of that id. Raises StoreError."""
        if id not in self._devices:
            return False
        self._change({key: device for key, device in self._devices.items() if key != id})
        return True

    def _change(self, devices: dict[str, Device], durable: bool = True) -> None:
        lines = [json.dumps(asdict(device), ensure_ascii=False) for device in devices.values()]
        text = "".join(line + "\n" for line in self._strange + lines)
        try:
            # Whoever gives an unread one back its owner has every device again.
            self._file.replace(text.encode("utf-8", "replace"), durable)
        except OSError as error:
            raise StoreError(f"{self._path}: {error.strerror}; is the disk full?") from None
        self._devices = devices


def _parse(line: str) -> Device | None:
    try:
        device = Device(**json_text.parse(line))
    except (ValueError, TypeError):
        return None
    texts = (device.id, device.name, device.digest)
    numbers = (device.created, device.last_used)
    good = (
        all(isinstance(text, str) for text in texts)
        and all(type(number) is int for number in numbers)
        and device.role in ROLES
    )
    return device if good else None
