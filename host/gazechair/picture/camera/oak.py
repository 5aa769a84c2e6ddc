"""A Luxonis OAK camera: JPEGs from its own encoder (extra "oak", depthai 3)."""

from __future__ import annotations

import importlib
import time
from typing import Any

from gazechair.base.latest_value import Latest
from gazechair.picture.camera import SILENT_S, CameraError
from gazechair.picture.camera.mjpeg import is_jpeg
from gazechair.picture.camera.record import Frame

_POLL_S = 0.005


def read(width: int, height: int, rate_hz: int, newest: Latest[Frame]) -> None:
    """Put each picture into `newest` until the camera fails (CameraError)."""
    try:
        dai = importlib.import_module("depthai")
    except ImportError as error:
        raise CameraError('an OAK camera needs depthai: pip install "gazechair[oak]"') from error
    try:
        with dai.Pipeline() as pipeline:
            queue = _encoded(dai, pipeline, width, height, rate_hz)
            pipeline.start()
            _copy(pipeline, queue, newest)
    except RuntimeError as error:  # depthai raises this for every failure
        raise CameraError(f"the OAK camera fails: {str(error).splitlines()[0]}") from error


def _encoded(dai: Any, pipeline: Any, width: int, height: int, rate_hz: int) -> Any:
    camera = pipeline.create(dai.node.Camera).build(dai.CameraBoardSocket.CAM_A)
    raw = camera.requestOutput((width, height), dai.ImgFrame.Type.NV12, fps=float(rate_hz))
    encoder = pipeline.create(dai.node.VideoEncoder).build(
        raw, frameRate=float(rate_hz), profile=dai.VideoEncoderProperties.Profile.MJPEG
    )
    return encoder.bitstream.createOutputQueue(maxSize=1, blocking=False)


def _copy(pipeline: Any, queue: Any, newest: Latest[Frame]) -> None:
    good_s = time.monotonic()
    while pipeline.isRunning():
        packet = queue.tryGet()
        now_s = time.monotonic()
        if packet is None:
            if now_s - good_s > SILENT_S:
                raise CameraError("the OAK camera sends nothing; plug it in again")
            time.sleep(_POLL_S)
            continue
        jpeg = bytes(packet.getData())
        if is_jpeg(jpeg):
            good_s = now_s
            # Its time stamp is already in the host's monotonic clock.
            newest.put(Frame(jpeg, min(now_s, packet.getTimestamp().total_seconds())))
    raise CameraError("the OAK camera has stopped")
