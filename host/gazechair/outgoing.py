"""The two values the host keeps sending: the driver's command and the obstacle flags."""

from __future__ import annotations

from dataclasses import dataclass

from gazelink import codes

_U16 = 65535


@dataclass(frozen=True)
class Command:
    """What the driver asks for, from the press to its last proof of holding."""

    verb: int
    mode: int
    edge: int
    """The board's number of this press, 1..255; 0 = no press yet."""
    owner: int
    ttl_deadline_s: float
    """Monotonic time at which the last proof of holding expires."""

    def same_as(self, other: Command) -> bool:
        """True if only the proof of holding may differ."""
        return (self.verb, self.mode, self.edge, self.owner) == (
            other.verb,
            other.mode,
            other.edge,
            other.owner,
        )

    def fields(self, now_s: float, ttl_limit_ms: int) -> tuple[int, ...]:
        """The fields of a COMMAND frame sent at `now_s`, time to live counted down to it."""
        left_ms = int((self.ttl_deadline_s - now_s) * 1000)
        ttl_ms = max(0, min(left_ms, ttl_limit_ms))
        return (self.verb, self.mode, self.edge, self.owner, ttl_ms, 0, 0)


STOP_COMMAND = Command(codes.STOP, codes.CONTINUOUS, 0, codes.NOBODY, 0.0)


@dataclass(frozen=True)
class Clearance:
    """Where obstacles block, from one scan."""

    blocked: int
    """A bit per direction, codes.DIR_FORWARD ..."""
    source: int
    """codes.REAL, SIMULATED or REPLAYED."""
    acquired_s: float
    """Monotonic time of the scan's acquisition."""

    def fields(self, now_s: float) -> tuple[int, int, int]:
        """The fields of a CLEARANCE frame sent at `now_s`, with the scan's age at that time."""
        age_ms = max(0, min(int((now_s - self.acquired_s) * 1000), _U16))
        return (self.blocked, self.source, age_ms)
