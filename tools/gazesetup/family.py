"""Child processes that end with their parent, however it ends."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Callable

_PR_SET_PDEATHSIG = 1
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
