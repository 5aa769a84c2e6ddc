"""`gazechair calibrate camera`: finds the camera's pose over the floor from marks in its picture.

A person measures marks on the floor with a tape, from below the middle of the drive axle, and finds
them in a picture taken by this command. An impossible result is refused with the reason.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from gazechair.base.health import Health
from gazechair.base.output_file import write_output
from gazechair.base.state_folder import state_folder
from gazechair.commissioning.calibrate.errors import CalibrateError
from gazechair.commissioning.calibrate.marks import ByEye, from_marks
from gazechair.config.settings import Config
from gazechair.picture.camera import CameraService
from gazechair.picture.floor_calibration import Calibration, Tap
from gazechair.picture.floor_store import FloorStore
from gazechair.picture.pixels import CAN_DECODE, size_px

_PICTURE_S = 15.0

Say = Callable[[str], None]


def show(config: Config, say: Say) -> None:
    """Print the stored calibration."""
    known = _store(config).get()
    say(_text_of(known) if known else "the camera is not calibrated: no line is followed by it")


def take_picture(config: Config, path: Path, say: Say) -> None:
    """Save the camera's picture. Raises UserError."""
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
    write_output(path, entry.value.jpeg)
    say(f"saved {path}; find the marks in it, write a file with a line for each:")
    say("pixels from the left, pixels from the top, metres forward, metres to the left")
    say(f"then: gazechair calibrate camera --picture {path} --marks FILE")


def store(config: Config, picture: Path, marks: Path, eye: ByEye, say: Say) -> None:
    """Fit the marks and store the result. Raises CalibrateError."""
    if not CAN_DECODE:
        raise CalibrateError("Pillow is not installed; run `pip install 'gazechair[picture]'`")
    found = from_marks(_size(picture), eye, _marks(marks))
    try:
        _store(config).keep(found)
    except OSError as error:
        raise CalibrateError(f"it was not stored ({error})") from None
    say(f"stored: {_text_of(found)}")


def _store(config: Config) -> FloorStore:
    return FloorStore(state_folder(config.web.state_folder))


def _text_of(known: Calibration) -> str:
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
        lines = path.read_text(encoding="utf-8-sig").splitlines()
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
