"""Stores the speed cap, so that it survives a restart of the host."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from pathlib import Path

from gazechair.base.state_folder import replace_file
from gazechair.driving.messages import LOWEST_CAP_PERMILLE

FILE_NAME = "speed_cap"
_NONE = 1000

log = logging.getLogger(__name__)


class KeptCap:
    """One number in a file of the state folder."""

    def __init__(self, folder: Path | None) -> None:
        """None: kept in memory only."""
        self._writing = threading.Lock()
        self._path = None if folder is None else folder / FILE_NAME

    def read(self) -> int:
        """The cap in permille; 1000 (none) before the first.

        A file that cannot be parsed counts as the lowest cap, and is logged.
        """
        if self._path is None:
            return _NONE
        try:
            permille = int(self._path.read_text(encoding="ascii"))
        except FileNotFoundError:
            return _NONE
        except (OSError, ValueError) as error:
            log.error("%s: %s; the lowest speed cap is in force", self._path, error)
            return LOWEST_CAP_PERMILLE
        return max(LOWEST_CAP_PERMILLE, min(permille, _NONE))

    def keep(self, newest: Callable[[], int]) -> None:
        """Write what `newest` returns; a failed write is logged, and the cap is active anyway."""
        if self._path is None:
            return
        try:
            with self._writing:  # of two changes, the last one is stored
                replace_file(self._path, f"{newest()}\n".encode())
        except OSError as error:
            log.error("%s: %s; the speed cap ends with this host", self._path, error.strerror)
