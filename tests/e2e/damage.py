"""What can happen to frames on their way, by name. Seeded: the same damage every time."""

from __future__ import annotations

import random

from gazesim.usb_line import Mangle


def frames(chunk: bytes) -> list[bytes]:
    """The frames in a chunk, each with its delimiter."""
    return [piece + b"\0" for piece in chunk.split(b"\0")[:-1]]


class Damage:
    """Damages a share of the frames in one way."""

    def __init__(self, kind: str, share: float, seed: int = 1) -> None:
        self._random = random.Random(seed)
        self._share = share
        self._do = getattr(self, f"_{kind}")
        self._kept: list[bytes] = []
        self.count = 0

    def __call__(self, chunk: bytes) -> list[bytes]:
        """As cable.Mangle."""
        out: list[bytes] = []
        for frame in frames(chunk):
            if self._random.random() < self._share:
                self.count += 1
                out += self._do(frame)
            else:
                out.append(frame)
            self._kept = [*self._kept[-200:], frame]
        return out

    def _corrupt(self, frame: bytes) -> list[bytes]:
        spoilt = bytearray(frame)
        for _ in range(self._random.randrange(1, 4)):
            spoilt[self._random.randrange(len(spoilt))] ^= self._random.randrange(1, 256)
        return [bytes(spoilt)]

    def _drop(self, frame: bytes) -> list[bytes]:
        return []

    def _duplicate(self, frame: bytes) -> list[bytes]:
        return [frame, frame]

    def _truncate(self, frame: bytes) -> list[bytes]:
        return [frame[: self._random.randrange(len(frame))]]

    def _reorder(self, frame: bytes) -> list[bytes]:
        older = self._random.choice(self._kept) if self._kept else b""
        return [frame, older]  # an old one overtaken by this one

    def _replay(self, frame: bytes) -> list[bytes]:
        return [frame, *self._kept[-60:]] if self.count % 8 == 0 else [frame]

    def _garbage(self, frame: bytes) -> list[bytes]:
        return [self._random.randbytes(self._random.randrange(1, 90)), frame]


KINDS = ("corrupt", "drop", "duplicate", "truncate", "reorder", "replay", "garbage")


def damage(kind: str, share: float, seed: int = 1) -> Mangle:
    """A mangle for one lane."""
    return Damage(kind, share, seed)
