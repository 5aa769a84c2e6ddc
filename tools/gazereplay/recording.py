"""Records a chair in virtual time as its host's log, with the trace of its board."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from gazechair.blackbox.writer import LogWriter
from gazechair.board.protocol import LinkProtocol
from gazereplay import trace
from gazereplay.tap import Tap
from gazesim.chair_rig import ChairRig

WALL_NS = 1_790_000_000 * 10**9  # where its clock begins
_SYNC_MS = 1000


def virtual_log(folder: Path, now_ms: Callable[[], int]) -> LogWriter:
    """A log in virtual time, on a disk without limit."""
    return LogWriter(
        folder,
        max_bytes=10**9,
        keep_s=1e9,
        wall_ns=lambda: WALL_NS + now_ms() * 10**6,
        monotonic_ns=lambda: now_ms() * 10**6,
        free_bytes=lambda _: 10**10,
    )


class Recording:
    """Attach it before the chair's first step, and call `after_ms` after each."""

    def __init__(self, chair: ChairRig, protocol: LinkProtocol, folder: Path) -> None:
        """`protocol`: the host's side of the line; `folder`: for the file."""
        self._chair = chair
        self._log = virtual_log(folder, lambda: chair.now_ms)
        self.path = Path()
        self._sees(protocol)
        chair.board.booted = self._boots
        self._boots(chair.app)

    def note(self, kind: str, payload: Any) -> None:
        """Add a record of the host now; see gazechair.blackbox.topics."""
        self._log.write(kind, self._chair.now_ms * 10**6, payload)

    def after_ms(self) -> bool:
        """Call after each step; True when everything was synced."""
        self.path = self._log.path or self.path
        if self._chair.now_ms % _SYNC_MS:
            return False
        self._log.sync()
        return True

    def close(self) -> Path:
        """Finish the file."""
        self._tap.end("the recording ends")
        self._log.close()
        return self.path

    def _sees(self, protocol: LinkProtocol) -> None:
        protocol.witness = lambda way, at_s, frame: self._log.write(way, int(at_s * 1e9), frame)

    def _boots(self, app: Any) -> None:
        self._tap = Tap(app, self._say)

    def _say(self, topic: str, fields: dict[str, Any]) -> None:
        definition = trace.DEFINITIONS[topic][1]
        at_ns = self._chair.now_ms * 10**6
        self._log.publish(at_ns, topic, trace.type_name(topic), definition, fields)
