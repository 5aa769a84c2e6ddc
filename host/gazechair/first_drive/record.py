"""Stores results of the first drive's steps in a file of the state folder.

Only results that neither board nor host can provide again. Each entry names the conditions, so
that another pose, profile or neutral makes its step "not done" again.
"""

from __future__ import annotations

import json
import sys
import threading
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from gazechair.base import json_text
from gazechair.base.health import Health
from gazechair.base.reasons import FIRST_DRIVE
from gazechair.base.state_file import StateFile
from gazechair.config.rules import Arc, arcs
from gazechair.config.settings import LidarConfig
from gazechair.sensing.lidar.mask import MOST_DEG

FILE_NAME = "first_drive.json"
_WRITE_AGAIN_S = 10.0

_ARCS = arcs(MOST_DEG)  # as the configuration's


class Record:
    """{step: result}. A file that cannot be read counts as empty."""

    def __init__(self, folder: Path | None, health: Health | None = None) -> None:
        """`folder` None: kept in memory only; `health`: degraded while the file cannot be used."""
        health = health or Health(FIRST_DRIVE)
        self._file = None if folder is None else StateFile(folder / FILE_NAME, health)
        self._found: dict[str, Any] = {}
        self._writing = threading.Lock()
        if self._file is not None:
            try:
                found = dict(json_text.parse(self._file.path.read_text(encoding="utf-8")))
                self._found = {step: found[step] for step in found if _sound(step, found[step])}
            except (FileNotFoundError, NotADirectoryError):
                pass
            except (OSError, ValueError, TypeError) as error:
                self._file.damaged(f"{error}; the first drive begins anew")

    def get(self, step: str) -> Any:
        """The result of `step`; None: none yet."""
        return self._found.get(step)

    def keep(self, step: str, found: Any) -> None:
        """Store it; what the disk does not take counts all the same, and is tried again."""
        self._found = {**self._found, step: found}
        if self._file is not None:
            self._write(self._file)

    def _write(self, file: StateFile) -> None:
        try:
            with self._writing:
                file.replace(json.dumps(self._found, indent=1).encode())
        except OSError as error:
            file.not_kept(error, "what was found ends with this host")
            again = threading.Timer(_WRITE_AGAIN_S, self._write, (file,))
            again.daemon = True
            again.start()

    def masked(self, lidars: tuple[LidarConfig, ...]) -> tuple[LidarConfig, ...]:
        """`lidars` with the masks learned on the phone, where the configuration has not changed
        since."""
        learned = [(one, self._learned(one)) for one in lidars]
        return tuple(one if mask is None else replace(one, mask=mask) for one, mask in learned)

    def has_mask_of(self, lidar: LidarConfig) -> bool:
        """True if the mask of `lidar` was learned in its present place."""
        return self._learned(lidar) is not None

    def _learned(self, lidar: LidarConfig) -> tuple[Arc, ...] | None:
        masks = self.get("mask")
        found = masks.get(lidar.name) if isinstance(masks, dict) else None
        if not isinstance(found, dict) or found.get("fitted") != fitted_as(lidar):
            return None
        try:
            return tuple(_ARCS.check(found.get("mask")))
        except (TypeError, ValueError):
            return None


def fitted_as(lidar: LidarConfig) -> dict[str, Any]:
    """The lidar's place by the configuration, as JSON: a mask or a distance belongs to it."""
    whole = asdict(lidar)
    place = {name: whole[name] for name in ("x_m", "y_m", "heading_deg", "upside_down")}
    return {**place, "mask": [[float(a), float(b)] for a, b in lidar.mask]}


def _sound(step: str, found: Any) -> bool:
    """True if the result of `step` has the form that the page expects."""
    if step not in ("distance", "turn"):
        return True
    if not isinstance(found, dict):
        return False
    shown = [found.get("measured_mm"), found.get("seen_mm")]
    if step == "turn":
        turned = found.get("turned_deg")
        shown = [found.get("wanted_deg"), *(turned if isinstance(turned, list) else [None])]
    most = sys.float_info.max  # a whole number of JSON may be larger
    return all(isinstance(one, int | float) and abs(one) <= most for one in shown)
