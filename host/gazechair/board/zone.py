"""Collects the stopping values that the board sends for each direction until all are known.
Pure.
"""

from __future__ import annotations

from dataclasses import dataclass

from gazelink import codes


@dataclass(frozen=True)
class BoardZone:
    """How the board stops."""

    points: tuple[bytes, ...]
    """Of each direction, as in gazelink.zone; none while that is not known."""


NOT_KNOWN = BoardZone(())


class ReceivedZone:
    """The board repeats each direction; it sends changes at once."""

    def __init__(self) -> None:
        self._points: dict[int, bytes] = {}
        self._newest = NOT_KNOWN

    def forget(self) -> None:
        """A session has begun or settings have changed: earlier values do not count any more."""
        self._points.clear()
        self._newest = NOT_KNOWN

    def received(self, direction: int, points: bytes) -> BoardZone | None:
        """A ZONE frame; what is now known, None when it is not all, or nothing new."""
        if direction >= len(codes.DIRECTIONS):
            return None
        self._points[direction] = points
        if len(self._points) < len(codes.DIRECTIONS):
            return None
        found = BoardZone(tuple(self._points[at] for at in range(len(codes.DIRECTIONS))))
        if found == self._newest:
            return None
        self._newest = found
        return found
