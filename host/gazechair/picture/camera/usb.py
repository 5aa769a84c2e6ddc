"""A USB webcam: forwards the camera's own JPEGs."""

from __future__ import annotations

import time
from contextlib import closing
from pathlib import Path

from gazechair.base.latest_value import Latest
from gazechair.picture.camera import SILENT_S, CameraError
from gazechair.picture.camera.huffman import with_tables
from gazechair.picture.camera.mjpeg import is_jpeg
from gazechair.picture.camera.record import Frame
from gazechair.picture.camera.v4l2 import Capture

_WAIT_S = 0.5


def find(folder: Path = Path("/dev")) -> list[str]:
    """The machine's video devices, lowest number first."""
    devices = [path for path in folder.glob("video*") if path.name[5:].isdigit()]
    return [str(path) for path in sorted(devices, key=lambda path: int(path.name[5:]))]


def _open_first(device: str, width: int, height: int, rate_hz: int) -> Capture:
    """`device`, or, if "", the first that provides MJPEG. Raises CameraError."""
    devices = [device] if device else find()
    if not devices:
        raise CameraError("no camera is plugged in (there is no /dev/video...)")
    reasons = []
    for name in devices:
        try:
            return Capture(name, width, height, rate_hz)
        except CameraError as error:
            reasons.append(str(error))
    raise CameraError("; ".join(reasons))


def read(device: str, width: int, height: int, rate_hz: int, newest: Latest[Frame]) -> None:
    """Put each picture into `newest` until the camera fails (CameraError)."""
    with closing(_open_first(device, width, height, rate_hz)) as camera:
        good_s = time.monotonic()
        while True:
            picture = camera.read(_WAIT_S)
            now_s = time.monotonic()
            # Drivers pad the buffer after the end of the picture.
            end = picture.jpeg.rfind(b"\xff\xd9") + 2 if picture is not None else 0
            if picture is not None and is_jpeg(picture.jpeg[:end]):
                good_s = now_s
                taken_s = now_s if picture.taken_s is None else min(picture.taken_s, now_s)
                newest.put(Frame(with_tables(picture.jpeg[:end]), taken_s))
            elif now_s - good_s > SILENT_S:
                raise CameraError(f"{camera.device} sends no whole picture; plug it in again")
