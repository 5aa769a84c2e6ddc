"""Supervises child processes, each of which owns a device whose library can hang.

A child writes records (child_records.py). It may also read: messages arrive as lines on its
standard input, and only the newest counts. The parent never waits for a child that does not read.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import select
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from gazechair.base.child_process import drain, end, send_to, would_run
from gazechair.base.child_records import DATA, FACTS, MAX_RECORD, RecordReader
from gazechair.base.rate_limit import RateLimit

_MOST_TIMES_START = 8  # as long as `start_s` for the first value
_GIVEN_UP = 10  # children that delivered nothing, before the first that does
_GIVEN_UP_PAUSE_S = 60.0
_STATUS_COST = 20  # records: each may become a line of the log
_LOOK_S = 0.1
_PAUSE_S = 0.25  # before the first restart
_WORKS_S = 10.0  # a child that delivers for this long: the next pause is short again

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Status:
    """The part's health, from its child or supervisor: state, reason key, one plain line."""

    state: str
    reason: str
    detail: str
    how: str = ""
    """How a child was lost, by its supervisor: "unstarted", "wrong", "ended" or "hangs"."""


@dataclass
class _Child:
    """One child process: the reader of its records, and the state of what it has reported."""

    reader: RecordReader
    limit: RateLimit
    delivered: bool = False
    explained: bool = False
    """Its newest status says that it is lost, and why."""


class Supervisor:
    """Runs `python -m module argument` for as long as it is started.

    `on_data` gets the newest value, `on_status` every change, both on the supervisor's thread. A
    child that sends nothing for `silent_s` (`start_s` before its first value) is killed, and so is
    one whose value `on_data` refuses by a ValueError, or that sends more than `records_per_s`; one
    that ended is restarted after 0.25 s, doubling up to `longest_pause_s` until it
    delivers for 10 s. Each one that ends before its first value doubles `start_s` for the next
    one, up to 8 times: an overloaded machine is not kept busy with starts.
    When 10 have delivered nothing and none ever has, the part is disabled: something it needs is
    probably missing, and it is retried once a minute.
    """

    def __init__(
        self,
        module: str,
        argument: str,
        on_data: Callable[[bytes], None],
        on_status: Callable[[Status], None],
        *,
        lost_reason: str,
        silent_s: float = 2.0,
        start_s: float = 10.0,
        listens: bool = False,
        name: str = "",
        longest: int = MAX_RECORD,
        records_per_s: float = 0.0,
        on_facts: Callable[[bytes], None] = lambda _facts: None,
        longest_pause_s: float = 4.0,
        nice: int = 0,
        fds: tuple[int, ...] = (),
        patience_s: float = 0.0,
    ) -> None:
        """`name`: the child's name in statuses; `longest`: bytes of its longest record;
        `records_per_s` 0: no limit; `on_facts` gets every record of facts; `nice`: the child's
        niceness; `fds`: file descriptors that each child inherits under the same numbers;
        `patience_s`: how much longer than `silent_s` it may be silent while it waits for a
        processor or a disk."""
        self._command = [sys.executable, "-m", module, argument]
        self._name = name or module.removesuffix(".child")
        self._longest = longest
        self._records_per_s = records_per_s
        self._on_facts = on_facts
        self._longest_pause_s = longest_pause_s
        self._nice = nice
        self._fds = fds
        self._patience_s = patience_s
        self._on_data = on_data
        self._on_status = on_status
        self._lost_reason = lost_reason
        self._silent_s = silent_s
        self._start_s = start_s
        self._listens = listens
        self._message: bytes | None = None  # the newest, for a child that reads
        self._wake_fds = os.pipe()
        os.set_blocking(self._wake_fds[1], False)
        self._lock = threading.Lock()  # prevents writing to a closed pipe
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
        self._process: subprocess.Popen[bytes] | None = None
        self.restarts = 0
        self.next_start_s: float | None = None
        """When the child that was lost is started again, monotonic; None: it runs."""

    @property
    def pid(self) -> int | None:
        """Process id of the running child, None while none runs."""
        process = self._process
        return process.pid if process else None

    def start(self) -> None:
        """Start the thread that owns the child."""
        self._thread.start()

    def send(self, message: bytes) -> None:
        """Send the newest line, of at most select.PIPE_BUF bytes, to a child that reads, and to
        each one after it. It is sent at once, or when the child has read; never waits."""
        assert self._listens
        assert len(message) < select.PIPE_BUF
        assert b"\n" not in message
        self._message = message + b"\n"
        self._wake()

    def stop(self, timeout_s: float = 5.0) -> None:
        """End the child (END, after 1 to 4 s SIGKILL) and the thread. Safe to call twice."""
        if self._stopping.is_set():
            return
        self._stopping.set()
        self._wake()
        if self._thread.is_alive():
            self._thread.join(timeout_s)
        with self._lock:
            for fd in self._wake_fds:
                os.close(fd)
            self._wake_fds = (-1, -1)

    def _wake(self) -> None:
        with self._lock, contextlib.suppress(BlockingIOError):  # full: it is awake already
            if self._wake_fds[1] >= 0:
                os.write(self._wake_fds[1], b".")

    def _run(self) -> None:
        pause_s = _PAUSE_S
        times_start = 1
        ever = False  # one has delivered
        while not self._stopping.is_set():
            started_s = time.monotonic()
            delivered = False
            try:
                process = self._spawn()
            except OSError as error:
                self._lost("unstarted", f"{self._name} could not start: {error}")
            else:
                self._process = process
                try:
                    delivered = self._watch(process, self._start_s * times_start)
                finally:
                    self._process = None
                    end(process)
                times_start = 1 if delivered else min(2 * times_start, _MOST_TIMES_START)
            ever = ever or delivered
            if delivered and time.monotonic() - started_s > _WORKS_S:
                pause_s = _PAUSE_S
            if not ever and self.restarts + 1 >= _GIVEN_UP:
                if self.restarts + 1 == _GIVEN_UP:
                    log.warning("%s is disabled: it has never worked", self._name)
                pause_s = _GIVEN_UP_PAUSE_S
            self.next_start_s = time.monotonic() + pause_s
            if self._stopping.wait(pause_s):
                break
            self.next_start_s = None
            pause_s = min(pause_s * 2, self._longest_pause_s)
            self.restarts += 1

    def _spawn(self) -> subprocess.Popen[bytes]:
        # The child gets the packages on our path, however they got there.
        environment = dict(os.environ, PYTHONPATH=os.pathsep.join(p for p in sys.path if p))
        process = subprocess.Popen(
            self._command,
            stdin=subprocess.PIPE if self._listens else subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            env=environment,
            pass_fds=self._fds,
        )
        if self._nice:
            os.setpriority(os.PRIO_PROCESS, process.pid, self._nice)
        return process

    def _watch(self, process: subprocess.Popen[bytes], start_s: float) -> bool:
        """Serve until the child ends, hangs or must stop; True when it delivered a value."""
        assert process.stdout is not None
        fd = process.stdout.fileno()
        os.set_blocking(fd, False)
        if process.stdin is not None:
            os.set_blocking(process.stdin.fileno(), False)
        sent: bytes | None = None
        limit = RateLimit(self._records_per_s, self._records_per_s)
        child = _Child(RecordReader(self._longest), limit)
        deadline_s = time.monotonic() + start_s
        while not self._stopping.is_set():
            message = self._message
            if message is not sent and send_to(process, message):
                sent = message
            left_s = deadline_s - time.monotonic()
            ready = select.select([fd, self._wake_fds[0]], [], [], max(0.0, left_s))[0]
            if self._wake_fds[0] in ready:
                os.read(self._wake_fds[0], 64)
            if fd in ready:
                try:
                    newest, ended = self._read_records(child, fd)
                    if newest is not None:
                        child.delivered, child.explained = True, False
                        deadline_s = time.monotonic() + self._silent_s
                        self._on_data(newest)
                except Exception as error:  # whatever it sends, the next child is started
                    self._lost("wrong", f"{self._name} sent nonsense: {error}")
                    break
                if ended:
                    if not child.explained:
                        self._lost("ended", f"{self._name} ended unexpectedly; starting it again")
                    break
            elif left_s <= 0 and self._end_silent(process, left_s, bool(ready)):
                break
        return child.delivered

    def _read_records(self, child: _Child, fd: int) -> tuple[bytes | None, bool]:
        """Pass on what the child has sent; its newest value, and whether it has ended.

        Raises ValueError for what no child may send.
        """
        newest = None
        data, ended = drain(fd, 2 * self._longest)
        records = child.reader.feed(data)
        cost = sum(1 if kind == DATA else _STATUS_COST for kind, _ in records)
        if self._records_per_s and not child.limit.allow(time.monotonic(), cost):
            raise ValueError(f"more than {self._records_per_s:g} records a second")
        for kind, payload in records:
            if kind == DATA:
                newest = payload
            elif kind == FACTS:
                self._on_facts(payload)
            else:
                child.explained = self._pass_on(payload)
        return newest, ended

    def _end_silent(self, process: subprocess.Popen[bytes], left_s: float, woken: bool) -> bool:
        """End a child that is overdue, unless it waits for a processor or a disk; True: it ends."""
        if left_s > -self._patience_s and would_run(process.pid):
            self._stopping.wait(_LOOK_S)
            return False
        if woken:
            return False
        self._lost("hangs", f"{self._name} hangs; ending it and starting it again")
        process.kill()  # it would not react to END
        return True

    def _pass_on(self, payload: bytes) -> bool:
        """Report the child's status; whether it explains the child's end."""
        fields = json.loads(payload)
        try:
            status = Status(*(str(fields[key]) for key in ("state", "reason", "detail")))
        except (KeyError, TypeError):
            raise ValueError("a status without state, reason or detail") from None
        self._on_status(status)
        return status.state == "lost"

    def _lost(self, how: str, detail: str) -> None:
        self._on_status(Status("lost", self._lost_reason, detail, how))


class Supervised:
    """A part of the daemon whose work is done by a child process."""

    _supervisor: Supervisor | None = None  # None: not started, or not configured

    @property
    def restarts(self) -> int:
        """How often the child process was restarted."""
        return self._supervisor.restarts if self._supervisor else 0

    @property
    def next_start_s(self) -> float | None:
        """When its child is restarted, monotonic s; None: it runs, or never will."""
        return self._supervisor.next_start_s if self._supervisor else None

    @property
    def pid(self) -> int | None:
        """Process id of the child, None while there is none."""
        return self._supervisor.pid if self._supervisor else None

    def stop(self) -> None:
        """End the child process and its thread."""
        if self._supervisor is not None:
            self._supervisor.stop()
