"""Assist's child process: reads the lidars' data, and advises while Vooruit is pressed."""

from __future__ import annotations

import json
import select
import socket
import sys
import time
from collections.abc import Mapping
from typing import Any, NoReturn

from gazechair.assist.assist import Assist
from gazechair.assist.message import Message, unpack
from gazechair.base.child_main import child_main
from gazechair.base.child_records import RecordWriter
from gazechair.base.newest_line import NewestLine
from gazechair.config.settings import FootprintConfig
from gazechair.sensing.clearance.evaluate import footprint_of
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Lidars

_EVERY_S = 0.05
_PULSE_S = 0.25  # while the driver holds no button
_OLD_S = 0.2  # older data in the inbox is useless


class Advisor:
    """Assist of one chair, fed with datagrams and the daemon's messages. No clock, no process."""

    def __init__(self, argument: Mapping[str, Any]) -> None:
        """`argument`: lidars and footprint, as the daemon has them."""
        self._lidars = Lidars.of(argument["lidars"])
        fields = argument["footprint"]
        corners = tuple(tuple(corner) for corner in fields["corners_m"])
        footprint = footprint_of(FootprintConfig(**{**fields, "corners_m": corners}))
        self._assist = Assist(footprint, len(argument["lidars"]))
        self._message = Message()
        self._turned = 0  # side of a turn that was active since the last decision
        self._heading_known = True  # by the newest motion
        self._straight = 0  # press not to steer: its heading was lost, or its beginning not seen
        self._informed = False  # True once the daemon has sent a message

    @property
    def is_active(self) -> bool:
        """True while assist has something to decide: the driver holds forward or a turn."""
        return self._message.on and (self._message.press > 0 or self._message.turns != 0)

    def take_message(self, line: bytes) -> None:
        """The daemon's newest message. A malformed one is ignored."""
        try:
            message, zone = unpack(line)
        except ValueError:
            return
        if message.zone != self._message.zone:
            self._assist.permits.zone = zone
        self._message = message
        if not self._informed:
            self._informed, self._straight = True, message.press
        elif message.turns or message.press not in (0, self._straight):
            self._straight = 0  # that press is over, and another one will have its number
        self._no_turns_without_heading()
        self._turned = message.turns or self._turned
        self._assist.permits.clearance = message.clearance

    def take(self, datagram: bytes, now_s: float) -> None:
        """One datagram from the inbox."""
        received = inbox.unpack(datagram) if self._message.on else None
        if isinstance(received, Motion) and (
            received.heading_deg is None or received.time_s > now_s - _OLD_S
        ):
            self._assist.motion(received)
            self._heading_known = received.heading_deg is not None
            self._no_turns_without_heading()
        elif isinstance(received, HalfTurn) and received.last_s > now_s - _OLD_S:
            piece = self._lidars.piece(received)
            if piece is not None:
                self._assist.see(received.lidar, piece)

    def report(self, now_s: float) -> list[Any]:
        """To send: [can advise, press, linear, turn, steers, waits, monotonic s].

        Press 0: no advice.
        """
        message = self._message
        ready = message.on and self._assist.ready(now_s)
        if self._turned:  # even if the board ended it at once
            self._assist.driver_turns(self._turned, now_s)
        self._turned = message.turns
        steers = ready and message.press not in (0, self._straight)
        advice = self._assist.advise(message.press, now_s) if steers else None
        if advice is None:
            return [ready, 0, 0, 0, False, False, now_s]
        motion = advice.linear_permille, advice.turn_permille
        return [ready, message.press, *motion, advice.steers, advice.waits, now_s]

    def _no_turns_without_heading(self) -> None:
        if not self._heading_known and self._message.press:
            self._straight = self._message.press


def run(argument: Mapping[str, Any], out: RecordWriter) -> NoReturn:
    """Serve until the parent closes the pipe (BrokenPipeError)."""
    advisor = Advisor(argument)
    fd = int(argument["fd"])
    reader = socket.socket(fileno=fd)
    reader.setblocking(False)
    lines = NewestLine()
    sent_s = 0.0
    while True:
        now_s = time.monotonic()
        due_s = sent_s + (_EVERY_S if advisor.is_active else _PULSE_S)
        if now_s >= due_s:
            out.data(json.dumps(advisor.report(now_s)).encode())
            sent_s = now_s
            continue
        ready = select.select([fd, 0], [], [], due_s - now_s)[0]
        if 0 in ready:
            line = lines.read()
            if line is not None:
                advisor.take_message(line)
        if fd in ready:
            advisor.take(reader.recv(inbox.LONGEST), time.monotonic())


def main() -> int:
    """Entry of `python -m gazechair.assist.child JSON`: lidars, footprint, fd."""
    return child_main(run)


if __name__ == "__main__":
    sys.exit(main())
