"""Presses: numbered for the board, alive while proven, never revived once ended. Pure."""

from __future__ import annotations

from dataclasses import dataclass, replace

from gazechair.board.board_commands import STOP_COMMAND, Command
from gazechair.driving.messages import Drive, UseMode
from gazelink import codes


@dataclass(frozen=True)
class Press:
    """One press, as sent to the board."""

    client: int
    page_edge: int
    number: int
    """The board's edge, 1..255."""
    deadline_s: float
    """When it ends unless proven again."""
    alive: bool = True


class Presses:
    """Presses of one button, or of everything that drives, one at a time; times: monotonic s.

    One that ended, for any reason, never returns: only a higher edge of its page is a new one.
    """

    def __init__(self, last_number: int) -> None:
        """`last_number`: the board's numbers continue from here, 0..255; random at each start."""
        self._last_number = last_number
        self._newest: dict[int, int] = {}  # edge of each client, whether it began or not
        self._began: dict[int, tuple[int, float]] = {}  # newest edge received, first proven
        self.now: Press | None = None
        """The newest, dead or alive; None: none is sent to the board."""

    def is_new(self, client: int, edge: int) -> bool:
        """True for the first message of a press: the caller begins it now or never."""
        if edge <= self._newest.get(client, 0):
            return False
        self._newest[client] = edge
        return True

    def began_s(self, client: int, edge: int, proven_s: float) -> float:
        """When this press began: the earliest that its messages, too late or not, have proven."""
        newest, began_s = self._began.get(client, (0, proven_s))
        began_s = min(began_s, proven_s) if edge == newest else proven_s
        if edge >= newest:
            self._began[client] = edge, began_s
        return began_s

    def begin(self, client: int, edge: int, deadline_s: float, board_number: int = 0) -> None:
        """A new press; `board_number`: the board's last accepted, perhaps from another host."""
        self.now = Press(client, edge, self.next_number(board_number), deadline_s)

    def next_number(self, board_number: int = 0) -> int:
        """The board's number for the next press, of a page or not; see begin()."""
        number = self._last_number % 255 + 1  # 0 is none
        if number == board_number:
            number = number % 255 + 1
        self._last_number = number
        return number

    def refresh(self, client: int, edge: int, deadline_s: float) -> bool:
        """Still pressed, proven until `deadline_s`; False when that press has ended."""
        press = self.now
        if press is None or not press.alive or (press.client, press.page_edge) != (client, edge):
            return False
        self.now = replace(press, deadline_s=max(press.deadline_s, deadline_s))
        return True

    def end(self) -> None:
        """End the press; it stays the newest."""
        if self.now is not None and self.now.alive:
            self.now = replace(self.now, deadline_s=0.0, alive=False)

    def drop(self) -> None:
        """End the press, and remove it from what the board receives."""
        self.now = None

    def release(self, client: int) -> None:
        """This client has released; another's press stays."""
        if self.now is not None and self.now.client == client:
            self.drop()

    def gone(self, client: int) -> None:
        """This client has left."""
        self.release(client)
        self._newest.pop(client, None)
        self._began.pop(client, None)

    def tick(self, now_s: float) -> None:
        """End an expired press."""
        if self.now is not None and now_s >= self.now.deadline_s:
            self.end()


_WAITS = (
    codes.NO_REASON,
    *range(codes.OBSTACLE_FORWARD, codes.OBSTACLE_RIGHT + 1),
    codes.ABOVE_CREEP,
)


class DrivingPress(Presses):
    """The press that moves the chair, and its command."""

    def __init__(self, last_number: int) -> None:
        super().__init__(last_number)
        self._command = STOP_COMMAND
        self._pages_edge = (0, 0, 0)  # board edge, client, page edge: to answer in page edges
        self.mode = ""
        """The mode that this press is on, "" for none."""
        self._mode_till_s = 0.0  # when the mode's last answer expires
        self._auto = False
        self._begun = False  # the board has reported it: an auto motion asks for nothing before
        self._watched = (codes.NOBODY, 0.0)  # who supervises it, and the time of the last proof
        self.unfinished = ""
        """The mode of the newest auto motion until that ends by itself."""

    @property
    def command(self) -> Command:
        """What the board receives.

        The command of an ended press stays, without time to live: a step may finish, and the board
        keeps reporting why it overruled this press until the page releases it.
        """
        if self.now is None or self._command.verb == codes.STOP:
            return STOP_COMMAND
        deadline_s = self.now.deadline_s
        if self.mode:
            deadline_s = min(deadline_s, self._mode_till_s)
        watcher, watched_s = self._watched if self._auto else (codes.NOBODY, 0.0)
        command = self._command
        if self._auto and not self._begun:
            # One that asks for a blocked motion at once would be spent, and wait for nothing.
            command = replace(command, linear_permille=0, turn_permille=0)
        return replace(
            command,
            edge=self.now.number,
            ttl_deadline_s=deadline_s,
            watcher=watcher,
            watched_s=watched_s,
        )

    @property
    def auto(self) -> bool:
        """True if the press is alive, and nobody holds it."""
        return self._auto and self.now is not None and self.now.alive

    @auto.setter
    def auto(self, auto: bool) -> None:
        self._auto, self._begun = auto, False
        if auto:
            self.unfinished = self.mode
        self._watched = (codes.NOBODY, 0.0)

    def watch(self, role: int, proven_s: float) -> None:
        """Somebody supervised it at `proven_s`."""
        if self.auto and proven_s > self._watched[1]:
            self._watched = role, proven_s

    def pressed(self) -> None:
        """Anything else was pressed, by anyone: an auto motion is over."""
        if self.auto:
            self.drop()

    def overruled(self, board_edge: int, override: int) -> None:
        """The board's override of its newest press: an auto motion waits only for obstacles."""
        if self.auto and self.now is not None and self.now.number == board_edge:
            # Overruled before its first request (the chair still rolls): it never began.
            waits = override == codes.NO_REASON or (self._begun and override in _WAITS)
            self._begun = True
            if not waits:
                self.end()

    def come_to_its_end(self, reached: bool) -> None:
        """The mode has ended: end an auto motion, which has no button to release."""
        if self.auto:
            self.unfinished = "" if reached else self.mode
            self.drop()
        else:
            self.end()

    def release(self, client: int) -> None:
        if not self.auto:  # an auto motion is not held
            super().release(client)

    def gone(self, client: int) -> None:
        if self.now is not None and self.now.client == client:
            self.drop()
        super().gone(client)

    def page_edge(self, client: int, board_edge: int) -> int:
        """The page's own edge of the press that is `board_edge` on the board, 0 for none."""
        edge, of_client, page_edge = self._pages_edge
        return page_edge if client == of_client and board_edge == edge != 0 else 0

    def drive(
        self, client: int, message: Drive, role: int, deadline_s: float, board_edge: int
    ) -> None:
        """A new press; `board_edge` is the edge that the board last accepted."""
        self.begin(client, message.edge, deadline_s, board_edge)
        self.mode = ""
        self.auto = False
        self._command = Command(
            message.verb, message.mode, 0, role, 0.0, message.linear_permille, message.turn_permille
        )
        self._pages_edge = (self._last_number, client, message.edge)

    def drive_by(
        self,
        client: int,
        message: UseMode,
        role: int,
        deadline_s: float,
        board_edge: int,
        answer_s: float,
    ) -> None:
        """A new press on a mode, which must answer by `answer_s`; until then the chair stands."""
        self.begin(client, message.edge, deadline_s, board_edge)
        self.mode = message.mode
        self._mode_till_s = answer_s
        self._command = replace(STOP_COMMAND, owner=role)
        self._pages_edge = (self._last_number, client, message.edge)

    def drive_by_on(self, client: int, message: UseMode, deadline_s: float) -> bool:
        """The owner keeps pressing the mode; False when that press has ended."""
        if self.refresh(client, message.edge, deadline_s) and self.mode == message.mode:
            return True
        self.release(client)
        return False

    def steer(self, linear_permille: int, turn_permille: int, till_s: float) -> None:
        """The output of the live press's mode, valid until `till_s`."""
        self._mode_till_s = till_s
        self._command = replace(
            self._command,
            verb=codes.DRIVE,
            mode=codes.AUTO if self._auto else codes.CONTINUOUS,
            linear_permille=linear_permille,
            turn_permille=turn_permille,
        )

    def tick(self, now_s: float) -> None:
        """End an expired press, or an expired answer of its mode."""
        if self.mode and now_s >= self._mode_till_s:
            self.end()
        super().tick(now_s)

    def drive_on(self, client: int, message: Drive, deadline_s: float) -> bool:
        """The owner keeps pressing; False when that press has ended. A changed motion ends it."""
        if not self.refresh(client, message.edge, deadline_s):
            return False
        if self.mode or (self._command.verb, self._command.mode) != (message.verb, message.mode):
            self.drop()
            return False
        self._command = replace(
            self._command,
            linear_permille=message.linear_permille,
            turn_permille=message.turn_permille,
        )
        return True
