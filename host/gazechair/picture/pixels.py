"""Decodes a JPEG to pixels of a given size, with Pillow, if it is installed."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from gazechair.base.arrays import ByteArray
from gazechair.picture.reducer import Image

CAN_DECODE = Image is not None
"""The extra "picture" is installed."""


def size_px(jpeg: bytes) -> tuple[int, int] | None:
    """Width and height; None: not a JPEG."""
    try:
        picture: Any = Image.open(io.BytesIO(jpeg), formats=("JPEG",))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return None
    return int(picture.width), int(picture.height)


def pixels(jpeg: bytes, size: tuple[int, int]) -> ByteArray | None:
    """(height, width, 3), red, green, blue, for a width and height; None: cannot be decoded."""
    try:
        picture: Any = Image.open(io.BytesIO(jpeg), formats=("JPEG",))
        picture.draft("RGB", (2 * size[0], 2 * size[1]))  # decodes only what is needed
        picture = picture.convert("RGB").resize(size, Image.Resampling.BOX)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return None
    return np.asarray(picture, dtype=np.uint8)
