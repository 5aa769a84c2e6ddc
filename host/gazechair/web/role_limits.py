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
    """Raised when all connections are taken by devices with an equal claim."""


@dataclass(frozen=True)
class ConnectedPage(Generic[Page]):
    """One connected page."""

    page: Page
    device_id: str
    received_s: float
    """When it last sent anything: the most silent closes first."""
    drives: bool = False


def makes_way(connected: Sequence[ConnectedPage[Page]], most: int, device_id: str) -> Page | None:
    """Of a role's `connected` pages, at most `most`, the one that closes for a device's new one.

    None: none has to close. Raises Full.
    """
    own = [one for one in connected if one.device_id == device_id]
    if len(own) >= most - 1:
        return _first_to_go(own).page
    if len(connected) < most:
        return None
    pages = Counter(one.device_id for one in connected)
    others = [s for s in connected if pages[s.device_id] >= len(own) + 2 and not s.drives]
    if others or own:
        return _first_to_go(others or own).page
    raise Full


def _first_to_go(connected: Sequence[ConnectedPage[Page]]) -> ConnectedPage[Page]:
    return min(connected, key=lambda one: (one.drives, one.received_s))
