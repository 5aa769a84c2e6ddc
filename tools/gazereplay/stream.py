"""Reads a board's trace from its frames: the records of gazeboard/io/trace.py."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from gazeboard.io import trace

_U16 = 0xFFFF
_HALF = 0x8000


@dataclass(frozen=True)
class Snapshot:
    """The state of the core after a tick."""

    tick: int
    lost: bool
    """True if what was before is not known."""
    around: int
    words: tuple[int, ...]


@dataclass(frozen=True)
class Inputs:
    """Inputs of the ticks from this one on."""

    tick: int
    words: tuple[int, ...]


@dataclass(frozen=True)
class Around:
    """Contacts, wipers and pace from this tick on, in bits."""

    tick: int
    bits: int


@dataclass(frozen=True)
class Silent:
    """The service loop gave no sign of life between two ticks."""

    tick: int
    until: int


Record = Snapshot | Inputs | Around | Silent


class _Short(Exception):
    """Raised when the record continues in the next frame."""


class Stream:
    """One board's frames in order; after a missing one, yields nothing until the next snapshot."""

    def __init__(self, inputs: int = trace.WORDS) -> None:
        """`inputs`: how many words the inputs of that board have."""
        self._inputs_size = inputs
        self._part: int | None = None
        self._buffer = bytearray()
        self._at = 0
        self._read = False  # in sync with the records
        self._broken = True
        self._tick = 0
        self._inputs = [0] * inputs

    def frame(self, part: int, begins: int, data: bytes) -> Iterator[Record]:
        """The records that are complete with this frame."""
        if part != self._part:
            self._lose()
        self._part = (part + 1) & _U16
        if not self._read:
            if begins == trace.NO_BEGIN:
                return
            self._read = True
            data = data[begins:]
        self._buffer += data
        while self._read and self._buffer:
            self._at = 0
            try:
                record = self._record()
            except _Short:
                return
            except ValueError:
                self._lose()
                return
            del self._buffer[: self._at]
            self._tick = record.tick
            yield record

    def _lose(self) -> None:
        self._buffer.clear()
        self._read = False
        self._broken = True

    def _record(self) -> Record:
        kind = self._byte()
        ticks = self._number()
        if kind == trace.SNAPSHOT:
            ticks |= self._number() << 16
            lost = bool(self._byte()) or self._broken
            around = self._number()
            words = self._words(self._number(), lag=2, old=[])
            self._broken = False
            self._inputs = [0] * self._inputs_size
            return Snapshot(ticks, lost, around, tuple(words))
        if self._broken:
            raise ValueError("no snapshot where one was to begin")
        tick = self._near(ticks)
        if kind == trace.INPUTS:
            words = self._words(self._inputs_size, lag=0, old=self._inputs)
            self._inputs = words
            return Inputs(tick, tuple(words))
        if kind == trace.AROUND:
            return Around(tick, self._number())
        if kind == trace.SILENT:
            return Silent(tick, tick + ((self._number() - tick) & _U16))
        raise ValueError(f"no kind of record: {kind}")

    def _near(self, ticks: int) -> int:
        """The tick nearest to the last one that has these 16 bits."""
        return self._tick + (ticks - self._tick + _HALF & _U16) - _HALF

    def _words(self, count: int, lag: int, old: list[int]) -> list[int]:
        words: list[int] = []
        while len(words) < count:
            coded, shift = 0, 0
            while (byte := self._byte()) & 128:
                coded |= (byte & 127) << shift
                shift += 7
            coded |= byte << shift
            changes = [coded >> 1 ^ -(coded & 1)] if coded else [0] * self._byte()
            for change in changes:
                k = len(words)
                before = words[k - lag] if k >= lag > 0 else 0 if lag or k >= len(old) else old[k]
                words.append(before + change)
        if len(words) > count:
            raise ValueError("more words than there are")
        return words

    def _byte(self) -> int:
        if self._at == len(self._buffer):
            raise _Short
        self._at += 1
        return self._buffer[self._at - 1]

    def _number(self) -> int:
        return self._byte() | self._byte() << 8
