"""Odometry's child process: reads its inbox, and sends the daemon each estimate."""

from __future__ import annotations

import json
import select
import socket
import sys
import time
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, NoReturn

from gazechair.base.child_main import child_main
from gazechair.base.child_records import RecordWriter
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Lidars
from gazechair.sensing.odometry.odometry import Odometry

_OLD_S = 0.5  # older data in the inbox is discarded
_PULSE_S = 0.5


def run(argument: Mapping[str, Any], out: RecordWriter) -> NoReturn:
    """Serve until the parent closes the pipe (BrokenPipeError)."""
    lidars = Lidars.of(argument["lidars"])
    reader = socket.socket(fileno=argument["fd"])
    reader.setblocking(False)
    odometry = Odometry(time.monotonic_ns() // 1_000_000)  # no track of a process before this one
    pulse_s = 0.0
    while True:
        now_s = time.monotonic()
        if now_s >= pulse_s:  # alive, though nothing is measured
            out.data(b"null")
            pulse_s = now_s + _PULSE_S
        if not select.select([reader], [], [], _PULSE_S)[0]:
            continue
        message = inbox.unpack(reader.recv(inbox.LONGEST))
        oldest_s = time.monotonic() - _OLD_S
        if isinstance(message, Motion) and message.time_s > oldest_s:
            odometry.motion(message)
        elif isinstance(message, HalfTurn) and message.last_s > oldest_s:
            piece = lidars.piece(message)
            estimate = odometry.piece(piece) if piece is not None else None
            if estimate is not None:
                out.data(json.dumps(asdict(estimate)).encode())
                pulse_s = time.monotonic() + _PULSE_S


def main() -> int:
    """Entry of `python -m gazechair.sensing.odometry.child JSON`: lidars, fd."""
    return child_main(run)


if __name__ == "__main__":
    sys.exit(main())
