"""The steps on the board's flash, in an order that leaves a bootable firmware at every moment."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable

from gazechair.service.flash import tree as t
from gazechair.service.flash.board_files import BoardFiles
from gazechair.service.flash.errors import FlashError
from gazechair.service.flash.tree import Tree

OLD_MAIN = t.MAIN + ".old"
_NEW_MAIN = t.MAIN + ".new"
_SLACK_BYTES = 64 * 1024  # LittleFS rounds each file up to blocks of 4 kB
_BLOCK = 4096
_FEED_S = 30.0


def sha256(content: bytes) -> str:
    """SHA-256 in hex."""
    return hashlib.sha256(content).hexdigest()


class Deployment:
    """One firmware onto one board: `copy`, `switch`, and after a reset `roll_back` if need be."""

    def __init__(self, board: BoardFiles, tree: Tree, watchdog: bool) -> None:
        """`watchdog`: the board's watchdog runs, so it has to be fed."""
        self._board = board
        self._tree = tree
        self._watchdog = watchdog
        self._fed_s = 0.0

    def up_to_date(self) -> bool:
        """Whether the board has exactly this firmware, and starts it."""
        return self._board.read(t.MAIN) == self._tree.main and not self._missing()

    def copy(self, progress: Callable[[str, int], None]) -> int:
        """Copy what is not there yet, check every file; returns how many were copied.

        `progress(path, bytes)` is called after each. Raises FlashError when there is no room, or
        a file does not arrive as it is.
        """
        self._feed()
        self._clean()
        missing = self._missing()
        needed = sum(-len(self._tree.files[path]) // _BLOCK * -_BLOCK for path in missing)
        free = self._board.free_bytes()
        if free < needed + _SLACK_BYTES:
            raise FlashError(
                f"the board's flash has {free // 1024} kB left and the firmware needs"
                f" {(needed + _SLACK_BYTES) // 1024} kB; remove files of yours from it"
            )
        for folder in sorted({path.rpartition("/")[0] for path in missing}):
            self._board.make_folder(f"{self._tree.folder}/{folder}")
        for path in missing:
            self._feed()
            self._board.write(f"{self._tree.folder}/{path}", self._tree.files[path])
            progress(path, len(self._tree.files[path]))
        wrong = self._missing()
        if wrong:
            raise FlashError(f"{wrong[0]} did not arrive as it was sent; check the cable, repeat")
        return len(missing)

    def switch(self) -> None:
        """Let the next start use this firmware: one rename. The present main.py is kept aside."""
        self._feed()
        present = self._board.read(t.MAIN)
        if present is None:
            self._board.remove(OLD_MAIN)
        elif present != self._tree.main:
            self._put(OLD_MAIN, present)
        self._put(t.MAIN, self._tree.main)

    def roll_back(self) -> str:
        """Restore the main.py before, if its firmware is still there; returns what the board has.

        Without a main.py before, the board starts nothing afterwards.
        """
        old = self._board.read(OLD_MAIN)
        if old is None:
            self._board.remove(t.MAIN)
            return "there is none before it on the board, which starts nothing now"
        folder = _folder_of(old)
        if folder and folder not in self._board.folders(t.BASE):
            # A main.py that starts nothing would be no better, and would hide what happened.
            return f"the one before ({folder}) is no longer on the board, so the new one stays"
        self._board.rename(OLD_MAIN, t.MAIN)
        return "the firmware before is back"

    def _put(self, path: str, content: bytes) -> None:
        self._board.write(_NEW_MAIN, content)
        arrived = self._board.read(_NEW_MAIN)
        if arrived is None or sha256(arrived) != sha256(content):
            raise FlashError(f"{path} did not arrive as it was sent; check the cable, repeat")
        self._board.rename(_NEW_MAIN, path)

    def _missing(self) -> list[str]:
        there = self._board.hashes(self._tree.folder)
        return [
            path
            for path, content in self._tree.files.items()
            if there.get(f"{self._tree.folder}/{path}") != sha256(content)
        ]

    # What earlier tries left: firmware that neither main.py names, the coming one's or the one
    # that roll_back goes to. That is the present one, or the one before it when `switch` will
    # find the coming one in place already.
    def _clean(self) -> None:
        keep = {self._tree.name, _folder_of(self._board.read(t.MAIN))}
        if keep == {self._tree.name}:
            keep.add(_folder_of(self._board.read(OLD_MAIN)))
        for name in self._board.folders(t.BASE):
            if name.startswith(t.PREFIX) and name not in keep:
                self._board.remove(f"{t.BASE}/{name}")

    def _feed(self) -> None:
        now_s = time.monotonic()
        if self._watchdog and now_s - self._fed_s > _FEED_S:
            self._fed_s = now_s
            self._board.feed_watchdog()


def _folder_of(main: bytes | None) -> str:
    return t.named_by((main or b"").decode("utf-8", "replace"))
