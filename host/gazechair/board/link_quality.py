"""Rates the link to the board from the times at which frames arrived. Pure: no clock."""

from __future__ import annotations

from dataclasses import dataclass

from gazechair.base import health as h
from gazechair.base.reasons import PARTS

ANSWER_S = 3.0  # a port that answers no HELLO for this long is not the board
BUSY_S = 0.05  # bytes the board has not taken for this long: it does not read
QUIET_S = 0.3
SILENT_S = PARTS["board"].silent_s


@dataclass(frozen=True)
class Verdict:
    """A health state, its reason key and detail, and whether to give this port up."""

    state: str
    reason: str
    detail: str
    give_up: bool = False


class LinkJudge:
    """Watches one opened port at a time; remembers where a board has answered before."""

    def __init__(self, answer_s: float = ANSWER_S) -> None:
        """`answer_s`: how long a port may be silent before it is given up."""
        self._answer_s = answer_s
        self._path = ""
        self._known_path = ""
        self._session = False
        self._received_s = 0.0
        self._differs = ""
        self._failure = ("", "")

    @property
    def answered(self) -> bool:
        """True if a board has answered on the present path, now or earlier."""
        return self._path == self._known_path

    def opened(self, path: str, now_s: float) -> None:
        """The port at `path` was opened."""
        self._path = path
        self._session = False
        self._received_s = now_s
        self._differs = ""
        self._failure = ("", "")

    def began(self, now_s: float) -> None:
        """A session has begun."""
        self._known_path = self._path
        self._session = True
        self._received_s = now_s
        self._differs = ""
        self._failure = ("", "")

    def ended(self, now_s: float) -> None:
        """The session has ended; a handshake runs on the same port."""
        self._session = False
        self._received_s = now_s

    def received(self, now_s: float) -> None:
        """A STATE frame has arrived."""
        self._received_s = now_s

    def differs(self, detail: str, now_s: float) -> None:
        """A board of another version has answered."""
        self._differs = detail
        self._received_s = now_s

    def refuses(self, reason: str, detail: str, now_s: float) -> None:
        """A board without a session reports why it does not start."""
        if not self._session:
            self._failure = (reason, detail)
            self._received_s = now_s

    def verdict(self, unsent_s: float, now_s: float) -> Verdict | None:
        """How the link is at `now_s`; None: as before. `unsent_s`: age of bytes not yet taken."""
        quiet_s = now_s - self._received_s
        if not self._session:
            if quiet_s > self._answer_s:
                return self._no_answer()
            if self._failure[0]:
                return Verdict(h.LOST, *self._failure)
            if self._differs:
                return Verdict(h.LOST, "version_differs", self._differs)
            return None
        if unsent_s > BUSY_S:
            detail = f"the board on {self._path} does not take what is sent to it"
            return Verdict(h.DEGRADED, "board_busy", detail)
        if quiet_s > SILENT_S:
            detail = f"the board on {self._path} has sent no state for {SILENT_S:.0f} s"
            return Verdict(h.LOST, "board_lost", detail)
        if quiet_s > QUIET_S:
            detail = f"the board on {self._path} has gone quiet"
            return Verdict(h.DEGRADED, "board_lost", detail)
        return Verdict(h.OK, "ok", "")

    def _no_answer(self) -> Verdict:
        if self.answered:
            detail = f"the board on {self._path} does not answer any more"
            return Verdict(h.LOST, "board_lost", detail, give_up=True)
        detail = (
            f"{self._path} has not answered as the board for {self._answer_s:.0f} s;"
            " set the right port in the configuration, [board] port, or flash the board"
        )
        return Verdict(h.LOST, "wrong_port", detail, give_up=True)
