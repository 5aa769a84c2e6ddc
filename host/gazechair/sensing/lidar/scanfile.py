"""Recorded scans: a compact file of a lidar's measurements, safe to read when damaged.

A text line `gazechair-scan 1`, a line of JSON ("period_s": between measurements; the rest is for
people), then records of a quarter turn each, all little-endian: u32 length of the body, u32 CRC-32
of time and body, f64 time in seconds since the start at which the newest measurement came, body.
The body is zlib: for n measurements n x u16 angle and n x u16 distance. Angles are clockwise in
1/64 degree, as differences of differences modulo 65536; distances are mm (0 = no return), as
differences modulo 65536.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from gazechair.base import json_text
from gazechair.base.angles import half_turn_deg
from gazechair.base.arrays import FloatArray, IntArray
from gazechair.sensing.lidar.nodes import Nodes, our_angle

_MAGIC = b"gazechair-scan 1\n"
_RECORD = struct.Struct("<II")
_TIME = struct.Struct("<d")
_MAX_HEADER = 4096
_MAX_BODY = 1 << 16
_MAX_NODES = 1 << 14
_TURN_Q6 = 360 * 64
_LONGEST_GAP_S = 5.0


class ScanFileError(Exception):
    """A scan file can't be used; the text is one plain line: which, where, why, what to do."""


class ScanWriter:
    """Writes a scan file; every record is whole on the disk before the next one begins."""

    def __init__(self, path: Path, header: dict[str, Any]) -> None:
        """`header`: plain JSON values, among them `period_s`, the time between two measurements."""
        try:
            self._file: BinaryIO = path.open("xb")
            self._file.write(_MAGIC + json.dumps(header).encode() + b"\n")
        except FileExistsError:
            raise ScanFileError(f"{path} is there already; give another name") from None
        except OSError as error:
            raise ScanFileError(f"{path} can't be written: {error.strerror}") from None

    def add(self, time_s: float, nodes: Nodes) -> None:
        """Append `nodes`, the newest of them measured `time_s` after the start. Raises OSError."""
        raw_deg = half_turn_deg(-nodes.angles_deg)
        angles = np.round(raw_deg * 64.0).astype(np.int64) % _TURN_Q6
        distances = np.clip(np.round(nodes.distances_m * 1000.0), 0, 65535).astype(np.int64)
        body = zlib.compress(_differences(angles, 2) + _differences(distances, 1))
        time = _TIME.pack(time_s)
        self._file.write(_RECORD.pack(len(body), zlib.crc32(time + body)) + time + body)
        self._file.flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class ScanReader:
    """Reads a scan file. `header`: as it was written."""

    def __init__(self, path: Path) -> None:
        """Raises ScanFileError for another kind of file, and for a damaged header or record."""
        self._path = path
        try:
            self._file: BinaryIO = path.open("rb")
        except OSError as error:
            raise ScanFileError(
                f"scan file {path} can't be read: {error.strerror}; correct lidar.file"
            ) from None
        if self._file.read(len(_MAGIC)) != _MAGIC:
            raise ScanFileError(f"{path} is no scan file; `gazechair lidar record` writes one")
        try:
            self.header: dict[str, Any] = json_text.parse(self._file.readline(_MAX_HEADER))
            self.period_s = float(self.header["period_s"])
            if not 1e-6 < self.period_s < 1.0:
                raise ValueError
        except (ValueError, KeyError, TypeError, OverflowError):
            raise ScanFileError(f"{path}: its header is damaged; record it again") from None
        self._start = self._file.tell()
        if not sum(1 for _ in self._bodies()):
            raise ScanFileError(f"{path} holds no measurements; record it again")

    def records(self) -> Iterator[tuple[float, Nodes]]:
        """(time_s, nodes) from the beginning. Raises ScanFileError for content that cannot be.

        A record cut off at the very end, as by a power cut, is left out.
        """
        last_deg = None
        for time_s, body in self._bodies():
            nodes = _unpack(body, last_deg)
            if nodes is None:
                raise self._damaged("what no measurements pack into")
            last_deg = float(-nodes.angles_deg[-1] % 360.0)
            yield time_s, nodes

    def _bodies(self) -> Iterator[tuple[float, bytes]]:
        self._file.seek(self._start)
        before_s = 0.0
        while len(head := self._file.read(_RECORD.size + _TIME.size)) == _RECORD.size + _TIME.size:
            length, crc = _RECORD.unpack_from(head)
            if not 0 < length <= _MAX_BODY:
                raise self._damaged("a length that can't be")
            body = self._file.read(length)
            if len(body) < length:
                return
            if zlib.crc32(head[_RECORD.size :] + body) != crc:
                raise self._damaged("a wrong checksum")
            (time_s,) = _TIME.unpack_from(head, _RECORD.size)
            if not before_s <= time_s <= before_s + _LONGEST_GAP_S:
                raise self._damaged("times out of order")
            before_s = time_s
            yield time_s, body

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _damaged(self, what: str) -> ScanFileError:
        at = self._file.tell()
        return ScanFileError(
            f"scan file {self._path} is damaged before byte {at}: {what}; record it again"
        )


def _differences(values: IntArray, order: int) -> bytes:
    differences = np.diff(values, order, prepend=np.zeros(order, dtype=np.int64))
    return (differences % 65536).astype("<u2").tobytes()


def _unpack(body: bytes, last_deg: float | None) -> Nodes | None:
    """The nodes of a record, None: impossible; `last_deg`: the lidar's angle before them."""
    try:
        content = zlib.decompressobj().decompress(body, 4 * _MAX_NODES + 1)
    except zlib.error:
        return None
    count = len(content) // 4
    if not count or len(content) != 4 * count or count > _MAX_NODES:
        return None
    values = np.frombuffer(content, dtype="<u2").astype(np.int64)
    raw_deg: FloatArray = np.cumsum(np.cumsum(values[:count])) % 65536 / 64.0 % 360.0
    before = np.concatenate(([raw_deg[0] if last_deg is None else last_deg], raw_deg[:-1]))
    return Nodes(
        angles_deg=our_angle(raw_deg),
        distances_m=np.cumsum(values[count:]) % 65536 / 1000.0,
        starts=raw_deg - before < -180.0,
        backlog=np.arange(count - 1, -1, -1, dtype=np.int64),
    )
