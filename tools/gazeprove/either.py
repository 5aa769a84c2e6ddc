"""One of two numbers, chosen when somebody asks for something that depends on which it is.

A tick that never asks is one tick for both: what it did and what held after it is the same for
either number, and only what it leads to differs. So two counters of which nobody asks are tried in
one tick instead of four, and nothing is left out: every answer that would differ is a choice, and
every choice is visited. What is not defined here (a hash, a product, an index) raises TypeError.
"""

from __future__ import annotations

from gazeprove.inputs import Choices


class Coin:
    """Which of two it is: -1 while nobody has asked, else 0 or 1."""

    __slots__ = ("_choices", "side")

    def __init__(self, choices: Choices) -> None:
        self._choices = choices
        self.side = -1

    def toss(self) -> int:
        """The side on which it lies, from now on."""
        if self.side < 0:
            self.side = self._choices.pick(2)
        return self.side


class Either:
    """The number `low`, or `high`, as the coin falls."""

    __slots__ = ("coin", "high", "low")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, coin: Coin, low: int, high: int) -> None:
        self.coin = coin
        self.low = low
        self.high = high

    def seen(self) -> int | tuple[int, int]:
        """The number; both while nobody has asked."""
        side = self.coin.side
        if side < 0:
            return self.low, self.high
        return self.high if side else self.low

    def _answer(self, low: bool, high: bool) -> bool:
        """What is true of it, when these are true of the two."""
        if low == high:
            return low
        return high if self.coin.toss() else low

    def __add__(self, number: int) -> Either:
        return Either(self.coin, self.low + number, self.high + number)

    def __sub__(self, number: int) -> Either:
        return Either(self.coin, self.low - number, self.high - number)

    def __bool__(self) -> bool:
        return self._answer(self.low != 0, self.high != 0)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Either):
            if other.coin is not self.coin:
                raise TypeError("two numbers that do not depend on each other")
            return self._answer(self.low == other.low, self.high == other.high)
        return self._answer(self.low == other, self.high == other)

    def __lt__(self, number: int) -> bool:
        return self._answer(self.low < number, self.high < number)

    def __le__(self, number: int) -> bool:
        return self._answer(self.low <= number, self.high <= number)

    def __gt__(self, number: int) -> bool:
        return self._answer(self.low > number, self.high > number)

    def __ge__(self, number: int) -> bool:
        return self._answer(self.low >= number, self.high >= number)
