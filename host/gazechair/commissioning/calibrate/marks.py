"""Fits the camera's pose over the floor to marks on it; reports errors as text.

Used by both the command and the caretaker's page.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from gazechair.commissioning.calibrate.errors import CalibrateError
from gazechair.picture import floor_calibration as floor
from gazechair.picture.floor import FloorCamera
from gazechair.picture.floor_calibration import Calibration, Refused, Tap, calibrate

WHY = {
    floor.FEW: f"there are fewer than {floor.LEAST_TAPS} marks",
    floor.SPREAD: "the marks lie in one line; lay them out to the sides and in depth",
    floor.UNITS: "the places cannot be metres from the drive axle, or the camera's height is wrong",
    floor.RESIDUAL: "the marks do not fit each other, they disagree by {cm:.0f} cm 2 m ahead;"
    " measure and look again, first the one named (mark {mark})",
    floor.SWAPPED: "left and right are swapped: y is positive to the left",
    floor.AXES: "x and y are swapped: x is forward, y to the left",
    floor.UNSURE: "the marks do not tell enough; add some, nearer and farther, left and right",
    floor.OUTSIDE: "a mark is outside of the picture; pixels count from its upper left corner"
    " (mark {mark})",
}
_MOST_CM = 999.0  # shown for a mark that the fit sees above the horizon
_STAYS = "; what was stored before stays"


@dataclass(frozen=True)
class ByEye:
    """Estimate of the camera's pose by eye: the fit's start."""

    height_m: float = 1.1
    down_deg: float = 25.0
    field_deg: float = 70.0
    """Angle of the picture's width."""

    def camera(self, size_px: tuple[int, int]) -> FloorCamera:
        """A camera with this pose and this picture size. Raises CalibrateError."""
        height = 0.1 < self.height_m < 3.0
        if not (height and 0.0 < self.down_deg < 90.0 and 20.0 < self.field_deg < 150.0):
            raise CalibrateError("no camera on a chair has that --height, --down or --field")
        focal_px = 0.5 * size_px[0] / math.tan(math.radians(0.5 * self.field_deg))
        return FloorCamera(*size_px, focal_px, self.height_m, math.radians(self.down_deg))


def from_marks(size_px: tuple[int, int], eye: ByEye, taps: Sequence[Tap]) -> Calibration:
    """The camera that fits the taps in a picture of this size. Raises CalibrateError."""
    found = calibrate(eye.camera(size_px), taps)
    if isinstance(found, Refused):
        mark = 0 if found.worst is None else found.worst + 1
        cm = min(100.0 * (found.residual_m or 0.0), _MOST_CM)
        raise CalibrateError(WHY[found.reason] + _STAYS, found.reason, mark=mark, cm=cm)
    return found
