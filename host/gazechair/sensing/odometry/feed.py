"""What odometry goes by, sent to its inbox, and to that of everyone else who wants the same."""

from __future__ import annotations

from collections.abc import Iterable

from gazechair.board.state import BoardState
from gazechair.sensing.odometry.inbox import pack_motion, send
from gazechair.sensing.odometry.odometry import Motion

HEADING_LATE_S = 0.02
"""So old is a heading when the host has it: the sensor's filter and fusion take 10 to 20 ms, its
sample period half of 10 ms. At 24 degrees/s that is half a degree, twice that between turns to
either side: without it a lidar seems to be turned on its mount."""


class Feed:
    """Inboxes: the lidars' child writes half turns to `fds` by itself, the board's word is here."""

    def __init__(self, fds: Iterable[int]) -> None:
        self.fds = tuple(fds)

    def board(self, state: BoardState) -> None:
        """What the board said. Never waits."""
        motion = Motion(
            state.received_s - HEADING_LATE_S,
            state.heading_deg if state.heading_known else None,
            state.linear_permille,
            state.turn_permille,
        )
        datagram = pack_motion(motion)
        for fd in self.fds:
            send(fd, datagram)
