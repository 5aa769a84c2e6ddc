"""A chair in virtual time whose host, and whose board, record what happens, into real files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gazereplay.recording import Recording
from gazesim.lockstep_chair import Lockstep


class RecordedChair(Lockstep):
    """The whole chair; `close` finishes the file at `path`."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        assert self.host is not None
        self._recording = Recording(self, self.host.link.protocol, folder)
        self.sizes: dict[int, int] = {}
        """{ms: bytes of the file} after each sync."""
        self.watchers.append(self._after_ms)

    @property
    def path(self) -> Path:
        """The file."""
        return self._recording.path

    def note(self, kind: str, payload: Any) -> None:
        """Anything else that the host would record."""
        self._recording.note(kind, payload)

    def _after_ms(self) -> None:
        if self._recording.after_ms():
            self.sizes[self.now_ms] = self.path.stat().st_size

    def close(self) -> Path:
        """Finish the file."""
        return self._recording.close()
