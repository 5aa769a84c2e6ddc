"""The camera's child process: reads the camera and forwards only its newest picture."""

from __future__ import annotations

import json
import sys
import threading
from typing import Any

from gazechair.base.child_main import enter_child
from gazechair.base.child_records import RecordWriter
from gazechair.base.latest_value import Latest
from gazechair.picture.camera import CameraError, http_stream, oak, usb
from gazechair.picture.camera.record import LOST, STARTING, Frame


def read(argument: dict[str, Any], newest: Latest[Frame]) -> None:
    """Put each picture into `newest` until the camera fails (CameraError)."""
    size = (argument["width"], argument["height"], argument["rate_hz"])
    if argument["kind"] == "usb":
        usb.read(argument["device"], *size, newest)
    elif argument["kind"] == "oak":
        oak.read(*size, newest)
    else:
        http_stream.read(argument["url"], newest)


def _hand_on(newest: Latest[Frame], out: RecordWriter, failed: threading.Event) -> None:
    """Write the newest record whenever there is one; a slow parent skips pictures."""
    version = 0
    while not failed.is_set():
        entry = newest.wait(0.5, version)
        if entry is not None:
            version = entry.version
            try:
                out.data(entry.value.pack())
            except BrokenPipeError:
                return


def main() -> int:
    """Entry of `python -m gazechair.picture.camera.child JSON`: the camera's settings by name."""
    argument = json.loads(sys.argv[1])
    out = enter_child()
    out.status("starting", STARTING, "connecting to the camera")
    newest: Latest[Frame] = Latest()
    failed = threading.Event()
    writer = threading.Thread(
        target=_hand_on, args=(newest, out, failed), name="camera-writer", daemon=True
    )
    writer.start()
    try:
        read(argument, newest)
    except CameraError as error:
        failed.set()
        writer.join(2.0)
        out.status("lost", LOST, str(error))
    return 1


if __name__ == "__main__":
    sys.exit(main())
