"""Sends odometry's inputs to its inbox, and to the inboxes of others that use the same inputs."""

from __future__ import annotations

from collections.abc import Iterable

from gazechair.board.state import BoardState
from gazechair.sensing.inbox.inbox import pack_motion, send
from gazechair.sensing.inbox.motion import Motion

HEADING_LATE_S = 0.02
"""Age of a heading when the host receives it: the sensor's filter and fusion take 10 to 20 ms, its
sample period half of 10 ms. At 24 degrees/s that is half a degree, and twice that between turns
to either side: uncorrected, a lidar would seem to be turned on its mount."""


class Feed:
    """Writes the board's reports to inboxes `fds`; the lidars' child writes half turns."""

    def __init__(self, fds: Iterable[int]) -> None:
        self.fds = tuple(fds)

    def board(self, state: BoardState) -> None:
        """Send the board's report. Never waits."""
        motion = Motion(
            state.received_s - HEADING_LATE_S,
            state.heading_deg if state.heading_known else None,
            state.linear_permille,
            state.turn_permille,
        )
        datagram = pack_motion(motion)
        for fd in self.fds:
            send(fd, datagram)
