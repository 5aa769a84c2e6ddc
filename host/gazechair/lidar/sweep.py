"""The newest full turn of the lidar, assembled on the S flag and renewed with every few nodes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from gazechair.lidar.nodes import FloatArray, Nodes, wrapped_steps
from gazechair.lidar.scan import Scan
from gazelink import codes

NODE_PERIOD_S = 1.0 / 16_000.0  # standard scan: 16 kHz
_MAX_TURN_NODES = 8_000  # half a second: the S flag was lost several times over


class Sweep:
    """Joins the turn in progress with the part of the turn before it that it has not yet reached.

    This gives an obstacle flag some 25 ms after its beam, instead of up to a whole turn later.
    """

    def __init__(self, source: int = codes.SIMULATED) -> None:
        """`source` marks the scans; behind anything but codes.REAL a real board never arms."""
        self.turns = 0
        self._source = source
        self._previous = _Turn()
        self._current = _Turn()

    def add(self, nodes: Nodes, received_s: float) -> Scan | None:
        """Take nodes that were whole at `received_s`; the newest scan, None without nodes."""
        if not len(nodes):
            return None
        times_s: FloatArray = received_s - nodes.backlog.astype(np.float64) * NODE_PERIOD_S
        cuts = [0, *np.flatnonzero(nodes.starts).tolist(), len(nodes)]
        for first, last in pairwise(cuts):
            if first < last:
                if nodes.starts[first]:
                    self._previous = self._current
                    self._current = _Turn()
                    self.turns += 1
                piece = slice(first, last)
                self._current.add(nodes.angles_deg[piece], nodes.distances_m[piece], times_s[piece])
        return self._scan()

    def _scan(self) -> Scan:
        angles, distances, times = self._current.joined()
        old_angles, old_distances, old_times = self._previous.joined()
        # Counted along the nodes, so that jitter about the start of the turn is not a whole turn.
        reached_deg = min(max(-float(wrapped_steps(angles).sum()), 0.0), 360.0)
        ahead = (angles[0] - old_angles) % 360.0 > reached_deg  # the mirror turns clockwise
        return Scan(
            np.concatenate((angles, old_angles[ahead])),
            np.concatenate((distances, old_distances[ahead])),
            float(min(times.min(), old_times[ahead].min(initial=np.inf))),
            self._source,
        )


class _Turn:
    def __init__(self) -> None:
        self._pieces: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        self._count = 0

    def add(self, angles: FloatArray, distances: FloatArray, times: FloatArray) -> None:
        self._pieces.append((angles, distances, times))
        self._count += len(angles)
        if self._count > _MAX_TURN_NODES:
            self._pieces = [self._pieces[-1]]
            self._count = len(angles)

    def joined(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        if not self._pieces:
            empty = np.zeros(0)
            return empty, empty, empty
        if len(self._pieces) > 1:
            angles, distances, times = zip(*self._pieces, strict=True)
            joined = np.concatenate(angles), np.concatenate(distances), np.concatenate(times)
            self._pieces = [joined]
        return self._pieces[0]
