"""The simulated camera: the rendered view of the room from the chair."""

from __future__ import annotations

import io
from collections.abc import Callable

from PIL import Image

from gazesim.mjpeg_server import MjpegServer
from gazesim.render import HEIGHT, WIDTH, Renderer
from gazesim.rooms import Room

_QUALITY = 80

# The scene now: the room, and the chair's pose (x m, y m, heading deg).
Scene = Callable[[], tuple[Room, tuple[float, float, float]]]


class Camera(MjpegServer):
    """Serves `scene` as a network camera does."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._renderer = Renderer()
        super().__init__(self._render)

    def _render(self) -> bytes:
        room, pose = self._scene()
        picture = self._renderer.render(room, *pose)
        jpeg = io.BytesIO()
        size = (WIDTH, HEIGHT)
        Image.frombuffer("RGBX", size, picture, "raw", "RGBX", 0, 1).save(
            jpeg, "JPEG", quality=_QUALITY
        )
        return jpeg.getvalue()
