"""The daemon's message to assist's process: one line with all newest values."""

from __future__ import annotations

import json
from dataclasses import dataclass

from gazechair.base import json_text
from gazechair.board.board_commands import Clearance
from gazechair.board.zone import NOT_KNOWN, BoardZone
from gazechair.sensing.clearance.zone import StopZone, from_hex, to_hex

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
class Message:
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


def pack(message: Message) -> bytes:
    """`message` as one line, without the newline."""
    clearance = message.clearance
    fields = [message.on, message.press, message.turns, to_hex(message.zone)]
    if clearance is not None:
        fields.append([getattr(clearance, name) for name in _FIELDS] + [list(clearance.arcs)])
    return json.dumps(fields).encode()


def unpack(line: bytes) -> tuple[Message, StopZone]:
    """The message in `line`, and the stop zone in it. Raises ValueError for a malformed line."""
    try:
        on, press, turns, points, *rest = json_text.parse(line)
        zone, stop_zone = from_hex(points)
        clearance = None
        if rest:
            *values, arcs = rest[0]
            clearance = Clearance(**dict(zip(_FIELDS, values, strict=True)), arcs=arcs)
        return Message(bool(on), int(press), int(turns), zone, clearance), stop_zone
    except (TypeError, KeyError) as error:
        raise ValueError(f"no message for assist: {error!r}") from None
