"""Stores how the chair drives straight in each profile, so that steps are half a metre in all."""

from __future__ import annotations

import json
import logging
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gazechair.base import json_text
from gazechair.base.state_folder import replace_file, set_aside
from gazechair.service.tune.forward import ForwardNumbers
from gazelink.settings_table import PROFILES, TABLE, index_of

FILE_NAME = "forward.json"

log = logging.getLogger(__name__)


class ForwardStore:
    """{profile: numbers} in a file of the state folder. Damaged entries count as not tuned.

    They are kept until that profile is tuned; a file that is damaged as a whole is set aside.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / FILE_NAME

    def keep(self, profile: str, numbers: ForwardNumbers) -> None:
        """Store those of `profile`, replacing older ones. Raises OSError."""
        try:
            rows = self._rows()
        except (ValueError, IsADirectoryError):
            set_aside(self._path)
            rows = {}
        rows[profile] = asdict(numbers)
        replace_file(self._path, json.dumps(rows).encode())

    def step_ms(self, profile: int, permille: int, ramp_ms: int) -> int | None:
        """Duration of a step forward with these settings; None: that profile is not tuned."""
        try:
            row = self._rows().get(PROFILES[profile])
            if row is None:
                return None
            numbers = ForwardNumbers(**{key: float(value) for key, value in row.items()})
        except (OSError, ValueError, TypeError, AttributeError, OverflowError) as error:
            log.error("%s: %s; steps forward last as set", self._path, error)
            return None
        most_ms = TABLE[index_of("step_forward_ms")][3]
        return numbers.step_ms(permille, ramp_ms, most_ms)

    def _rows(self) -> dict[str, Any]:
        """The file's content, not parsed further. Raises OSError; ValueError: it is damaged."""
        try:
            rows = json_text.parse(self._path.read_bytes())
        except FileNotFoundError:
            return {}
        if not isinstance(rows, dict):
            raise ValueError("no object of profiles")
        return rows
