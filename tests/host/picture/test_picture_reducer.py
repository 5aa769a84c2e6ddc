"""Reduced pictures: smaller, readable, made once; unreadable ones are sent unchanged."""

from __future__ import annotations

import io

from PIL import Image

from gazechair.picture.camera import Frame
from gazechair.picture.reducer import LEVELS, Reducer


def picture(width: int = 640, height: int = 480, quality: int = 85) -> Frame:
    image = Image.effect_noise((width, height), 60).convert("RGB")
    out = io.BytesIO()
    image.save(out, "JPEG", quality=quality)
    return Frame(out.getvalue(), 1.0)


def test_each_level_is_a_whole_picture_and_larger_than_the_one_below() -> None:
    frame, reducer = picture(1280, 720), Reducer()
    sizes = []
    for at, level in enumerate(LEVELS):
        jpeg = reducer.reduced(frame, at)
        image = Image.open(io.BytesIO(jpeg))
        image.load()
        assert image.size == (level.width, round(level.width * 720 / 1280))
        sizes.append(len(jpeg))
    assert sizes == sorted(sizes)
    assert reducer.reduced(frame, reducer.top) is frame.jpeg


def test_a_small_picture_is_never_blown_up() -> None:
    frame, reducer = picture(200, 150, quality=20), Reducer()
    for level in range(reducer.top):
        made = reducer.reduced(frame, level)
        assert len(made) <= len(frame.jpeg)
        assert Image.open(io.BytesIO(made)).width == 200


def test_the_same_frame_is_reduced_once() -> None:
    frame, reducer = picture(), Reducer()
    assert reducer.reduced(frame, 1) is reducer.reduced(frame, 1)
    assert reducer.reduced(picture(320, 240), 1) != reducer.reduced(frame, 1)


def test_what_is_no_picture_goes_as_it_is() -> None:
    frame = Frame(b"\xff\xd8 not a picture \xff\xd9", 1.0)
    assert Reducer().reduced(frame, 0) is frame.jpeg
