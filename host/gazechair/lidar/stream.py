"""From one lidar's bytes to its newest scan, with everything that tells how good the stream is."""

from __future__ import annotations

from gazechair.lidar.dense import CAPSULE_SIZE, POINT_PERIOD_S, CapsuleDecoder
from gazechair.lidar.freeze import FreezeWatch
from gazechair.lidar.nodes import NODE_SIZE, NodeDecoder
from gazechair.lidar.scan import Scan
from gazechair.lidar.sweep import NODE_PERIOD_S, Sweep

_FOLLOW = 0.025  # of the share of lost bytes, each quarter turn: about a second


class ByteStream:
    """Feed it what the port delivers; after a quarter turn of the mirror `scan` is worth a look."""

    def __init__(self, mode: str, source: int) -> None:
        """`mode`: "dense" or "standard"; `source`: codes.REAL or SIMULATED."""
        dense = mode == "dense"
        self._decoder = CapsuleDecoder() if dense else NodeDecoder()
        self._unit = CAPSULE_SIZE if dense else NODE_SIZE
        self._sweep = Sweep(source, POINT_PERIOD_S if dense else NODE_PERIOD_S)
        self._freeze = FreezeWatch()
        self._quarter = -1
        self._counted = (0, 0)
        self.lost_share = 0.0
        self.last_s: float | None = None
        """When the newest nodes came, CLOCK_MONOTONIC seconds."""

    @property
    def turns(self) -> int:
        """Turns of the mirror since the start."""
        return self._sweep.turns

    @property
    def resyncs(self) -> int:
        """How often the bytes had to be realigned."""
        return self._decoder.resyncs

    @property
    def rate_hz(self) -> float:
        """Turns in a second, as measured; 0 before that is known."""
        return self._sweep.rate_hz

    @property
    def frozen(self) -> bool:
        """True when it repeats itself."""
        return self._freeze.frozen

    def feed(self, data: bytes, received_s: float) -> bool:
        """Take bytes; True when another quarter turn is complete."""
        nodes = self._decoder.feed(data)
        if not len(nodes):
            return False
        self.last_s = received_s
        self._sweep.take(nodes, received_s)
        self._freeze.take(nodes)
        quarter = self._sweep.quarter
        if quarter == self._quarter:
            return False
        self._quarter = quarter
        self._count_losses()
        return True

    def scan(self) -> Scan | None:
        """The newest scan; None before there was a whole turn that can be believed."""
        if self._sweep.turns < 2 or not self._freeze.proven or self._freeze.frozen:
            return None
        return self._sweep.scan()

    def _count_losses(self) -> None:
        lost = self._decoder.dropped + self._decoder.implausible * self._unit
        fed = self._decoder.fed
        lost_now, fed_now = lost - self._counted[0], fed - self._counted[1]
        self._counted = (lost, fed)
        if fed_now > 0:
            self.lost_share += (min(1.0, lost_now / fed_now) - self.lost_share) * _FOLLOW
