"""`gazechair calibrate camera`: where the camera sits over the floor, from marks on its picture.

Marks on the floor are measured with a tape, from below the middle of the drive axle, and found in
a picture that this takes. What cannot be right is refused with the reason; nothing is stored then.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from gazechair.base.health import Health
from gazechair.base.state_folder import state_folder
from gazechair.config.configuration import Config
from gazechair.picture import floor_calibration as floor
from gazechair.picture.camera import CameraService
from gazechair.picture.floor import FloorCamera
from gazechair.picture.floor_calibration import Calibration, Refused, Tap, calibrate
from gazechair.picture.floor_store import FloorStore
from gazechair.picture.pixels import CAN_DECODE, size_px
from gazechair.service.calibrate.errors import CalibrateError

_PICTURE_S = 15.0

WHY = {
    floor.FEW: f"there are fewer than {floor.LEAST_TAPS} marks",
    floor.SPREAD: "the marks lie in one line; lay them out to the sides and in depth",
    floor.UNITS: "the places cannot be metres from the drive axle, or the camera's height is wrong",
    floor.RESIDUAL: "the marks do not fit each other; measure and look again, first the one named",
    floor.SWAPPED: "left and right are swapped: y is positive to the left",
    floor.AXES: "x and y are swapped: x is forward, y to the left",
    floor.UNSURE: "the marks do not tell enough; add some, nearer and farther, left and right",
    floor.OUTSIDE: "a mark is outside of the picture; pixels count from its upper left corner",
}

Say = Callable[[str], None]


def show(config: Config, say: Say) -> None:
    """What is stored."""
    known = _store(config).get()
    say(_words(known) if known else "the camera is not calibrated: no line is followed by it")


def take_picture(config: Config, path: Path, say: Say) -> None:
    """Save the camera's picture. Raises CalibrateError."""
    if config.camera.kind == "off":
        raise CalibrateError("no camera is configured: set [camera] kind")
    if path.exists():
        raise CalibrateError(f"{path} exists already; name another file, or add --marks")
    service = CameraService(config.camera, Health("camera"))
    service.start()
    try:
        entry = service.latest().wait(_PICTURE_S)
    finally:
        service.stop()
    if entry is None:
        raise CalibrateError("no picture came; does `gazechair run` use the camera? stop it first")
    try:
        path.write_bytes(entry.value.jpeg)
    except OSError as error:
        raise CalibrateError(f"{path} cannot be written: {error}") from None
    say(f"saved {path}; find the marks in it, write a file with a line for each:")
    say("pixels from the left, pixels from the top, metres forward, metres to the left")
    say(f"then: gazechair calibrate camera --picture {path} --marks FILE")


def store(
    config: Config,
    picture: Path,
    marks: Path,
    height_m: float,
    down_deg: float,
    field_deg: float,
    say: Say,
) -> None:
    """Fit the marks and store the result; height, direction down and field of view by eye.

    Raises CalibrateError.
    """
    if not (0.1 < height_m < 3.0 and 0.0 < down_deg < 90.0 and 20.0 < field_deg < 150.0):
        raise CalibrateError("no camera on a chair has that --height, --down or --field")
    if not CAN_DECODE:
        raise CalibrateError("Pillow is not installed; run `pip install 'gazechair[picture]'`")
    width_px, height_px = _size(picture)
    focal_px = 0.5 * width_px / math.tan(math.radians(0.5 * field_deg))
    start = FloorCamera(width_px, height_px, focal_px, height_m, math.radians(down_deg))
    taps = _marks(marks)
    found = calibrate(start, taps)
    if isinstance(found, Refused):
        tap = "" if found.worst is None else f" (mark {found.worst + 1})"
        raise CalibrateError(f"{WHY[found.reason]}{tap}; what was stored before stays")
    _store(config).keep(found)
    say(f"stored: {_words(found)}")


def _store(config: Config) -> FloorStore:
    return FloorStore(state_folder(config.web.state_folder))


def _words(known: Calibration) -> str:
    camera = known.camera
    return (
        f"pictures of {camera.width_px} x {camera.height_px}, camera {camera.height_m:.2f} m high, "
        f"{math.degrees(camera.pitch_rad):.1f} degrees down, {camera.x_m:.2f} m before the axle; "
        f"marks disagree by {100.0 * known.residual_m:.1f} cm 2 m ahead"
    )


def _size(picture: Path) -> tuple[int, int]:
    try:
        found = size_px(picture.read_bytes())
    except OSError as error:
        raise CalibrateError(f"{picture} cannot be read: {error}") from None
    if found is None:
        raise CalibrateError(f"{picture} is no JPEG")
    return found


def _marks(path: Path) -> list[Tap]:
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise CalibrateError(f"{path} cannot be read: {error}") from None
    taps = []
    for number, line in enumerate(lines, 1):
        text = line.partition("#")[0].strip()
        if not text:
            continue
        try:
            u, v, x_m, y_m = (float(part) for part in text.replace(",", " ").split())
        except ValueError:
            raise CalibrateError(f"{path}, line {number}: not four numbers: {text}") from None
        if not all(map(math.isfinite, (u, v, x_m, y_m))):
            raise CalibrateError(f"{path}, line {number}: a number that is none: {text}")
        taps.append(Tap((u, v), (x_m, y_m)))
    return taps
