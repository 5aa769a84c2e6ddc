"""Turns one lidar's data into its newest scan, and measures the data's quality."""

from __future__ import annotations

from collections.abc import Callable

from gazechair.sensing.lidar.dense import CAPSULE_SIZE, POINT_PERIOD_S, CapsuleDecoder
from gazechair.sensing.lidar.freeze import FreezeWatch
from gazechair.sensing.lidar.nodes import NODE_SIZE, NodeDecoder, Nodes
from gazechair.sensing.lidar.scan import Placing, Scan
from gazechair.sensing.lidar.sweep import NODE_PERIOD_S, Sweep

_FOLLOW = 0.025  # weight of a quarter turn in the share of lost bytes: about a second
# Gets all nodes, when they were complete, and the time from one to the next; must not block.
Tap = Callable[[Nodes, float, float], None]
PERIODS_S = {"dense": POINT_PERIOD_S, "standard": NODE_PERIOD_S}


def make_decoder(mode: str) -> CapsuleDecoder | NodeDecoder:
    """The decoder for a "dense" or "standard" scan."""
    return CapsuleDecoder() if mode == "dense" else NodeDecoder()


class NodeStream:
    """Receives nodes; after each quarter turn of the mirror `scan` has new data."""

    def __init__(
        self,
        source: int,
        period_s: float,
        tap: Tap | None = None,
        placing: Placing | None = None,
    ) -> None:
        """`source`: codes.REAL, ...; `period_s`: from one measurement to the next."""
        self._period_s = period_s
        self._tap = tap
        self._sweep = Sweep(source, period_s, placing)
        self.quarters = -1
        """Quarter turns of the mirror completed since the start."""
        self.lost_share = 0.0
        """Share of its bytes of about the last second that were discarded."""
        self.resyncs = 0
        """How often its byte stream had to be realigned."""
        self.last_s: float | None = None
        """When the newest nodes came, CLOCK_MONOTONIC seconds."""

    @property
    def turns(self) -> int:
        """Turns of the mirror since the start."""
        return self._sweep.turns

    @property
    def rate_hz(self) -> float:
        """Measured turns per second; 0 before that is known."""
        return self._sweep.rate_hz

    def take(self, nodes: Nodes, received_s: float) -> bool:
        """Take nodes that were complete at `received_s`; True when a quarter turn is complete."""
        if not len(nodes):
            return False
        self.last_s = received_s
        self._sweep.take(nodes, received_s)
        if self._tap is not None:
            self._tap(nodes, received_s, self._period_s)
        changed = self._sweep.quarter != self.quarters
        self.quarters = self._sweep.quarter
        return changed

    @property
    def trusted(self) -> bool:
        """Whether its data may be used."""
        return True

    def scan(self) -> Scan | None:
        """The newest scan; None before the first whole turn, and while it is not trusted."""
        return self._sweep.scan() if self._sweep.turns >= 2 and self.trusted else None


class ByteStream(NodeStream):
    """A NodeStream from a device's bytes."""

    def __init__(
        self, mode: str, source: int, tap: Tap | None = None, placing: Placing | None = None
    ) -> None:
        """`mode`: "dense" or "standard"; `source`: codes.REAL or SIMULATED."""
        super().__init__(source, PERIODS_S[mode], tap, placing)
        self._decoder = make_decoder(mode)
        self._unit = CAPSULE_SIZE if mode == "dense" else NODE_SIZE
        self._freeze = FreezeWatch()
        self._counted = (0, 0)

    @property
    def frozen(self) -> bool:
        """True when the device repeats old data."""
        return self._freeze.frozen

    @property
    def trusted(self) -> bool:
        """Whether the device is proven to measure, and does not repeat old data."""
        return self._freeze.proven and not self._freeze.frozen

    @property
    def wants(self) -> int:
        """Bytes still needed to complete the quarter turn, if none is lost."""
        return self._decoder.wants(self._sweep.left_deg)

    @property
    def byte_s(self) -> float:
        """Time from one byte to the next."""
        return self._period_s / self._decoder.NODE_BYTES

    def feed(self, data: bytes, received_s: float) -> bool:
        """Take bytes; True when another quarter turn is complete."""
        nodes = self._decoder.feed(data)
        self._freeze.take(nodes)
        self.resyncs = self._decoder.resyncs
        if not self.take(nodes, received_s):
            return False
        self._count_losses()
        return True

    def _count_losses(self) -> None:
        lost = self._decoder.dropped + self._decoder.implausible * self._unit
        fed = self._decoder.fed
        lost_now, fed_now = lost - self._counted[0], fed - self._counted[1]
        self._counted = (lost, fed)
        if fed_now > 0:
            self.lost_share += (min(1.0, lost_now / fed_now) - self.lost_share) * _FOLLOW
