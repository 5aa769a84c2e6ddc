"""A producer's child process: reads its inbox and the daemon's messages, steps when it is due."""

from __future__ import annotations

import json
import os
import select
import socket
import sys
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NoReturn

from gazechair.base.child_main import enter_child
from gazechair.base.child_records import RecordWriter
from gazechair.base.footprint import Footprint, Margins
from gazechair.base.newest_line import NewestLine
from gazechair.picture.newest import PictureReader
from gazechair.producers.contract import Setup
from gazechair.producers.kinds import build
from gazechair.producers.runner import Runner
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.pieces import Lidars
from gazechair.sensing.mapping.locating.whereabouts import unpack


def run(argument: Mapping[str, Any], out: RecordWriter) -> NoReturn:
    """Serve until the parent closes a pipe (BrokenPipeError)."""
    reader = socket.socket(fileno=int(argument["fd"]))
    pictures = argument["pictures"]
    runner = Runner(
        build(argument["kind"], _setup(argument)),
        Lidars.of(argument["lidars"]),
        out,
        ThreadPoolExecutor(1, thread_name_prefix=argument["kind"]),
        time.monotonic,
        (lambda: None) if pictures is None else PictureReader(pictures).take,
    )
    lines = NewestLine()
    while True:
        if select.select([0], [], [], runner.left_s(time.monotonic()))[0]:
            line = lines.read()
            if line is not None:
                runner.on_message(json.loads(line))
        now_s = time.monotonic()
        if not runner.left_s(now_s):
            # Not one by one as they come: several hundred a second, in each producer's process.
            for datagram in inbox.waiting(reader):
                runner.received(unpack(datagram) or inbox.unpack(datagram), now_s)
            runner.tick(now_s)


def _setup(argument: Mapping[str, Any]) -> Setup:
    outline = argument["footprint"]
    corners = tuple((float(x), float(y)) for x, y in outline["corners_m"])
    footprint = Footprint(corners, Margins(*outline["margins_m"]))
    return Setup(footprint, Path(argument["maps"]), Path(argument["state"]))


def main() -> int:
    """Entry of `python -m gazechair.producers.child JSON`: kind, lidars, fds, setup."""
    argument = json.loads(sys.argv[1])
    out = enter_child()
    try:
        run(argument, out)
    except BrokenPipeError:
        code = 0
    except Exception as error:  # the daemon's log needs its line
        sys.excepthook(type(error), error, error.__traceback__)
        code = 1
    sys.stderr.flush()
    os._exit(code)  # do not wait for a step that hangs


if __name__ == "__main__":
    sys.exit(main())
