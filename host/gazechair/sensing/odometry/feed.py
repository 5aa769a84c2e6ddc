"""What odometry goes by, sent to its inbox, and to that of everyone else who wants the same."""

from __future__ import annotations

from collections.abc import Iterable

from gazechair.board.state import BoardState
from gazechair.sensing.odometry.inbox import pack_motion, send
from gazechair.sensing.odometry.odometry import Motion


class Feed:
    """Inboxes: the lidars' child writes half turns to `fds` by itself, the board's word is here."""

    def __init__(self, fds: Iterable[int]) -> None:
        self.fds = tuple(fds)

    def board(self, state: BoardState) -> None:
        """What the board said. Never waits."""
        motion = Motion(
            state.received_s,
            state.heading_deg if state.heading_known else None,
            state.linear_permille,
            state.turn_permille,
        )
        datagram = pack_motion(motion)
        for fd in self.fds:
            send(fd, datagram)
