"""The daemon's message to the lidars' child process: the board's stop zone, as one line."""

from __future__ import annotations

import json
import logging

from gazechair.base import json_text
from gazechair.board.zone import BoardZone
from gazechair.sensing.clearance.zone import UNKNOWN, StopZone, from_hex, to_hex

log = logging.getLogger(__name__)


def pack(zone: BoardZone) -> bytes:
    """`zone` as one line, without the newline."""
    return json.dumps(to_hex(zone)).encode()


def unpack(line: bytes) -> StopZone:
    """The stop zone in `line`; UNKNOWN for a malformed one, which is logged."""
    try:
        return from_hex(json_text.parse(line))[1]
    except (ValueError, TypeError) as error:
        log.warning("what the board says about its stopping makes no sense: %s", error)
        return UNKNOWN
