"""The diary: a bounded file of alerts, replaced atomically; damaged lines are skipped."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from gazechair.base.state_folder import replace_file
from gazechair.base.throttled_log import ThrottledLog

FILE_NAME = "alerts.jsonl"
MOST_BYTES = 100_000

log = logging.getLogger(__name__)


class Diary:
    """One line of JSON for each alert, oldest first."""

    def __init__(self, folder: Path) -> None:
        """`folder`: the state folder."""
        self._path = folder / FILE_NAME
        self._throttled = ThrottledLog(log)

    def read(self) -> list[dict[str, Any]]:
        """Every alert that can be read."""
        try:
            text = self._path.read_text(encoding="utf-8", errors="replace")
        except FileNotFoundError:
            return []
        except OSError as error:
            self._throttled.warn("%s: cannot be read (%s)", self._path, error.strerror)
            return []
        found = []
        for number, line in enumerate(text.splitlines(), 1):
            try:
                row = json.loads(line)
            except (ValueError, RecursionError):
                row = None
            if isinstance(row, dict):
                found.append(row)
            else:
                self._throttled.warn("%s:%d is damaged; left out", self._path, number)
        return found

    def write(self, rows: Iterable[Mapping[str, Any]]) -> bool:
        """Replace the file, without the oldest lines if too large. False: the write failed."""
        lines = [json.dumps(row).encode() + b"\n" for row in rows]
        size = sum(map(len, lines))
        first = 0
        while size > MOST_BYTES:
            size -= len(lines[first])
            first += 1
        try:
            replace_file(self._path, b"".join(lines[first:]))
        except OSError as error:
            self._throttled.warn("%s: %s; alerts are not kept", self._path, error.strerror)
            return False
        return True
