"""The camera: a child process that reads the stream and delivers its newest picture."""

from gazechair.picture.camera.record import Frame
from gazechair.picture.camera.service import CameraService

__all__ = ["SILENT_S", "CameraError", "CameraService", "Frame"]

SILENT_S = 3.0
"""A camera without a picture for longer than this has failed."""


class CameraError(Exception):
    """Raised when a camera cannot be opened or read; the text is one plain line."""
