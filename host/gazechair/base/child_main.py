"""Sets up a child process of the daemon: its signals, its argument, its standard output."""

from __future__ import annotations

import ctypes
import json
import logging
import os
import signal
import sys
from collections.abc import Callable
from typing import Any

from gazechair.base.child_process import END
from gazechair.base.child_records import RecordWriter

_PR_SET_PDEATHSIG = 1


def enter_child(outlives: bool = False) -> RecordWriter:
    """First call in a child: die with the parent, end on END, reserve stdout for records.

    `outlives`: the child notices the parent's death itself, and has something to finish.
    """
    if sys.platform == "linux" and not outlives:
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    signal.signal(END, lambda *_: sys.exit(0))
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the parent, which ends us
    signal.signal(signal.SIGTERM, lambda *_: None)  # the same; not SIG_IGN, which programs inherit
    logging.basicConfig(level=logging.WARNING, format="%(name)s: %(message)s")
    fd = os.dup(1)
    os.dup2(2, 1)  # a library that prints must not break the records
    return RecordWriter(fd)


def child_main(run: Callable[[Any, RecordWriter], int]) -> int:
    """A child's main: `run` gets its JSON argument and serves until the parent closes a pipe."""
    argument = json.loads(sys.argv[1])
    out = enter_child()
    try:
        return run(argument, out)
    except BrokenPipeError:
        return 0
