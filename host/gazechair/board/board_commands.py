"""Values that the host sends repeatedly: the driver's command, the clearance, the bypass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from gazelink import codes
from gazelink.arcs import ALL_FAR
from gazelink.messages import CLEAR_FAR

_U16 = 65535


@dataclass(frozen=True)
class Command:
    """The driver's command, from the press to its last proof that it is active."""

    verb: int
    mode: int
    edge: int
    """The board's number of this press, 1..255; 0 = no press yet."""
    owner: int
    ttl_deadline_s: float
    """Monotonic time at which the last proof of holding expires."""
    linear_permille: int = 0
    """-1000..1000, forward positive: of codes.DRIVE, and of a tuning pulse."""
    turn_permille: int = 0
    """-1000..1000, left positive; the same."""
    cap_permille: int = 1000
    """No output beyond it, 0..1000."""
    pulse_ms: int = 0
    """Longest duration of a tuning pulse."""
    watcher: int = codes.NOBODY
    """Who supervises it, in mode auto."""
    watched_s: float = 0.0
    """When that was last proven, monotonic."""

    def same_as(self, other: Command) -> bool:
        """True if only the proof of holding may differ."""
        mine, others = (replace(c, ttl_deadline_s=0.0, watched_s=0.0) for c in (self, other))
        return mine == others

    def supervision(self, now_s: float) -> tuple[int, int, int]:
        """The fields of a SUPERVISION frame sent at `now_s`."""
        age_ms = max(0, min(math.ceil((now_s - self.watched_s) * 1000), _U16))
        return (self.edge, self.watcher, age_ms)

    def fields(self, now_s: float, ttl_limit_ms: int) -> tuple[int, ...]:
        """The fields of a COMMAND frame sent at `now_s`, time to live counted down to it."""
        return (
            self.verb,
            self.mode,
            self.edge,
            self.owner,
            _ttl_ms(self.ttl_deadline_s, now_s, ttl_limit_ms),
            self.linear_permille,
            self.turn_permille,
            self.cap_permille,
            self.pulse_ms,
        )


STOP_COMMAND = Command(codes.STOP, codes.CONTINUOUS, 0, codes.NOBODY, 0.0)


@dataclass(frozen=True)
class Clearance:
    """What the newest scans leave free; see gazelink.messages.CLEARANCE."""

    blocked: int
    """A bit per direction, codes.DIR_FORWARD ...: blocked, whatever the distances are."""
    source: int
    """codes.REAL, SIMULATED or REPLAYED."""
    acquired_s: float
    """Monotonic time of the oldest measurement in it."""
    unseen: int = 0
    """A bit per direction: the motion enters an arc that this installation never sees."""
    forward_mm: int = CLEAR_FAR
    """How far the chair may move until its footprint touches what is seen."""
    backward_mm: int = CLEAR_FAR
    left_q4_deg: int = CLEAR_FAR
    """How far it may turn about the drive axle, 1/16 degree."""
    right_q4_deg: int = CLEAR_FAR
    arc_views: int = 0
    """A bit per quadrant: blind in the low nibble, unseen in the high one."""
    arcs: Sequence[int] = ALL_FAR
    """How far it may travel while it turns; see gazelink.arcs."""

    def fields(self, now_s: float) -> tuple[int | bytes, ...]:
        """The fields of a CLEARANCE frame sent at `now_s`, with the scan's age at that time."""
        return (
            self.blocked,
            self.unseen,
            self.source,
            self.forward_mm,
            self.backward_mm,
            self.left_q4_deg,
            self.right_q4_deg,
            max(0, min(int((now_s - self.acquired_s) * 1000), _U16)),
            self.arc_views,
            bytes(self.arcs),
        )


@dataclass(frozen=True)
class Bypass:
    """The caretaker's bypass button: creep past an obstacle is allowed while it is pressed."""

    number: int
    """1..255, another one with each new press."""
    ttl_deadline_s: float
    """Monotonic time at which the last proof of holding expires."""

    def fields(self, now_s: float, ttl_limit_ms: int) -> tuple[int, int]:
        """The fields of a BYPASS frame sent at `now_s`."""
        return (self.number, _ttl_ms(self.ttl_deadline_s, now_s, ttl_limit_ms))


def _ttl_ms(deadline_s: float, now_s: float, limit_ms: int) -> int:
    return max(0, min(int((deadline_s - now_s) * 1000), limit_ms))
