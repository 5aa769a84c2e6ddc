"""Cutting an MJPEG stream into pictures: whole ones come out, nothing is kept without bound."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.picture.camera.http_stream import acquired_s
from gazechair.picture.camera.mjpeg import (
    MAX_JPEG,
    MjpegParser,
    NotMjpeg,
    Part,
    boundary_of,
    is_jpeg,
)

BOUNDARY = b"--frame"


def jpeg(tag: bytes = b"x") -> bytes:
    return b"\xff\xd8" + tag + b"\xff\xd9"


def part(body: bytes, *, length: bool = True, extra: bytes = b"") -> bytes:
    sized = b"Content-Length: %d\r\n" % len(body) if length else b""
    return BOUNDARY + b"\r\nContent-Type: image/jpeg\r\n" + sized + extra + b"\r\n" + body + b"\r\n"


def pictures(data: bytes, size: int = 1 << 20) -> list[bytes]:
    parser = MjpegParser(BOUNDARY)
    cut = [data[i : i + size] for i in range(0, len(data), size)]
    return [found.jpeg for piece in cut for found in parser.feed(piece)]


@settings(deadline=None)
@given(st.integers(1, 60), st.booleans())
def test_pictures_come_out_however_the_stream_is_cut(size: int, length: bool) -> None:
    stream = b"".join(part(jpeg(bytes([65 + n]) * 30), length=length) for n in range(3))
    found = pictures(stream + BOUNDARY, size)
    assert found == [jpeg(bytes([65 + n]) * 30) for n in range(3)]


def test_a_picture_with_a_length_does_not_wait_for_the_next_boundary() -> None:
    assert pictures(part(jpeg())) == [jpeg()]


def test_headers_come_with_the_picture() -> None:
    (found,) = MjpegParser(BOUNDARY).feed(part(jpeg(), extra=b"X-Timestamp: 12.5\r\n"))
    assert found.headers["x-timestamp"] == "12.5"


def test_a_broken_picture_is_counted_and_the_next_one_comes() -> None:
    parser = MjpegParser(BOUNDARY)
    found = parser.feed(part(b"\xff\xd8 cut off") + part(b"<html>") + part(jpeg(b"ok")))
    assert [p.jpeg for p in found] == [jpeg(b"ok")]
    assert parser.bad == 2


def test_a_wrong_length_costs_one_picture_only() -> None:
    wrong = part(jpeg(b"a" * 50)).replace(b"Content-Length: 54", b"Content-Length: 20")
    assert pictures(wrong + part(jpeg(b"b"))) == [jpeg(b"b")]


def test_more_than_512_kb_is_refused() -> None:
    assert not is_jpeg(jpeg(b"x" * MAX_JPEG))
    with pytest.raises(NotMjpeg, match="512 kB"):
        MjpegParser(BOUNDARY).feed(part(jpeg(b"x" * (MAX_JPEG + 100)), length=False))


def test_headers_without_an_end_are_refused() -> None:
    with pytest.raises(NotMjpeg, match="headers do not end"):
        MjpegParser(BOUNDARY).feed(BOUNDARY + b"x" * 5000)


@settings(deadline=None)
@given(st.lists(st.binary(max_size=400), max_size=20))
def test_any_bytes_are_taken_and_little_is_kept(pieces: list[bytes]) -> None:
    parser = MjpegParser(b"--b")
    for piece in pieces:
        for found in parser.feed(piece):
            assert is_jpeg(found.jpeg)


@pytest.mark.parametrize(
    ("content_type", "boundary"),
    [
        ("multipart/x-mixed-replace; boundary=frame", b"--frame"),
        ("multipart/x-mixed-replace;boundary=--frame", b"--frame"),
        ('multipart/x-mixed-replace; boundary="ab"', b"--ab"),
        ("text/html", None),
        ("image/jpeg", None),
        ("multipart/x-mixed-replace", None),
        ("", None),
    ],
)
def test_the_boundary_is_read_from_the_content_type(
    content_type: str, boundary: bytes | None
) -> None:
    if boundary is None:
        with pytest.raises(NotMjpeg, match="MJPEG stream itself"):
            boundary_of(content_type)
    else:
        assert boundary_of(content_type) == boundary


@pytest.mark.parametrize(
    ("stamp", "taken_s"),
    [
        ("99.5", 99.5),
        ("100.0", 100.0),
        ("100.1", 100.0),
        ("1", 100.0),
        ("nan", 100.0),
        ("x", 100.0),
    ],
)
def test_a_timestamp_counts_only_when_it_is_this_machine_s_clock(
    stamp: str, taken_s: float
) -> None:
    assert acquired_s(Part({"x-timestamp": stamp}, b""), arrived_s=100.0) == taken_s
    assert acquired_s(Part({}, b""), arrived_s=100.0) == 100.0
