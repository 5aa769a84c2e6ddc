"""Cuts a lidar's measurements into half turns and sends them to inboxes, on the lidar's thread."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gazechair.sensing.inbox.inbox import HalfTurn, pack_scan, send
from gazechair.sensing.lidar.nodes import Nodes

HALF_S = 0.05  # at 10 turns a second
_GAP_S = 0.02


class HalfTurns:
    """Feed it nodes as they are decoded."""

    def __init__(self, lidar: int, fds: Sequence[int]) -> None:
        """`lidar`: its index in the configuration; `fds`: the inboxes."""
        self._lidar = lidar
        self._fds = fds
        self._pieces: list[Nodes] = []
        self._count = 0
        self._last_s = 0.0

    def take(self, nodes: Nodes, received_s: float, period_s: float) -> None:
        """Take nodes that were complete at `received_s`; `period_s`: from one node to the next."""
        count = len(nodes)
        if not count:
            return
        if abs(received_s - count * period_s - self._last_s) > _GAP_S:
            self._pieces, self._count = [], 0  # nodes are missing in between
        self._pieces.append(nodes)
        self._count += count
        self._last_s = received_s
        if self._count * period_s < HALF_S:
            return
        half = HalfTurn(
            self._lidar,
            np.concatenate([one.angles_deg for one in self._pieces]),
            np.concatenate([one.distances_m for one in self._pieces]),
            received_s - (self._count - 1) * period_s,
            received_s,
        )
        self._pieces, self._count = [], 0
        datagram = pack_scan(half)
        for fd in self._fds:
            send(fd, datagram)
