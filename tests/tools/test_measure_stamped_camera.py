"""The benchmark's pictures: their stamp is read by the page's own code after every reduction."""

from __future__ import annotations

import base64
import io
import time
from collections.abc import Iterator

import pytest
from PIL import Image
from playwright.sync_api import Browser

from gazechair.picture import Reducer
from gazechair.picture.camera import Frame
from gazemeasure.page.stamped_camera import READ, StampedCamera

_DECODE = """async ([read, jpeg]) => {
  const bytes = Uint8Array.from(atob(jpeg), (c) => c.charCodeAt(0));
  return eval(read)(await createImageBitmap(new Blob([bytes], {type: "image/jpeg"})));
}"""


@pytest.fixture
def camera() -> Iterator[StampedCamera]:
    camera = StampedCamera()
    camera.start()
    yield camera
    camera.stop()


@pytest.mark.browser
def test_the_stamp_survives_every_level(camera: StampedCamera, chromium: Browser) -> None:
    reducer = Reducer()
    page = chromium.new_page()
    for level in range(reducer.top + 1):
        before = round(time.time() * 1000)
        jpeg = camera.stamped()
        after = round(time.time() * 1000)
        reduced = base64.b64encode(reducer.reduced(Frame(jpeg, 0.0), level)).decode()
        stamp = page.evaluate(_DECODE, [READ, reduced])
        assert (stamp - before) & 0xFFFF <= after - before, level
    blank = base64.b64encode(_blank()).decode()
    assert page.evaluate(_DECODE, [READ, blank]) is None
    page.close()


def _blank() -> bytes:
    out = io.BytesIO()
    Image.new("RGB", (640, 480), "gray").save(out, "JPEG")
    return out.getvalue()
