"""The picture socket: one frame in flight, the newest next, nothing old."""

from __future__ import annotations

import struct
import time
from typing import Any

from gazechair.base.latest_value import Latest
from gazechair.picture.camera import Frame


def frame(tag: bytes, age_s: float = 0.0) -> Frame:
    return Frame(b"\xff\xd8" + tag + b"\xff\xd9", time.monotonic() - age_s)


def shown(raw: bytes) -> tuple[int, int, bytes]:
    sequence, age_ms = struct.unpack_from("<II", raw)
    return sequence, age_ms, raw[8:]


def test_the_next_picture_waits_for_the_acknowledgement_and_is_the_newest(
    video: Latest[Frame], open_page: Any
) -> None:
    page = open_page("/ws/video")
    video.put(frame(b"one"))
    sequence, age_ms, jpeg = shown(page.next())
    assert (sequence, jpeg) == (1, b"\xff\xd8one\xff\xd9")
    assert age_ms < 1000
    video.put(frame(b"two"))
    video.put(frame(b"three"))
    assert page.ws.receive(0.3) is None
    page.send("1")
    assert shown(page.next())[::2] == (2, b"\xff\xd8three\xff\xd9")


def test_the_age_counts_from_acquisition(video: Latest[Frame], open_page: Any) -> None:
    page = open_page("/ws/video")
    video.put(frame(b"old", age_s=0.4))
    assert shown(page.next())[1] >= 400


def test_a_picture_too_old_to_help_is_not_sent(video: Latest[Frame], open_page: Any) -> None:
    page = open_page("/ws/video")
    video.put(frame(b"ancient", age_s=5.0))
    assert page.ws.receive(0.3) is None


def test_a_wrong_acknowledgement_closes_the_socket(video: Latest[Frame], open_page: Any) -> None:
    page = open_page("/ws/video")
    page.send("99")
    assert page.until_closed()[0] == 1003
