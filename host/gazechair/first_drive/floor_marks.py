"""The step that calibrates the camera over the floor: marks tapped in the picture on a phone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gazechair.commissioning.calibrate.errors import CalibrateError
from gazechair.commissioning.calibrate.marks import ByEye, from_marks
from gazechair.picture.floor import FloorCamera
from gazechair.picture.floor_calibration import Tap
from gazechair.picture.floor_store import FloorStore
from gazechair.picture.pixels import CAN_DECODE, size_px

MOST_MARKS = 16
_MOST_CM = 1000.0
# Drawn over the picture, so that a tape on the floor shows whether they are right: metres.
_LINES_M = (1.0, 2.0, 3.0)
_ASIDE_M = np.linspace(-1.0, 1.0, 9)


class FloorMarks:
    """The stored calibration of the camera over the floor, and its fit."""

    def __init__(self, store: FloorStore, picture: Callable[[], bytes | None]) -> None:
        """`picture`: returns the camera's newest JPEG, unchanged."""
        self._store = store
        self._picture = picture

    @property
    def readable(self) -> bool:
        """True if this computer can decode pictures."""
        return CAN_DECODE

    def size_px(self) -> tuple[int, int] | None:
        """Width and height of the newest picture; None: there is none."""
        jpeg = self._picture() if CAN_DECODE else None
        return None if jpeg is None else size_px(jpeg)

    def row(self) -> dict[str, Any]:
        """For GET /first-drive: what is stored, and floor lines as fractions of the picture."""
        size, known = self.size_px(), self._store.get()
        shape = None if size is None else list(size)
        if known is None:
            return {"done": False, "size": shape, "found": None, "lines": []}
        camera = known.camera
        fits = size is None or camera.same_shape(size)
        found = {"residual_mm": round(1000.0 * known.residual_m), "fits": fits}
        lines = _lines(camera) if fits else []
        return {"done": fits, "size": shape, "found": found, "lines": lines}

    def fit(self, marks: Sequence[Sequence[float]]) -> None:
        """Fit and store a calibration from `marks`, see `marks_of`. Raises CalibrateError."""
        size = self.size_px()
        if size is None:
            raise CalibrateError("no picture comes from the camera; repeat it", "floor_no_picture")
        taps = [Tap((u * size[0], v * size[1]), (x / 100.0, y / 100.0)) for u, v, x, y in marks]
        found = from_marks(size, ByEye(), taps)
        try:
            self._store.keep(found)
        except OSError as error:
            text = "it was not stored ({error})"
            raise CalibrateError(text, "store_failed", error=str(error)) from None


def marks_of(value: Any) -> list[list[float]] | None:
    """Rows from a page: fractions of the picture's width and height, cm forward and to the left of
    the drive axle; None: `value` is malformed."""
    if not isinstance(value, list) or len(value) > MOST_MARKS:
        return None
    for row in value:
        if not isinstance(row, list) or len(row) != 4:
            return None
        if not all(type(one) in (int, float) and abs(one) <= _MOST_CM for one in row):
            return None
    return value


def _lines(camera: FloorCamera) -> list[dict[str, Any]]:
    drawn = []
    for ahead_m in _LINES_M:
        points = np.column_stack((np.full(len(_ASIDE_M), ahead_m), _ASIDE_M))
        points = points[camera.sees(points)]
        shares = camera.pixels(points) / (camera.width_px, camera.height_px)
        if len(points) > 1:
            drawn.append({"m": ahead_m, "px": np.round(shares, 3).tolist()})
    return drawn
