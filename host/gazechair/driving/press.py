"""The press that moves the chair: its board edge, its time to live, its end. Pure."""

from __future__ import annotations

from dataclasses import dataclass, replace

from gazechair.board.board_commands import STOP_COMMAND, Command
from gazechair.driving.messages import Drive


@dataclass(frozen=True)
class _Press:
    client: int
    page_edge: int
    command: Command
    alive: bool  # may still be refreshed


class CurrentPress:
    """At most one. All times are monotonic seconds."""

    def __init__(self, last_edge: int) -> None:
        """`last_edge`: board edges continue from here, 0..255."""
        self._last_edge = last_edge
        self._press: _Press | None = None
        self._pages_edge = (0, 0, 0)  # board edge, client, page edge: to answer in page edges

    @property
    def command(self) -> Command:
        """What the board receives."""
        return STOP_COMMAND if self._press is None else self._press.command

    def of(self, client: int) -> bool:
        """True if the press is this client's."""
        return self._press is not None and self._press.client == client

    def page_edge(self, client: int, board_edge: int) -> int:
        """The page's own edge of the press that the board calls `board_edge`, 0 for none."""
        edge, of_client, page_edge = self._pages_edge
        return page_edge if client == of_client and board_edge == edge != 0 else 0

    def begin(
        self, client: int, wish: Drive, role: int, deadline_s: float, board_edge: int
    ) -> None:
        """A new press; `board_edge` is the edge the board last took."""
        edge = self._last_edge % 255 + 1
        if edge == board_edge:
            edge = edge % 255 + 1  # the board knows it from another host's life
        self._last_edge = edge
        command = Command(
            wish.verb,
            wish.mode,
            edge,
            role,
            deadline_s,
            wish.linear_permille,
            wish.turn_permille,
        )
        self._press = _Press(client, wish.edge, command, alive=True)
        self._pages_edge = (edge, client, wish.edge)

    def refresh(self, wish: Drive, deadline_s: float) -> bool:
        """The owner keeps pressing; False when that press has ended. A changed motion ends it."""
        press = self._press
        if press is None or press.page_edge != wish.edge or not press.alive:
            return False
        if (press.command.verb, press.command.mode) != (wish.verb, wish.mode):
            self.stop()
            return False
        command = replace(
            press.command,
            ttl_deadline_s=max(press.command.ttl_deadline_s, deadline_s),
            linear_permille=wish.linear_permille,
            turn_permille=wish.turn_permille,
        )
        self._press = replace(press, command=command)
        return True

    def stop(self) -> None:
        """The board must receive a stop."""
        self._press = None

    def end(self) -> None:
        """The press is not active any more, but stays the last command.

        Without time to live: a step may finish, and the board continues to explain why it
        overruled this press until the page releases it.
        """
        if self._press is not None and self._press.alive:
            command = replace(self._press.command, ttl_deadline_s=0.0)
            self._press = replace(self._press, command=command, alive=False)

    def tick(self, now_s: float) -> None:
        """Let time act."""
        if self._press is not None and now_s >= self._press.command.ttl_deadline_s:
            self.end()
