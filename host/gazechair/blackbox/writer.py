"""Writes the log: MCAP files in a folder, bounded in size and age, the oldest deleted first."""

from __future__ import annotations

import contextlib
import logging
import os
import re
import shutil
import stat
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

from mcap.records import Schema
from mcap_ros2.writer import Writer

from gazechair.base.clock import EARLIEST_S, is_set
from gazechair.base.state_folder import set_aside
from gazechair.blackbox import ros, topics

NAME = re.compile(r"(\d{6})_.*\.mcap")
FILE_S = 3600.0
_FILES = 20  # that share the space, at least
_MOST_FILES = 2000  # a daemon that restarts again and again makes many small ones
_CLOCK_S = 2.0  # a wall clock that was set by more begins another file
_CLOCK_EACH_NS = 60 * 10**9  # at most this often, even if the clock is set all the time
_GAP_S = 7 * 86400.0  # between two files; a longer one may be the clock that jumped
_LATEST_NS = (1 << 31) * 10**9 - 1  # of a stamp of ROS 2: in 2038
KEPT_FREE = 100 << 20  # bytes of the disk left free
FULL = "less than 100 MB of the disk are free"

log = logging.getLogger(__name__)


class LogFull(OSError):
    """Raised when the disk has no space for the log, and no older file is left to delete."""


def files(folder: Path) -> list[Path]:
    """The files of the log, oldest first, by number and not by clock."""
    try:
        return sorted(path for path in folder.iterdir() if NAME.fullmatch(path.name))
    except (FileNotFoundError, NotADirectoryError):
        return []


def ages_s(times_s: Sequence[float], now_s: float, trusted: bool) -> list[float]:
    """Ages of files last written at `times_s`, oldest first; `trusted`: the clock is right.

    A clock that was far ahead, or lost the date, must not delete everything. If it cannot be
    trusted, an age is the sum of the times between files, and long gaps count as zero.
    """
    ages = []
    age_s, next_s = 0.0, now_s
    for at_s in reversed(times_s):
        gap_s, next_s = next_s - at_s, at_s
        age_s += gap_s if 0 <= gap_s <= _GAP_S else 0.0
        plain = trusted and EARLIEST_S <= at_s <= now_s
        ages.append(now_s - at_s if plain else age_s)
    return ages[::-1]


def states(paths: Sequence[Path]) -> Iterator[tuple[Path, os.stat_result]]:
    """Those of `paths` that are files, with size and times."""
    for path in paths:
        # Somebody has just deleted it, or it is a link to itself.
        with contextlib.suppress(OSError):
            state = path.stat()
            if stat.S_ISREG(state.st_mode):
                yield path, state


class LogWriter:
    """Only one process writes at a time. All methods but close() raise OSError."""

    def __init__(
        self,
        folder: Path,
        max_bytes: int,
        keep_s: float,
        wall_ns: Callable[[], int] = time.time_ns,
        monotonic_ns: Callable[[], int] = time.monotonic_ns,
        free_bytes: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
        clock_is_right: Callable[[], bool] = is_set,
    ) -> None:
        """`max_bytes`: of all files together; `keep_s`: maximum age of a file, see ages_s."""
        self._folder = folder
        self._max_bytes = max_bytes
        self._keep_s = keep_s
        self._wall_ns = wall_ns
        self._monotonic_ns = monotonic_ns
        self._free_bytes = free_bytes
        self._clock_is_right = clock_is_right
        self._file: BinaryIO | None = None
        self._writer: Any = None
        self._schemas: dict[str, Schema] = {}
        self._offset_ns = 0  # from the monotonic to the wall clock
        self._begun_ns = 0
        self._synced = False
        self._next_set_ns = 0
        self.path: Path | None = None

    def write(self, kind: str, at_ns: int, payload: Any) -> None:
        """One record, at `at_ns` of the monotonic clock."""
        if self._writer is None:
            self._open()
        wall_ns = self._stamp_ns(at_ns)
        for topic, name, message in topics.messages_of(kind, min(wall_ns, _LATEST_NS), payload):
            self._write_message(wall_ns, topic, name, ros.DEFINITIONS[name], message)

    def publish(
        self, at_ns: int, topic: str, name: str, definition: str, message: dict[str, Any]
    ) -> None:
        """Write a message of another type, at `at_ns` of the monotonic clock."""
        if self._writer is None:
            self._open()
        self._write_message(self._stamp_ns(at_ns), topic, name, definition, message)

    def _stamp_ns(self, at_ns: int) -> int:
        return max(0, at_ns + self._offset_ns)

    def _write_message(
        self, wall_ns: int, topic: str, name: str, definition: str, message: dict[str, Any]
    ) -> None:
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_msgdef(name, definition)
        self._writer.write_message(topic, self._schemas[name], message, log_time=wall_ns)

    def sync(self) -> None:
        """Sync everything to disk, and keep the log within its limits."""
        if self.path is not None and not self.path.exists():
            self.close()  # somebody has deleted it
        if self._file is not None:
            self._writer._writer.flush()  # the chunk: mcap_ros2 itself has no flush
            self._file.flush()
            os.fsync(self._file.fileno())
            self._synced = True
            now_ns = self._monotonic_ns()
            old = (now_ns - self._begun_ns) / 1e9 > FILE_S
            full = self._file.tell() > self._max_bytes // _FILES
            was_set = abs(self._wall_ns() - now_ns - self._offset_ns) > _CLOCK_S * 1e9
            if was_set and now_ns >= self._next_set_ns:
                self._next_set_ns = now_ns + _CLOCK_EACH_NS
                self.close()
            elif old or full:
                self.close()
        self._trim()

    def close(self) -> None:
        """Finish the file; if the write fails, the file stays truncated, and one of which nothing
        ever reached the disk goes: in time such files would count as too many."""
        file, writer, path = self._file, self._writer, self.path
        self._file = self._writer = self.path = None
        self._schemas = {}
        if file is None:
            return
        try:
            writer.finish()
            file.flush()
            os.fsync(file.fileno())
        except OSError as error:
            log.warning("the log's file has no end: %s", error)
            if path is not None and not self._synced:
                with contextlib.suppress(OSError):
                    path.unlink()
        with contextlib.suppress(OSError):
            file.close()

    def _open(self) -> None:
        if self._folder.is_file():
            set_aside(self._folder)
        self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        self._trim()
        old = files(self._folder)
        number = int(old[-1].name[:6]) + 1 if old else 1
        moment = time.strftime("%Y-%m-%dT%H-%M-%S", time.localtime(self._wall_ns() / 1e9))
        self.path = self._folder / f"{number % 1000000:06}_{moment}.mcap"
        self._file = os.fdopen(
            os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb"
        )
        self._begun_ns, self._synced = self._monotonic_ns(), False
        self._offset_ns = self._wall_ns() - self._begun_ns
        self._writer = Writer(self._file)

    def _trim(self) -> None:
        if not self._folder.is_dir():
            return
        kept = list(states(files(self._folder)))
        total = sum(state.st_size for _, state in kept)
        free = self._free_bytes(self._folder)
        now_s = self._wall_ns() / 1e9
        times_s = [now_s if path == self.path else state.st_mtime for path, state in kept]
        ages = ages_s(times_s, now_s, self._clock_is_right())
        for at, ((path, state), age_s) in enumerate(zip(kept, ages, strict=True)):
            if path == self.path:
                continue
            many = len(kept) - at > _MOST_FILES
            full = total > self._max_bytes or free < KEPT_FREE
            if many or full or age_s > self._keep_s:
                path.unlink(missing_ok=True)
                total -= state.st_size
                free += state.st_size
        if free < KEPT_FREE:
            raise LogFull(FULL)
