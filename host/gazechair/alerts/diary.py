"""The diary: a bounded file of alerts, replaced atomically; damaged lines are skipped."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from gazechair.alerts.book import OVER
from gazechair.base import json_text
from gazechair.base.health import Health
from gazechair.base.reasons import ALERT_DIARY
from gazechair.base.state_file import StateFile

FILE_NAME = "alerts.jsonl"
MOST_BYTES = 100_000


class Diary:
    """One line of JSON for each alert, oldest first."""

    def __init__(self, folder: Path, health: Health | None = None) -> None:
        """`folder`: the state folder; `health`: degraded while the file cannot be used."""
        self._file = StateFile(folder / FILE_NAME, health or Health(ALERT_DIARY))

    @property
    def problem(self) -> str:
        """Which alerts are not known, or not kept, in one line; "" when all are."""
        return self._file.problem

    def read(self) -> list[dict[str, Any]]:
        """Every alert that can be read."""
        try:
            # Of the ends of lines that Python knows, JSON escapes only some.
            with self._file.path.open(encoding="utf-8-sig", errors="replace", newline="\n") as file:
                lines = list(file)
        except FileNotFoundError:
            lines = []
        except OSError as error:
            self._file.damaged(f"cannot be read ({error.strerror})")
            return []
        found = []
        for line in lines:
            try:
                row = json_text.parse(line)
            except ValueError:
                row = None
            if isinstance(row, dict):
                found.append(row)
        if len(found) < len(lines):
            self._file.damaged(f"{len(lines) - len(found)} damaged lines are left out")
        else:
            self._file.sound()
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
            self._file.replace(b"".join(line for line, _ in kept))
        except OSError as error:
            self._file.not_kept(error, "alerts are not kept")
            return False
        return True


def _line(row: Mapping[str, Any]) -> bytes:
    text = json.dumps(row, ensure_ascii=False)
    # Half of a surrogate pair has no UTF-8: it stays as JSON writes it.
    return text.encode(errors="backslashreplace") + b"\n"
