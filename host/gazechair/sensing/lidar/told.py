"""The daemon's message to the lidars' child process: the board's stop zone, as one line."""

from __future__ import annotations

import json
import logging

from gazechair.board.zone import BoardZone
from gazechair.sensing.clearance.zone import UNKNOWN, StopZone

log = logging.getLogger(__name__)


def said(zone: BoardZone) -> bytes:
    """`zone` as one line, without the newline."""
    return json.dumps([one.hex() for one in zone.points]).encode()


def understood(line: bytes) -> StopZone:
    """The stop zone in `line`; UNKNOWN for a malformed one, which is logged."""
    try:
        points = json.loads(line)
        return StopZone([bytes.fromhex(one) for one in points]) if points else UNKNOWN
    except (ValueError, TypeError) as error:
        log.warning("what the board says about its stopping makes no sense: %s", error)
        return UNKNOWN
