"""Stores the speed cap, so that it survives a restart of the host."""

from __future__ import annotations

import threading
from pathlib import Path

from gazechair.base.health import Health
from gazechair.base.reasons import SPEED_CAP
from gazechair.base.state_file import StateFile
from gazechair.driving.messages import LOWEST_CAP_PERMILLE

FILE_NAME = "speed_cap"
_NONE = 1000
_WRITE_AGAIN_S = 10.0
_LAST_WRITE_S = 2.0


class SpeedCapStore:
    """One number in a file of the state folder; its thread writes it, as the disk may be slow."""

    def __init__(self, folder: Path | None, health: Health | None = None) -> None:
        """`folder` None: kept in memory only; `health`: degraded while the cap is not stored."""
        health = health or Health(SPEED_CAP)
        self._file = None if folder is None else StateFile(folder / FILE_NAME, health)
        self._lock = threading.Lock()
        self._newest: int | None = None  # to be written
        self._wanted = threading.Event()
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name="speed-cap", daemon=True)

    def start(self) -> None:
        """Start the thread that writes."""
        self._thread.start()

    def stop(self) -> None:
        """Write what is not written yet, and end the thread; not later than after 2 s."""
        self._stopping = True
        self._wanted.set()
        if self._thread.is_alive():
            self._thread.join(_LAST_WRITE_S)

    def read(self) -> int:
        """The cap in permille; 1000 (none) before the first.

        A file that cannot be parsed counts as the lowest cap; health is degraded until one is set.
        """
        if self._file is None:
            return _NONE
        try:
            permille = int(self._file.path.read_text(encoding="utf-8-sig"))
        except FileNotFoundError:
            return _NONE
        except (OSError, ValueError) as error:
            self._file.damaged(f"{error}; the lowest speed cap is in force")
            return LOWEST_CAP_PERMILLE
        return max(LOWEST_CAP_PERMILLE, min(permille, _NONE))

    def keep(self, permille: int) -> None:
        """Have this cap written soon, instead of one that is not written yet. Returns at once."""
        with self._lock:
            self._newest = permille
        self._wanted.set()

    def write(self) -> None:
        """Write the newest cap; one that cannot be stored is active anyway, and is tried again."""
        with self._lock:
            permille, self._newest = self._newest, None
        if self._file is None or permille is None:
            return
        try:
            self._file.replace(f"{permille}\n".encode())
        except OSError as error:
            with self._lock:
                self._newest = permille if self._newest is None else self._newest
            self._file.not_kept(error, "the speed cap ends with this host")

    def _run(self) -> None:
        stopping = False
        while not stopping:
            self._wanted.wait(None if self._newest is None else _WRITE_AGAIN_S)
            self._wanted.clear()
            stopping = self._stopping  # before the last write, so that it misses nothing
            self.write()
