"""Which connection closes when a role's connections are used up. Pure.

One device has at most one connection fewer than the limit. When all are used, a new device gets one
from a device that has at least two more; another device never closes the page that drives.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

Page = TypeVar("Page")


class Full(Exception):
    """Raised when all seats are taken by devices with an equal claim."""


@dataclass(frozen=True)
class Seat(Generic[Page]):
    """One connected page."""

    page: Page
    device_id: str
    heard_s: float
    """When it last sent anything: the most silent closes first."""
    drives: bool = False


def makes_way(seats: Sequence[Seat[Page]], most: int, device_id: str) -> Page | None:
    """The one of `seats` of a role, at most `most`, that closes for a device's new page, or None.

    Raises Full.
    """
    own = [seat for seat in seats if seat.device_id == device_id]
    if len(own) >= most - 1:
        return _first_to_go(own).page
    if len(seats) < most:
        return None
    pages = Counter(seat.device_id for seat in seats)
    others = [s for s in seats if pages[s.device_id] >= len(own) + 2 and not s.drives]
    if others or own:
        return _first_to_go(others or own).page
    raise Full


def _first_to_go(seats: Sequence[Seat[Page]]) -> Seat[Page]:
    return min(seats, key=lambda seat: (seat.drives, seat.heard_s))
