"""The log's process: takes records from the daemon and writes them to disk."""

from __future__ import annotations

import contextlib
import errno
import json
import logging
import signal
import socket
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gazechair.base import health as states
from gazechair.base.child_main import enter_child
from gazechair.base.child_process import END
from gazechair.base.child_records import RecordWriter
from gazechair.base.throttled_log import ThrottledLog
from gazechair.blackbox.ring import LONGEST, unpack
from gazechair.blackbox.writer import LogFull, LogWriter

log = logging.getLogger(__name__)
throttled = ThrottledLog(log)

SYNC_S = 1.0
_RETRY_S = 10.0
_LOOK_S = 0.1

FULL = "log_full"
REFUSED = "log_disk"


class Keeper:
    """Writes records, syncs every second, and reports its status."""

    def __init__(self, writer: LogWriter, out: RecordWriter) -> None:
        self._writer = writer
        self._out = out
        self._synced_s = time.monotonic()
        self._retry_s = 0.0
        self._standing: tuple[str, ...] = ()
        self.written = 0
        self.lost = 0

    def take(self, batch: bytes) -> None:
        """Write a batch of records; it is lost if the write fails."""
        records = unpack(batch)
        if time.monotonic() < self._retry_s:
            self.lost += len(records)
            return
        done = 0
        for kind, at_ns, payload in records:
            try:
                self._writer.write(kind, at_ns, payload)
                done += 1
            except OSError as error:
                self._failed(error)
                break
            except Exception as error:  # a record that cannot be written must not stop the others
                throttled.warn("not recorded: %s: %r", kind, error)
        self.written += done
        self.lost += len(records) - done

    def due(self) -> None:
        """Every second: sync to disk, and send a sign of life to the daemon."""
        now_s = time.monotonic()
        if now_s < self._synced_s + SYNC_S:
            return
        self._synced_s = now_s
        if now_s >= self._retry_s:
            try:
                self._writer.sync()
                if self._writer.path is not None or not self._retry_s:  # else nothing is proven
                    self._report(states.OK, "ok", "")
            except OSError as error:
                self._failed(error)
        figures = {"written": self.written, "refused_by_disk": self.lost}
        with contextlib.suppress(BrokenPipeError):  # the daemon ends: write what has arrived
            self._out.data(json.dumps(figures).encode())

    def _failed(self, error: OSError) -> None:
        self._retry_s = time.monotonic() + _RETRY_S
        self._writer.close()
        reason = FULL if isinstance(error, LogFull) or error.errno == errno.ENOSPC else REFUSED
        self._report(states.DEGRADED, reason, f"nothing is recorded: {error}")

    def _report(self, *standing: str) -> None:
        if standing != self._standing:
            self._standing = standing
            with contextlib.suppress(BrokenPipeError):
                self._out.status(*standing)


def run(argument: Mapping[str, Any], out: RecordWriter) -> None:
    """Serve until the daemon ends us or dies; writes everything that has arrived by then."""
    writer = LogWriter(Path(argument["folder"]), argument["max_bytes"], argument["keep_s"])
    keeper = Keeper(writer, out)
    ended: list[int] = []
    signal.signal(END, lambda number, _: ended.append(number))  # between two records
    line = socket.socket(fileno=argument["fd"])
    line.settimeout(_LOOK_S)
    try:
        while not ended:
            with contextlib.suppress(TimeoutError):
                if not (batch := line.recv(LONGEST)):
                    return  # the daemon was killed
                keeper.take(batch)
            keeper.due()
        line.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            while batch := line.recv(LONGEST):
                keeper.take(batch)
    finally:
        writer.close()


def main() -> None:
    """Entry of `python -m gazechair.blackbox.child JSON`: folder, limits, file descriptor."""
    run(json.loads(sys.argv[1]), enter_child(outlives=True))


if __name__ == "__main__":
    main()
