"""Reads the log's files from start to end; a truncated file is readable up to the cut."""

from __future__ import annotations

import contextlib
import struct
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk, get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC
from mcap_ros2.decoder import DecoderFactory
from zstandard import ZstdError

from gazechair.base.user_error import UserError

_LONGEST = 64 << 20  # bytes of a record; a larger length is damaged
_DAMAGED = (McapError, ZstdError, struct.error, ValueError, KeyError, MemoryError)


@dataclass(frozen=True)
class Line:
    """One message of a file."""

    at_ns: int
    """Wall time."""
    topic: str
    type_name: str
    data: bytes
    """As CDR; decoded by `message`."""
    schema: Schema
    decoders: DecoderFactory

    @property
    def message(self) -> Any:
        """Its fields, as attributes. Raises UserError."""
        try:
            decoder = self.decoders.decoder_for("cdr", self.schema)
            assert decoder is not None
            return decoder(self.data)
        except _DAMAGED as error:
            raise UserError(
                f"a message of {self.topic} cannot be read, as another program wrote it ({error})"
            ) from None


@contextlib.contextmanager
def of_this_version(path: Path) -> Iterator[None]:
    """Raise UserError for a message without a field that is read here."""
    try:
        yield
    except AttributeError as error:
        if not isinstance(error.obj, SimpleNamespace):
            raise
        lacks = f"{type(error.obj).__name__} has no {error.name}"
        raise UserError(f"{path} is of another version: its {lacks}") from None


class LogFile:
    """One file, read in the order in which it was written."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.whole = False
        """After reading: it ends as a finished file does."""
        self._read = 0  # bytes
        self._latest_ns = 0

    def lines(self) -> Iterator[Line]:
        """All messages of ROS 2 up to the end, or the cut. Raises OSError only."""
        schemas: dict[int, Schema] = {}
        channels: dict[int, Channel] = {}
        decoders = DecoderFactory()
        self._latest_ns = 0
        for record in self._records(breakup_chunk):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Message) and record.channel_id in channels:
                channel = channels[record.channel_id]
                schema = schemas.get(channel.schema_id)
                if channel.message_encoding != "cdr" or not schema or schema.encoding != "ros2msg":
                    continue  # some other program's file
                self._latest_ns = max(self._latest_ns, record.log_time)
                yield Line(
                    record.log_time, channel.topic, schema.name, record.data, schema, decoders
                )

    def length_s(self) -> float:
        """Seconds from the first to the last message; checks each chunk, parses none."""
        first_ns, self._latest_ns = 0, 0
        for record in self._records(_checked):
            if isinstance(record, Chunk):
                begin_ns, end_ns = record.message_start_time, record.message_end_time
            elif isinstance(record, Message):
                begin_ns = end_ns = record.log_time
            else:
                continue
            if end_ns:  # 0: a chunk without messages
                first_ns = min(first_ns or begin_ns, begin_ns)
                self._latest_ns = max(self._latest_ns, end_ns)
        return (self._latest_ns - first_ns) / 1e9

    def ending(self) -> str:
        """After reading: up to where a file is readable that does not end as a finished one does,
        in one sentence; "" for one that does. Raises OSError."""
        if self.whole:
            return ""
        shares = f"{self._read} of {self.path.stat().st_size} bytes"
        till = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(self._latest_ns // 10**9))
        readable = f"readable up to {till} ({shares})" if self._latest_ns else "not readable"
        return (
            f"{self.path.name} is {readable} and ends there:"
            " it is being written, was cut by a power failure, or is damaged"
        )

    def check(self) -> None:
        """Raise UserError when it does not begin as a log does; OSError."""
        with self.path.open("rb") as file:
            if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                raise UserError(f"{self.path} is no log, or nothing has been written to it yet")

    def _records(self, inside: Callable[..., list[McapRecord]]) -> Iterator[McapRecord]:
        self.whole, self._read = False, 0
        with self.path.open("rb") as file:
            stream = StreamReader(file, emit_chunks=True, record_size_limit=_LONGEST)
            try:
                for record in stream.records:
                    if isinstance(record, Chunk):
                        yield from inside(record, validate_crc=True)
                    else:
                        yield record
                    self._read = file.tell()
                self.whole = True
            except _DAMAGED:
                return


def _checked(chunk: Chunk, validate_crc: bool) -> list[McapRecord]:
    """The chunk itself, once its content is known to be undamaged."""
    get_chunk_data_stream(chunk, validate_crc)
    return [chunk]
