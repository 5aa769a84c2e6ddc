"""The daemon's message to assist's process: one line with all newest values."""

from __future__ import annotations

import json
from dataclasses import dataclass

from gazechair.board.board_commands import Clearance
from gazechair.board.zone import NOT_KNOWN, BoardZone
from gazechair.sensing.clearance.zone import UNKNOWN, StopZone

_FIELDS = (
    "blocked",
    "source",
    "acquired_s",
    "unseen",
    "forward_mm",
    "backward_mm",
    "left_q4_deg",
    "right_q4_deg",
    "arc_views",
)


@dataclass(frozen=True)
class Word:
    """The newest values."""

    on: bool = False
    """The present driver wants assist; else the process ignores the lidars."""
    press: int = 0
    """The board's number of the driver's press on Vooruit; 0: not pressed."""
    turns: int = 0
    """The driver holds a turn: 1 left, -1 right."""
    zone: BoardZone = NOT_KNOWN
    clearance: Clearance | None = None
    """The newest that was sent to the board."""


def packed(word: Word) -> bytes:
    """`word` as one line, without the newline."""
    clearance = word.clearance
    fields = [word.on, word.press, word.turns, [one.hex() for one in word.zone.points]]
    if clearance is not None:
        fields.append([getattr(clearance, name) for name in _FIELDS] + [list(clearance.arcs)])
    return json.dumps(fields).encode()


def unpacked(line: bytes) -> tuple[Word, StopZone]:
    """The word in `line`, and the stop zone in it. Raises ValueError for a malformed line."""
    try:
        on, press, turns, zone, *rest = json.loads(line)
        points = tuple(bytes.fromhex(one) for one in zone)
        clearance = None
        if rest:
            *values, arcs = rest[0]
            clearance = Clearance(**dict(zip(_FIELDS, values, strict=True)), arcs=arcs)
        word = Word(bool(on), int(press), int(turns), BoardZone(points), clearance)
        return word, StopZone(points) if points else UNKNOWN
    except (TypeError, KeyError) as error:
        raise ValueError(f"no word for assist: {error!r}") from None
