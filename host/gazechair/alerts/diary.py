"""The diary: a bounded file of alerts, replaced atomically; damaged lines are skipped."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from gazechair.alerts.book import OVER
from gazechair.base import json_text
from gazechair.base.state_folder import replace_file, set_aside
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
        self._damaged = False

    def read(self) -> list[dict[str, Any]]:
        """Every alert that can be read."""
        try:
            # Of the ends of lines that Python knows, JSON escapes only some.
            with self._path.open(encoding="utf-8-sig", errors="replace", newline="\n") as file:
                lines = list(file)
        except FileNotFoundError:
            return []
        except OSError as error:
            self._throttled.warn("%s: cannot be read (%s)", self._path, error.strerror)
            self._damaged = True
            return []
        found = []
        for number, line in enumerate(lines, 1):
            try:
                row = json_text.parse(line)
            except ValueError:
                row = None
            if isinstance(row, dict):
                found.append(row)
            else:
                self._damaged = True
                self._throttled.warn("%s:%d is damaged; left out", self._path, number)
        return found

    def write(self, rows: Iterable[Mapping[str, Any]]) -> bool:
        """Replace the file, without the oldest alerts if too large; those that are over go first.

        False: the write failed.
        """
        kept = [(_line(row), row.get("state", OVER) == OVER) for row in rows]
        size = sum(len(line) for line, _ in kept)
        while size > MOST_BYTES:
            first = next((at for at, (_, over) in enumerate(kept) if over), 0)
            size -= len(kept.pop(first)[0])
        try:
            if self._damaged:
                set_aside(self._path)
                self._damaged = False
            replace_file(self._path, b"".join(line for line, _ in kept))
        except OSError as error:
            self._throttled.warn("%s: %s; alerts are not kept", self._path, error.strerror)
            return False
        return True


def _line(row: Mapping[str, Any]) -> bytes:
    text = json.dumps(row, ensure_ascii=False)
    # Half of a surrogate pair has no UTF-8: it stays as JSON writes it.
    return text.encode(errors="backslashreplace") + b"\n"
