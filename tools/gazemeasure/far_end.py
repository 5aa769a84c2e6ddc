"""A pseudo terminal with somebody at its far end, for measurements without a board."""

from __future__ import annotations

import contextlib
import os
import pty
import threading
import tty
from collections.abc import Callable, Iterator


@contextlib.contextmanager
def far_end(take: Callable[[int, bytes], object]) -> Iterator[int]:
    """The near end's descriptor; a thread passes `take` the far one and what arrives there."""
    near, far = pty.openpty()
    tty.setraw(near)
    tty.setraw(far)

    def serve() -> None:
        with contextlib.suppress(OSError):
            while data := os.read(far, 256):
                take(far, data)

    thread = threading.Thread(target=serve, name="far end", daemon=True)
    thread.start()
    try:
        yield near
    finally:
        os.close(near)
        thread.join(2.0)
        os.close(far)
