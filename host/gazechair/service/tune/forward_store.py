"""Stores how the chair drives straight in each profile, so that steps are half a metre in all."""

from __future__ import annotations

import json
import logging
from dataclasses import asdict
from pathlib import Path

from gazechair.base.state_folder import replace_file
from gazechair.service.tune.forward import ForwardNumbers
from gazelink.settings_table import PROFILES, TABLE, index_of

FILE_NAME = "forward.json"

log = logging.getLogger(__name__)


class ForwardStore:
    """{profile: numbers} in a file of the state folder. Damaged entries count as not tuned."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / FILE_NAME

    def keep(self, profile: str, numbers: ForwardNumbers) -> None:
        """Store those of `profile`, replacing older ones. Raises OSError."""
        rows = {name: asdict(row) for name, row in self._read().items()}
        rows[profile] = asdict(numbers)
        replace_file(self._path, json.dumps(rows).encode())

    def step_ms(self, profile: int, permille: int, ramp_ms: int) -> int | None:
        """Duration of a step forward with these settings; None: that profile is not tuned."""
        numbers = self._read().get(PROFILES[profile])
        most_ms = TABLE[index_of("step_forward_ms")][3]
        return None if numbers is None else numbers.step_ms(permille, ramp_ms, most_ms)

    def _read(self) -> dict[str, ForwardNumbers]:
        try:
            rows = json.loads(self._path.read_bytes())
            return {
                name: ForwardNumbers(**{key: float(value) for key, value in row.items()})
                for name, row in rows.items()
            }
        except FileNotFoundError:
            return {}
        except (OSError, ValueError, TypeError, AttributeError) as error:
            log.error("%s: %s; steps forward last as set", self._path, error)
            return {}
