"""A camera whose pictures contain their time, readable after every reduction.

A row of black and white fields along the upper edge: the wall clock's ms modulo 2**16, highest bit
first, between a white and a black field that show the levels, and a parity field.
"""

from __future__ import annotations

import io
import time

from PIL import Image, ImageDraw

from gazesim.mjpeg_server import MjpegServer

WIDTH, HEIGHT = 640, 480
BITS = 16
FIELDS = BITS + 3  # white, black, the bits, parity
FIELD_HEIGHT = 32
_QUALITY = 80
_GRAIN = 9  # makes a picture of some 40 kB, as a real room does

# Page's function: ms modulo 2**16 of a picture (an ImageBitmap or canvas), null when unreadable.
READ = f"""(picture) => {{
  const width = {FIELDS}, canvas = new OffscreenCanvas(width, 1);
  const paint = canvas.getContext("2d", {{willReadFrequently: true}});
  const field = picture.width / width, high = picture.height * {FIELD_HEIGHT} / {HEIGHT};
  for (let at = 0; at < width; at++) {{
    paint.drawImage(picture, (at + 0.4) * field, high * 0.4, field * 0.2, high * 0.2, at, 0, 1, 1);
  }}
  const data = paint.getImageData(0, 0, width, 1).data;
  const light = Array.from({{length: width}}, (_, at) => data[4 * at + 1]);
  if (light[0] - light[1] < 100) return null;
  const middle = (light[0] + light[1]) / 2;
  let value = 0, parity = 0;
  for (let at = 2; at < width; at++) {{
    const bit = light[at] > middle ? 1 : 0;
    parity ^= bit;
    if (at < width - 1) value = 2 * value + bit;
  }}
  return parity === 0 ? value : null;
}}"""


class StampedCamera(MjpegServer):
    """640x480 pictures, ten a second."""

    def __init__(self) -> None:
        room = Image.effect_noise((WIDTH // 2, HEIGHT // 2), _GRAIN).resize((WIDTH, HEIGHT))
        self._room = Image.merge("RGB", (room, room.rotate(180), room))
        super().__init__(self.stamped)

    def stamped(self) -> bytes:
        """A picture with the present time."""
        stamp = round(time.time() * 1000) & 0xFFFF
        picture = self._room.copy()
        bits = [stamp >> (BITS - 1 - at) & 1 for at in range(BITS)]
        fields = [1, 0, *bits, sum(bits) & 1]
        paint = ImageDraw.Draw(picture)
        for at, field in enumerate(fields):
            edges = (round(at * WIDTH / FIELDS), 0, round((at + 1) * WIDTH / FIELDS), FIELD_HEIGHT)
            paint.rectangle(edges, fill="white" if field else "black")
        jpeg = io.BytesIO()
        picture.save(jpeg, "JPEG", quality=_QUALITY)
        return jpeg.getvalue()
