"""Reduces pictures for slow links, with Pillow when it is installed; each at most once."""

from __future__ import annotations

import contextlib
import importlib
import io
import logging
import threading
from dataclasses import dataclass
from typing import Any

from gazechair.picture.camera import Frame

Image: Any = None
with contextlib.suppress(ImportError):  # the extra "picture" need not be installed
    Image = importlib.import_module("PIL.Image")

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Level:
    """A picture size: at most `width` pixels wide, with this JPEG quality, 1..95."""

    width: int
    quality: int


# From the smallest; above the last one the picture is sent unchanged.
LEVELS = (Level(240, 30), Level(320, 35), Level(480, 40), Level(640, 50), Level(960, 60))


class Reducer:
    """Provides the newest picture at each level; each is made once for all viewers."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._frame: Frame | None = None
        self._made: dict[int, bytes] = {}
        if Image is None:
            log.info("pictures go as the camera makes them: gazechair[picture] is not installed")

    @property
    def top(self) -> int:
        """Highest level, the unchanged picture; 0 when pictures can't be reduced."""
        return 0 if Image is None else len(LEVELS)

    def reduced(self, frame: Frame, level: int) -> bytes:
        """The JPEG of `frame` at `level`, 0..top; never larger than the frame itself."""
        if level >= self.top:
            return frame.jpeg
        with self._lock:
            if self._frame is not frame:
                self._frame = frame
                self._made = {}
            if level not in self._made:
                self._made[level] = _smaller(frame.jpeg, LEVELS[level])
            return self._made[level]


def _smaller(jpeg: bytes, level: Level) -> bytes:
    try:
        picture: Any = Image.open(io.BytesIO(jpeg), formats=("JPEG",))
        width = min(level.width, picture.width)
        size = (width, max(1, round(width * picture.height / picture.width)))
        picture.draft("RGB", size)  # decodes at a half, a quarter ... when that is enough
        picture = picture.convert("RGB").resize(size, Image.Resampling.BILINEAR)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return jpeg  # the page reports that it can't read the picture
    out = io.BytesIO()
    picture.save(out, "JPEG", quality=level.quality)
    made = out.getvalue()
    return made if len(made) < len(jpeg) else jpeg
