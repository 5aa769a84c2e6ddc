"""What the daemon tells assist's process: one line with everything newest."""

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
    """What is so at this moment."""

    on: bool = False
    """The present driver wants assist: what the lidars see is looked at."""
    press: int = 0
    """The board's number of the driver's held Vooruit, 0: not held."""
    turns: int = 0
    """The driver holds a turn: 1 left, -1 right."""
    zone: BoardZone = NOT_KNOWN
    clearance: Clearance | None = None
    """The newest that the board was sent."""


def packed(word: Word) -> bytes:
    """As one line, without its end."""
    clearance = word.clearance
    fields = [word.on, word.press, word.turns, [one.hex() for one in word.zone.points]]
    if clearance is not None:
        fields.append([getattr(clearance, name) for name in _FIELDS] + [list(clearance.arcs)])
    return json.dumps(fields).encode()


def unpacked(line: bytes) -> tuple[Word, StopZone]:
    """What it says. Raises ValueError for nonsense."""
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
