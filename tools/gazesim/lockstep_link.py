"""The host's BoardLink in virtual time: its protocol at the end of a line, without a thread."""

from __future__ import annotations

from collections.abc import Callable

from gazechair.board.board_commands import Bypass, Clearance, Command
from gazechair.board.events import FaultText, SessionBegun, SessionEnded, SettingReply
from gazechair.board.protocol import LinkProtocol, Witness
from gazechair.board.state import BoardId, BoardState, BoardStats
from gazechair.board.zone import NOT_KNOWN, BoardZone
from gazesim.usb_line import UsbLine

_SEARCH_MS = 100  # between two looks for the port
_READ_SIZE = 1024


class LockstepLink:
    """The host's BoardLink in virtual time: one port, nothing queued but an unsent frame."""

    def __init__(
        self,
        line: UsbLine,
        clock: Callable[[], float],
        draw: Callable[[], int],
        witness: Witness = lambda _way, _now_s, _frame: None,
        traced: bool = False,
    ) -> None:
        self._line = line
        self._clock = clock
        self.protocol = LinkProtocol(draw, witness, traced)
        self.alive = True  # False: its host has died
        self._unsent = b""
        self._open = False
        self._search_in_ms = 1
        self._state: BoardState | None = None
        self._stats: BoardStats | None = None
        self.on_zone: Callable[[BoardZone], None] = lambda _zone: None
        self.sessions = 0
        self.last_words: list[str] = []
        self.reply: SettingReply | None = None  # the newest about a setting

    # What Control asks of a link

    def command(self, command: Command) -> None:
        self.protocol.command(command, self._clock())
        self._flush()

    def order(self, action: int, owner: int) -> None:
        self.protocol.order(action, owner, self._clock())
        self._flush()

    def clearance(self, clearance: Clearance) -> None:
        self.protocol.clearance(clearance, self._clock())
        self._flush()

    def bypass(self, bypass: Bypass | None) -> None:
        self.protocol.bypass(bypass, self._clock())
        self._flush()

    def state(self) -> BoardState | None:
        return self._state

    def stats(self) -> BoardStats | None:
        return self._stats

    def board(self) -> BoardId | None:
        return self.protocol.board

    # Its thread

    def one_ms(self) -> None:
        """One pass of BoardLink's thread."""
        if not self.alive:
            return
        if not self._open:
            self._search_in_ms -= 1
            if self._search_in_ms <= 0 and self._line.plugged:
                self._open = self._line.host_reads = True
                self._unsent = b""
                self.protocol.opened(self._clock())
        if self._open and not self._line.plugged:
            self.close()
            self.protocol.opened(self._clock())
            self._state = None
            self.on_zone(NOT_KNOWN)
        if not self._open:
            return
        now_s = self._clock()
        data = self._line.to_host.take(_READ_SIZE)
        for event in [*self.protocol.feed(data, now_s), *self.protocol.check(now_s)]:
            if isinstance(event, BoardState):
                self._state = event
            elif isinstance(event, SessionBegun):
                self.sessions += 1
            elif isinstance(event, BoardStats):
                self._stats = event
            elif isinstance(event, SessionEnded):
                self._state = None
                self.on_zone(NOT_KNOWN)
            elif isinstance(event, SettingReply):
                self.reply = event
            elif isinstance(event, BoardZone):
                self.on_zone(event)
            elif isinstance(event, FaultText):
                self.last_words.append(event.reason)
        self._flush()

    def close(self) -> None:
        """Close the port, by ourselves or because it vanished."""
        self._open = self._line.host_reads = False
        self._search_in_ms = _SEARCH_MS

    def _flush(self) -> None:
        if not self.alive or not self._open or not self._line.plugged:
            return
        if not self._unsent:
            self._unsent = self.protocol.poll(self._clock())
        taken = self._unsent[: self._line.to_board.room()]
        if taken:
            self._line.to_board.put(taken, self._line.now_ms)
            self._unsent = self._unsent[len(taken) :]
