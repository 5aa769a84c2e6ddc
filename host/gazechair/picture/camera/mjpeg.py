"""Cuts an MJPEG stream (multipart/x-mixed-replace) into pictures. Pure, bounded, no I/O."""

from __future__ import annotations

import re
from dataclasses import dataclass

MAX_JPEG = 512 * 1024
_MAX_HEADERS = 4096
_SOI = b"\xff\xd8"
_EOI = b"\xff\xd9"


class NotMjpeg(ValueError):
    """The stream is not MJPEG; the text gives the reason in one line."""


@dataclass(frozen=True)
class Part:
    """One picture and its headers, names in lower case."""

    headers: dict[str, str]
    jpeg: bytes


def boundary_of(content_type: str) -> bytes:
    """The delimiter line's start, "--" included, from a Content-Type. Raises NotMjpeg."""
    kind = content_type.split(";")[0].strip().lower()
    found = re.search(r'boundary\s*=\s*"?([^";\s]+)"?', content_type, re.IGNORECASE)
    if kind != "multipart/x-mixed-replace" or not found:
        raise NotMjpeg(
            f"sends {kind or 'no content type'}, not multipart/x-mixed-replace: "
            "is it the address of the MJPEG stream itself?"
        )
    # Some cameras write the boundary with its dashes.
    return b"--" + found.group(1).removeprefix("--").encode("latin-1")


def is_jpeg(data: bytes) -> bool:
    """True for a whole JPEG of at most 512 kB, by its first and last two bytes."""
    return len(data) <= MAX_JPEG and data.startswith(_SOI) and data.endswith(_EOI)


class MjpegParser:
    """Feed it the body as it arrives; it keeps at most one unfinished part.

    `bad` counts parts that were not a whole JPEG. With a Content-Length a part ends there, without
    one at the next boundary.
    """

    def __init__(self, boundary: bytes) -> None:
        self.bad = 0
        self._boundary = boundary
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[Part]:
        """The pictures completed by `data`. Raises NotMjpeg when a part outgrows every bound."""
        self._buffer += data
        parts = []
        while True:
            taken = self._take()
            if taken is None:
                break
            if is_jpeg(taken.jpeg):
                parts.append(taken)
            else:
                self.bad += 1
        return parts

    def _take(self) -> Part | None:
        start = self._buffer.find(self._boundary)
        if start < 0:
            # Keep bytes that may be the beginning of a boundary.
            del self._buffer[: max(0, len(self._buffer) - len(self._boundary))]
            return None
        del self._buffer[:start]
        head_end = self._buffer.find(b"\r\n\r\n", len(self._boundary))
        if head_end < 0:
            if len(self._buffer) > _MAX_HEADERS:
                raise NotMjpeg("sends a part whose headers do not end")
            return None
        headers = _headers(bytes(self._buffer[len(self._boundary) : head_end]))
        body = head_end + 4
        length = headers.get("content-length", "")
        if length.isascii() and length.isdigit() and 0 < int(length) <= MAX_JPEG:
            end = after = body + int(length)
            if len(self._buffer) < end:
                return None
        else:
            after = self._buffer.find(b"\r\n" + self._boundary, body)
            if after < 0:
                if len(self._buffer) - body > MAX_JPEG + len(self._boundary):
                    raise NotMjpeg(f"sends a picture of more than {MAX_JPEG // 1024} kB")
                return None
            end = after
        jpeg = bytes(self._buffer[body:end])
        del self._buffer[:after]
        return Part(headers, jpeg)


def _headers(block: bytes) -> dict[str, str]:
    headers = {}
    for line in block.decode("latin-1").split("\r\n"):
        name, colon, value = line.partition(":")
        if colon:
            headers[name.strip().lower()] = value.strip()
    return headers
