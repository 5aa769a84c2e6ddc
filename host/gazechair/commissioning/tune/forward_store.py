"""Stores how the chair drives straight in each profile, so that steps are half a metre in all."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gazechair.base import json_text
from gazechair.base.health import Health
from gazechair.base.state_file import StateFile
from gazechair.commissioning.tune.forward import ForwardNumbers
from gazelink.settings_table import PROFILES, TABLE, index_of

FILE_NAME = "forward.json"
_DAMAGE = OSError, ValueError, TypeError, AttributeError, OverflowError


class ForwardStore:
    """{profile: numbers} in a file of the state folder. Damaged entries count as not tuned.

    They are kept until that profile is tuned; a file that is damaged as a whole is set aside.
    """

    def __init__(self, folder: Path, health: Health | None = None) -> None:
        """`folder`: the state folder; `health`: degraded while something in it is damaged."""
        self._file = StateFile(folder / FILE_NAME, health or Health(FILE_NAME))
        self._look()

    def keep(self, profile: str, numbers: ForwardNumbers) -> None:
        """Store those of `profile`, replacing older ones. Raises OSError."""
        try:
            rows = self._rows()
        except (ValueError, IsADirectoryError) as error:
            rows = {}
            self._damaged(error, aside=True)
        rows[profile] = asdict(numbers)
        self._file.replace(json.dumps(rows).encode())
        self._look()

    def step_ms(self, profile: int, permille: int, ramp_ms: int) -> int | None:
        """Duration of a step forward with these settings; None: that profile is not tuned."""
        try:
            row = self._rows().get(PROFILES[profile])
            numbers = None if row is None else _numbers(row)
        except _DAMAGE as error:
            self._damaged(error)
            return None
        if numbers is None:
            return None
        most_ms = TABLE[index_of("step_forward_ms")][3]
        return numbers.step_ms(permille, ramp_ms, most_ms)

    def _look(self) -> None:
        """Report whether all of it can be used."""
        try:
            for row in self._rows().values():
                _numbers(row)
        except _DAMAGE as error:
            self._damaged(error)
        else:
            self._file.sound()

    def _damaged(self, error: Exception, aside: bool = False) -> None:
        self._file.damaged(f"{error}; steps forward last as set", aside=aside)

    def _rows(self) -> dict[str, Any]:
        """The file's content, not parsed further. Raises OSError; ValueError: it is damaged."""
        try:
            rows = json_text.parse(self._file.path.read_bytes())
        except FileNotFoundError:
            return {}
        if not isinstance(rows, dict):
            raise ValueError("no object of profiles")
        return rows


def _numbers(row: Any) -> ForwardNumbers:
    return ForwardNumbers(**{key: float(value) for key, value in row.items()})
