"""The newest picture for other processes: complete or none, with its time, without waiting."""

from __future__ import annotations

import os
import threading

import pytest

from gazechair.picture.camera.mjpeg import MAX_JPEG
from gazechair.picture.newest import LatestPicture, PictureReader, Shot


def picture(number: int, size: int = 30_000) -> bytes:
    return bytes([number % 251]) * size


def test_the_newest_alone_once_and_with_its_time() -> None:
    slot = LatestPicture()
    reader, late = PictureReader(slot.fd), PictureReader(slot.fd)
    assert reader.take() is None
    for number in range(1, 6):
        slot.put(picture(number), 100.0 + number)
        assert reader.take() == Shot(picture(number), 100.0 + number)
        assert reader.take() is None
    assert late.take() == Shot(picture(5), 105.0)  # a slow reader loses pictures, but no time
    slot.close()


def test_too_large_is_none_and_the_one_before_stays() -> None:
    slot = LatestPicture()
    reader = PictureReader(slot.fd)
    slot.put(picture(1), 1.0)
    slot.put(bytes(MAX_JPEG + 1), 2.0)
    assert reader.take() == Shot(picture(1), 1.0)
    slot.put(bytes(MAX_JPEG), 3.0)
    assert reader.take() == Shot(bytes(MAX_JPEG), 3.0)


def test_who_reads_cannot_write() -> None:
    slot = LatestPicture()
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.pwrite(slot.fd, b"x", 0)


def test_no_picture_is_ever_half_another_one() -> None:
    slot = LatestPicture()
    done = threading.Event()

    def write() -> None:
        number = 0
        while not done.is_set():
            number += 1
            slot.put(picture(number, 20_000 + 37 * number % 50_000), float(number))

    writer = threading.Thread(target=write)
    writer.start()
    reader = PictureReader(slot.fd)
    seen, tries = 0, 0
    newest_s = 0.0
    while seen < 200 and tries < 100_000:
        tries += 1
        shot = reader.take()
        if shot is not None:
            seen += 1
            number = round(shot.acquired_s)
            assert shot.jpeg == picture(number, 20_000 + 37 * number % 50_000)
            assert shot.acquired_s > newest_s
            newest_s = shot.acquired_s
    done.set()
    writer.join()
    assert seen > 0
