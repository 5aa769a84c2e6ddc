"""Orders to the board: each is repeated so that loss does not matter, and never queued."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from gazelink import codes

REPEAT_PERIOD_S = 0.02
REPEAT_FOR_S = 0.2
CONFIRM_FOR_S = 2.0

# The most urgent first. What the two that stop the chair take away, and what they must see done.
_SEQUENCE = (codes.EMERGENCY_STOP, codes.DISARM, codes.RESET_FAULTS, codes.ARM)
_ENDED_BY = {
    codes.EMERGENCY_STOP: (codes.RESET_FAULTS, codes.ARM),
    codes.DISARM: (codes.ARM,),
}


@dataclass(frozen=True)
class Order:
    """One order. The board acts once on each new number of its kind."""

    action: int
    owner: int
    number: int
    given_s: float
    done: bool = False
    """The board has been seen as this order wants it."""

    def over(self, now_s: float) -> bool:
        """Whether to stop repeating it: one that stops the chair is repeated until it is done."""
        if self.action == codes.EMERGENCY_STOP and self.done:
            return True
        waits = self.action in _ENDED_BY and not self.done
        return now_s > self.given_s + (CONFIRM_FOR_S if waits else REPEAT_FOR_S)


class Orders:
    """The orders being repeated, one of each kind: none replaces another.

    Disarming ends an order to arm given before it, never one given after it. An emergency stop
    has priority until the board confirms it: other orders until then are dropped, as the
    board would refuse them.
    """

    def __init__(self, last_number: int) -> None:
        """`last_number`: where numbering continues, 1..255; random, unlike an earlier host's."""
        self._numbers = dict.fromkeys(_SEQUENCE, last_number)
        self._orders: dict[int, Order] = {}
        self._next_s = math.inf

    def give(self, action: int, owner: int, now_s: float) -> None:
        """Give a new order (codes.DISARM, ...) on behalf of `owner`."""
        emergency = self._orders.get(codes.EMERGENCY_STOP)
        if emergency is not None and not emergency.over(now_s) and action not in _ENDED_BY:
            return
        for ended in _ENDED_BY.get(action, ()):
            self._orders.pop(ended, None)
        number = self._numbers[action] % 255 + 1  # 0 is none
        self._numbers[action] = number
        self._orders[action] = Order(action, owner, number, now_s)
        self._next_s = now_s

    def begin(self) -> None:
        """A session has begun, with a disarmed chair: only an emergency stop is repeated."""
        emergency = self._orders.get(codes.EMERGENCY_STOP)
        self._orders = {} if emergency is None else {codes.EMERGENCY_STOP: emergency}

    def board_seen(self, disarmed: bool, emergency: bool) -> None:
        """The board's own state: what has been done need not be repeated any longer."""
        for action, done in ((codes.DISARM, disarmed), (codes.EMERGENCY_STOP, emergency)):
            if done and action in self._orders:
                self._orders[action] = replace(self._orders[action], done=True)

    def due(self, now_s: float) -> list[Order]:
        """The orders to send now, the most urgent first."""
        if now_s < self._next_s:
            return []
        self._orders = {a: order for a, order in self._orders.items() if not order.over(now_s)}
        self._next_s = now_s + REPEAT_PERIOD_S if self._orders else math.inf
        return [self._orders[action] for action in _SEQUENCE if action in self._orders]

    def due_s(self) -> float:
        """When the next repeat is due; infinity when there is none."""
        return self._next_s
