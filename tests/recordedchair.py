"""A chair in virtual time whose host, and whose board, record what happens, into real files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from e2e.lockstep import Lockstep
from gazechair.blackbox.writer import LogWriter
from gazereplay import trace
from gazereplay.tap import Tap

WALL_NS = 1_790_000_000 * 10**9  # when its clock begins


def log_writer(folder: Path, clock: Any, max_bytes: int = 10**8, **more: Any) -> LogWriter:
    """A writer on the virtual clock of `clock`, which has now_ms."""
    return LogWriter(
        folder,
        max_bytes,
        keep_s=86400.0,
        wall_ns=lambda: WALL_NS + clock.now_ms * 10**6,
        monotonic_ns=lambda: int(clock.now_ms * 10**6),
        free_bytes=lambda _: 10**10,
        **more,
    )


class RecordedChair(Lockstep):
    """The whole chair; `close` finishes the file at `path`."""

    def __init__(self, folder: Path, room: str = "open") -> None:
        super().__init__(room)
        self._log = log_writer(folder, self)
        self.sizes: dict[int, int] = {}
        """{ms: bytes of the file} after each sync."""
        assert self.host is not None
        self.host.link.protocol._witness = self._saw
        self.path = Path()
        self.board.booted = self._tap
        self._tap(self.app)
        self.watchers.append(self._sync)

    def _saw(self, way: str, at_s: float, frame: bytes) -> None:
        self._log.write(way, int(at_s * 1e9), frame)

    def _tap(self, app: Any) -> None:
        self.tap = Tap(app, self._trace)

    def _trace(self, topic: str, fields: dict[str, Any]) -> None:
        definition = trace.DEFINITIONS[topic][1]
        self._log.publish(self.now_ms * 10**6, topic, trace.type_name(topic), definition, fields)

    def note(self, kind: str, payload: Any) -> None:
        """Anything else that the host would record."""
        self._log.write(kind, self.now_ms * 10**6, payload)

    def _sync(self) -> None:
        if self.now_ms % 1000 == 0:
            self._log.sync()
            if self._log.path is not None:
                self.path = self._log.path
                self.sizes[self.now_ms] = self.path.stat().st_size

    def close(self) -> Path:
        """Finish the file."""
        self.tap.end("the recording ends")
        self.path = self._log.path or self.path
        self._log.close()
        return self.path
