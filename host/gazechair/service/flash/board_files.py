"""A board's REPL as flashing needs it: facts, files, a reset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Facts:
    """What a board in its REPL is."""

    platform: str
    """sys.platform: mimxrt on a Teensy 4."""
    machine: str
    version: tuple[int, int, int]
    """Of its MicroPython."""
    mpy: int
    """sys.implementation._mpy, 0 when it takes no .mpy files."""
    hard_timer: bool
    """Whether machine.Timer takes hard=True."""

    @property
    def micropython(self) -> str:
        """Its version as text."""
        return ".".join(map(str, self.version))


class BoardFiles(Protocol):
    """A board in its REPL. Every call raises FlashError when the board does not answer."""

    def facts(self) -> Facts:
        """What it is."""

    def hashes(self, folder: str) -> dict[str, str]:
        """Every file below `folder` by its full path -> SHA-256 in hex; {} without a folder."""

    def folders(self, folder: str) -> list[str]:
        """Names of the folders in `folder`."""

    def read(self, path: str) -> bytes | None:
        """A whole file, None when there is none."""

    def make_folder(self, path: str) -> None:
        """Make a folder, and those above it, unless it is there."""

    def write(self, path: str, content: bytes) -> None:
        """Write a file; half of it is there when the board dies meanwhile."""

    def rename(self, path: str, new_path: str) -> None:
        """Rename a file, in one step, over an older one if there is one."""

    def remove(self, path: str) -> None:
        """Remove a file, or a folder with all in it; nothing happens when it is not there."""

    def free_bytes(self) -> int:
        """Free room of its flash."""

    def feed_watchdog(self) -> None:
        """Give it another 128 s; only for a board whose watchdog runs."""

    def reset(self) -> None:
        """Reset it and release the port."""

    def close(self) -> None:
        """Release the port."""
