"""Stores the calibration of the camera over the floor."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from gazechair.base import json_text
from gazechair.base.health import Health
from gazechair.base.state_file import StateFile
from gazechair.picture.floor import FloorCamera
from gazechair.picture.floor_calibration import RESIDUAL_M, SIGMA_M, Calibration

FILE_NAME = "camera_floor.json"
_NAMES = tuple(field.name for field in fields(FloorCamera))
_PIXELS = ("width_px", "height_px")
_DAMAGE = OSError, ValueError, TypeError, KeyError, OverflowError


class FloorStore:
    """A file in the state folder. A damaged one counts as not calibrated."""

    def __init__(self, folder: Path, health: Health | None = None) -> None:
        """`folder`: the state folder; `health`: degraded while the file is damaged."""
        self._file = StateFile(folder / FILE_NAME, health or Health(FILE_NAME))
        self._seen: tuple[int, int] | None = None
        self._known: Calibration | None = None
        self.get()

    def keep(self, calibration: Calibration) -> None:
        """Replace the older one. Raises OSError."""
        self._file.replace(json.dumps(asdict(calibration), indent=1).encode())

    def get(self) -> Calibration | None:
        """The newest; None: the camera is not calibrated. Reads the file only after a change."""
        try:
            status = self._file.path.stat()
        except FileNotFoundError:
            self._seen = self._known = None
            self._file.sound()
            return None
        except OSError as error:
            self._seen = self._known = None
            self._damaged(error)
            return None
        seen = status.st_mtime_ns, status.st_ino
        if seen != self._seen:
            self._seen, self._known = seen, self._read()
        return self._known

    def _read(self) -> Calibration | None:
        try:
            found = json_text.parse(self._file.path.read_bytes())
            rows = found["camera"]
            values: dict[str, Any] = {name: float(rows[name]) for name in _NAMES}
            camera = FloorCamera(**values | {name: int(rows[name]) for name in _PIXELS})
            calibration = Calibration(camera, float(found["residual_m"]), float(found["sigma_m"]))
            if not _sound(calibration):
                raise ValueError("a calibration that cannot be")
        except _DAMAGE as error:
            self._damaged(error)
            return None
        self._file.sound()
        return calibration

    def _damaged(self, error: Exception) -> None:
        self._file.damaged(f"{error}; the camera counts as not calibrated")


def _sound(one: Calibration) -> bool:
    """True if the values are possible for a calibration."""
    camera = one.camera
    numbers = [getattr(camera, name) for name in _NAMES]
    return (
        all(map(math.isfinite, numbers))
        and min(camera.width_px, camera.height_px) > 0
        and camera.focal_px > 0.0
        and camera.height_m > 0.0
        and 0.0 <= one.residual_m <= RESIDUAL_M
        and 0.0 <= one.sigma_m <= SIGMA_M
    )
