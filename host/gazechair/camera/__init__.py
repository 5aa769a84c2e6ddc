"""The camera: a child process that reads the stream, and its newest picture."""

from gazechair.camera.record import Frame
from gazechair.camera.service import CameraService

__all__ = ["CameraService", "Frame"]
