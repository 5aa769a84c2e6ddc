"""Progress lines with timings, quiet commands, and the error that names what is missing."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from gazesetup.family import dies_with_me

NOTE_EVERY_S = 3.0
TAIL_LINES = 25


class NotAvailable(Exception):
    """Something is not available on this machine. The text: one line, what and what to do."""


@contextmanager
def say(step: str) -> Iterator[None]:
    """Print `step` when it begins, and how long it took (or that it failed) when it ends."""
    print(f"* {step} ...", flush=True)
    start = time.monotonic()
    try:
        yield
    except BaseException:
        print(f"  {step}: failed after {time.monotonic() - start:.1f} s", flush=True)
        raise
    print(f"  {step}: {time.monotonic() - start:.1f} s", flush=True)


def note(text: str) -> None:
    """Print one line that belongs to the step in progress."""
    print(f"  {text}", flush=True)


def run_quietly(
    command: Sequence[str | Path],
    *,
    show: Callable[[str], str | None] = lambda line: None,
    cwd: Path | None = None,
    env: Mapping[str, str] | None = None,
) -> str:
    """Run `command`; return what it printed. `show` turns a line into a progress note, or None.

    Notes come at most every few seconds. Raises NotAvailable, after printing the last lines, when
    the command cannot be started or ends in an error.
    """
    words = [str(word) for word in command]
    lines: list[str] = []
    last_note = time.monotonic()
    try:
        with subprocess.Popen(
            words,
            cwd=cwd,
            env=env,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            preexec_fn=dies_with_me(signal.SIGTERM),
        ) as process:
            assert process.stdout is not None
            try:
                for line in process.stdout:
                    lines.append(line)
                    text = show(line.strip())
                    if text and time.monotonic() - last_note >= NOTE_EVERY_S:
                        last_note = time.monotonic()
                        note(text)
            except BaseException:
                with suppress(OSError):  # another user's, as under sudo
                    process.terminate()
                raise
    except OSError as error:
        raise NotAvailable(f"cannot start {words[0]}: {error}") from error
    if process.returncode != 0:
        sys.stderr.write("".join(lines[-TAIL_LINES:]))
        raise NotAvailable(f"{' '.join(words[:4])} ... ended with {process.returncode} (see above)")
    return "".join(lines)
