"""The caretaker's bypass button, as the board receives it. Pure."""

from __future__ import annotations

from gazechair.board.board_commands import Bypass
from gazechair.driving.press import Presses
from gazechair.driving.refusal import Refusal


class BypassButton(Presses):
    """Pressed while its messages arrive in time; see Presses."""

    def __init__(self, last_number: int) -> None:
        super().__init__(last_number)
        self._refused: dict[int, int] = {}  # edge of each client's newest refused press

    @property
    def sent(self) -> Bypass | None:
        """What the board receives, None: it is not pressed."""
        press = self.now
        return Bypass(press.number, press.deadline_s) if press and press.alive else None

    def hold(self, client: int, edge: int, deadline_s: float, new: bool) -> Refusal | None:
        """Pressed until `deadline_s`; `new`: see is_new. A press that has ended is refused once."""
        if new:
            self.begin(client, edge, deadline_s)
            return None
        if self.refresh(client, edge, deadline_s) or self._refused.get(client) == edge:
            return None
        self._refused[client] = edge
        detail = "this press of the bypass has ended; release and press again"
        return Refusal("bypass", "needs_new_command", detail)

    def gone(self, client: int) -> None:
        """This client has left."""
        super().gone(client)
        self._refused.pop(client, None)
