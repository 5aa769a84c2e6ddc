"""The caretaker's held button: a step of the first drive moves the chair only while it is pressed.

Letting go, a page that becomes silent or closes, and any stop from anybody end it at once;
a press that has ended never counts again.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from enum import Enum, auto

from gazechair.board.board_commands import STOP_COMMAND, Command
from gazechair.board.state import BoardId, BoardState
from gazechair.commissioning.tune.armed_session import Link
from gazechair.driving.press import Presses
from gazelink import codes


class Pressed(Enum):
    """What a message of a pressed button means."""

    ANEW = auto()
    BEFORE = auto()  # already known, whether it still counts or not
    IN_VAIN = auto()  # somebody else holds a button


class HeldButton:
    """Thread-safe. Times are monotonic seconds."""

    def __init__(
        self, link: Link, clock: Callable[[], float], stopped_s: Callable[[int], float]
    ) -> None:
        """`stopped_s`: when a page or an input, except this client, last sent a stop."""
        self._link = link
        self._clock = clock
        self._stopped_s = stopped_s
        self._began_s = 0.0  # as proven, not received: a stop may have overtaken it
        self._ttl_s = 0.0  # of a proof of holding: the board's own, once received
        self._lock = threading.Lock()
        self._presses = Presses(0)
        self._moved = False  # by the newest press
        self.cap_permille = 1000
        """Limit for all outputs that pass."""

    def press(self, client: int, edge: int, proven_s: float) -> Pressed:
        """The button is pressed, as proven at `proven_s`."""
        board = self._link.board()
        with self._lock:
            if board is not None:
                self._ttl_s = board.limits.command_ttl_ms / 1000
            deadline_s = proven_s + self._ttl_s
            if not self._presses.is_new(client, edge):
                self._presses.refresh(client, edge, deadline_s)
                return Pressed.BEFORE
            if self._lasts():
                return Pressed.IN_VAIN
            self._began_s = self._presses.began_s(client, edge, proven_s)
            self._moved = False
            self._presses.begin(client, edge, deadline_s)
            return Pressed.ANEW

    def came_late(self, client: int, edge: int, proven_s: float) -> None:
        """A message too late to count, but its press began no later."""
        with self._lock:
            self._presses.began_s(client, edge, proven_s)

    def release(self, client: int) -> None:
        """This page's button is released, or the page is gone."""
        with self._lock:
            press = self._presses.now
            if press is not None and press.client == client:
                self._end()

    def end(self) -> None:
        """Somebody sent a stop."""
        with self._lock:
            self._end()

    @property
    def alive(self) -> bool:
        """True while it is pressed."""
        with self._lock:
            return self._lasts()

    def tick(self) -> None:
        """End an expired press, whatever the step's own thread does."""
        with self._lock:
            self._lasts()

    def _lasts(self) -> bool:
        press = self._presses.now
        if press is None or not press.alive:
            return False
        stopped_s = self._stopped_s(press.client)
        if self._clock() < press.deadline_s and stopped_s < self._began_s:
            return True
        self._end()
        return False

    def _end(self) -> None:
        # Sent at once: the step's thread may take a moment to notice.
        if self._presses.now is not None and self._presses.now.alive:
            self._presses.end()
            if self._moved:  # a refused press must not stop anybody else
                self._link.command(STOP_COMMAND)

    # The link for the step's motions: only a stop passes unless the button is held.

    def command(self, command: Command) -> None:
        """The latest command."""
        with self._lock:
            if command.verb == codes.STOP:
                self._link.command(command)
            elif self._lasts() and (press := self._presses.now) is not None:
                self._moved = True
                till_s = min(command.ttl_deadline_s, press.deadline_s)
                cap = min(command.cap_permille, self.cap_permille)
                self._link.command(replace(command, ttl_deadline_s=till_s, cap_permille=cap))

    def order(self, action: int, owner: int) -> None:
        """Arm, disarm."""
        with self._lock:
            if action != codes.ARM or self._lasts():
                self._link.order(action, owner)

    def state(self) -> BoardState | None:
        """The newest state, None while there is no board."""
        return self._link.state()

    def board(self) -> BoardId | None:
        """The board and its limits, None while there is none."""
        return self._link.board()
