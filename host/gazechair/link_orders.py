"""Orders on their way to the board: each repeated so that loss does not matter, never queued up."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gazelink import codes

REPEAT_PERIOD_S = 0.02
REPEAT_FOR_S = 0.2
EMERGENCY_FOR_S = 2.0


@dataclass(frozen=True)
class Order:
    """One order. The board acts once on each new number."""

    action: int
    owner: int
    number: int
    given_s: float

    @property
    def ends_s(self) -> float:
        """When to give up repeating it."""
        emergency = self.action == codes.EMERGENCY_STOP
        return self.given_s + (EMERGENCY_FOR_S if emergency else REPEAT_FOR_S)


class Orders:
    """The order being repeated. A newer one takes its place.

    An emergency stop gives way to nothing until the board confirms it: what is given meanwhile
    is dropped, as the board would refuse it.
    """

    def __init__(self, last_number: int) -> None:
        """`last_number`: where numbering goes on, 1..255; random, unlike a former host's."""
        self._number = last_number
        self._order: Order | None = None
        self._next_s = math.inf

    def give(self, action: int, owner: int, now_s: float) -> None:
        """Give a new order (codes.DISARM, ...) on behalf of `owner`."""
        order = self._order
        if order is not None and order.action == codes.EMERGENCY_STOP and now_s < order.ends_s:
            return
        self._number = self._number % 255 + 1  # 0 is none
        self._order = Order(action, owner, self._number, now_s)
        self._next_s = now_s

    def emergency_seen(self) -> None:
        """The board has the emergency stop: no need to repeat it."""
        if self._order is not None and self._order.action == codes.EMERGENCY_STOP:
            self._order = None
            self._next_s = math.inf

    def due(self, now_s: float) -> Order | None:
        """The order to send now, or None."""
        if self._order is None or now_s < self._next_s:
            return None
        if now_s > self._order.ends_s:
            self._order = None
            self._next_s = math.inf
            return None
        self._next_s = now_s + REPEAT_PERIOD_S
        return self._order

    def due_s(self) -> float:
        """When the next repeat is due; infinity when there is none."""
        return self._next_s
