"""Mapping's child process: reads its inbox and the daemon's requests, reports the pose."""

from __future__ import annotations

import json
import select
import socket
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

from gazechair.base.child_main import child_main
from gazechair.base.child_records import RecordWriter
from gazechair.base.newest_line import NewestLine
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.pieces import Lidars
from gazechair.sensing.mapping.worker import PULSE_S, Worker
from gazechair.sensing.odometry.estimate import Estimate

_OLD_S = 0.5  # older data in the inbox is discarded


def run(argument: Mapping[str, Any], out: RecordWriter) -> NoReturn:
    """Serve until the parent closes a pipe (BrokenPipeError)."""
    lidars = Lidars.of(argument["lidars"])
    fd = int(argument["fd"])
    reader = socket.socket(fileno=fd)
    reader.setblocking(False)
    worker = Worker(lidars, Path(argument["folder"]), out)
    lines = NewestLine()
    tick_s = 0.0
    while True:
        ready = select.select([fd, 0], [], [], PULSE_S)[0]
        if 0 in ready:
            line = lines.read()
            if line is not None:
                worker.word(json.loads(line))
        if fd in ready:
            message = inbox.unpack(reader.recv(inbox.LONGEST))
            oldest_s = time.monotonic() - _OLD_S
            if isinstance(message, HalfTurn) and message.last_s > oldest_s:
                worker.half(message)
            elif isinstance(message, Estimate) and message.time_s > oldest_s:
                worker.estimate(message)
        if time.monotonic() >= tick_s:
            tick_s = time.monotonic() + PULSE_S
            worker.tick()


def main() -> int:
    """Entry of `python -m gazechair.sensing.mapping.child JSON`: lidars, fd, folder."""
    return child_main(run)


if __name__ == "__main__":
    sys.exit(main())
