"""Child processes that end with their parent, however it ends; and those with priority."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

_PR_SET_PDEATHSIG = 1
_FIRST = "-10"  # the nice value of a session's processes together, see sched(7)
_libc = ctypes.CDLL(None) if sys.platform == "linux" else None


def dies_with_me(number: signal.Signals) -> Callable[[], None]:
    """A preexec_fn: the child gets signal `number` when the thread that starts it ends.

    The child receives every signal, even those that its parent ignored.
    Only on Linux; elsewhere such a child continues when its parent is killed.
    """
    parent = os.getpid()

    def prepare() -> None:
        signal.pthread_sigmask(signal.SIG_SETMASK, ())
        if _libc is None:
            return
        _libc.prctl(_PR_SET_PDEATHSIG, number)
        if os.getppid() != parent:  # it ended before the request took effect
            os.kill(os.getpid(), number)

    return prepare


def simulates_a_device(number: signal.Signals) -> Callable[[], None]:
    """As dies_with_me, for the leader of a new session that stands for a device: it has priority,
    because a real one has its own processor. Only on Linux, and only for root.
    """
    dies = dies_with_me(number)

    def prepare() -> None:
        dies()
        with contextlib.suppress(OSError):
            Path("/proc/self/autogroup").write_text(_FIRST)

    return prepare
