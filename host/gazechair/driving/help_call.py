"""The driver's call for help, and the caretaker who has answered it. Pure."""

from __future__ import annotations

from gazechair.driving.messages import Call
from gazechair.driving.refusal import Refusal
from gazelink import codes

COMING_S = 600.0  # an answer lasts this long; then the driver must call again


class HelpCall:
    """One call at a time. It outlasts the page that called: its tablet may go dark."""

    def __init__(self) -> None:
        self.on = False
        """True while the driver calls for help and no caretaker has answered."""
        self.count = 0  # calls so far
        self._coming_till_s: float | None = None

    def coming(self, now_s: float) -> bool:
        """True if a caretaker has answered the driver's call, and is coming."""
        return self._coming_till_s is not None and now_s < self._coming_till_s

    def restore(self, on: bool, answered_s: float | None) -> None:
        """Continue after a restart; `answered_s`: when a caretaker answered, None: not answered."""
        self.on = on
        self._coming_till_s = None if answered_s is None else answered_s + COMING_S

    def answer(self, now_s: float) -> None:
        """A caretaker has answered the driver's call elsewhere than on a page's socket."""
        if self.on:
            self.on = False
            self._coming_till_s = now_s + COMING_S

    def receive(self, role: int, message: Call, now_s: float) -> Refusal | None:
        """A caretaker answers a call, then reports their arrival; the driver can cancel it."""
        if role != codes.DRIVER:
            if message.on:
                return Refusal("call", "not_allowed", "only the driver calls; a caretaker ends it")
            # A call made while a caretaker is with the driver counts as answered.
            if self.on:
                self.answer(now_s)
            elif message.there:
                self._coming_till_s = None
            # Else it is an answer given twice, or by two caretakers: the first stands.
            return None
        self._coming_till_s = None
        self.on, self.count = message.on, self.count + (message.on and not self.on)
        return None
