"""Helpers of the supervisor for one child process: its pipes, what it waits for, its end."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from pathlib import Path

# Ends one child. Not SIGTERM: a service manager sends that to all processes at once, while the
# daemon still needs the children for a stop in order.
END = signal.SIGUSR1
# A child that is ready to run, or waits for a disk, gets longer to finish writing.
_ENDS_S = (1.0, 3.0)


def drain(fd: int, most: int) -> tuple[bytes, bool]:
    """All available bytes, up to about `most`, and whether the other end is closed."""
    pieces: list[bytes] = []
    size = 0
    while size < most:
        try:
            piece = os.read(fd, min(most, 1 << 16))
        except BlockingIOError:
            return b"".join(pieces), False
        if not piece:
            return b"".join(pieces), True
        pieces.append(piece)
        size += len(piece)
    return b"".join(pieces), False


def send_to(process: subprocess.Popen[bytes], message: bytes | None) -> bool:
    """Send a line, whole or not at all; False when the child has not read the previous ones."""
    if process.stdin is None or message is None:
        return True
    try:
        os.write(process.stdin.fileno(), message)
    except BlockingIOError:
        return False
    except OSError:
        return True  # it has ended, which its records show
    return True


def end(process: subprocess.Popen[bytes]) -> None:
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            pipe.close()
    with contextlib.suppress(ProcessLookupError):
        process.send_signal(END)
    for seconds in _ENDS_S:
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(seconds)
            return
        if not would_run(process.pid):
            break
    process.kill()
    # One that waits for a device or disk in the kernel ends when it wakes; nobody waits for that.
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(5.0)


def would_run(pid: int) -> bool:
    """True if a thread of it is ready to run or waits for a disk (proc(5)): it does not hang."""
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            if (task / "stat").read_text().rpartition(")")[2].split()[0] in "RD":
                return True
    return False
