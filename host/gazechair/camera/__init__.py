"""The camera: a child process that reads the stream, and its newest picture."""

from gazechair.camera.service import CameraService, Frame

__all__ = ["CameraService", "Frame"]
