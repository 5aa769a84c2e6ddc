"""The camera: a child process that reads the stream and delivers its newest picture."""

from gazechair.picture.camera.record import Frame
from gazechair.picture.camera.service import CameraService

__all__ = ["CameraService", "Frame"]
