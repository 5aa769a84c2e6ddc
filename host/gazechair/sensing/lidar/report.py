"""The report of the lidars' child process to the daemon."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

# Keys of the string tables.
STARTING = "lidar_starting"
LOST = "lidar_lost"  # not there, or not usable
SILENT = "lidar_silent"  # there, sends nothing
FROZEN = "lidar_frozen"  # sends the same over and over
PROTECTION = "lidar_protection"  # has stopped itself, to protect itself
POWER = "lidar_power"  # had fallen back to idle
MIRROR = "lidar_mirror"  # answers, measures nothing
ONE = "lidar_one"  # one of several does not work
VIEW = "lidar_view"  # is covered in some direction
DAMAGED = "lidar_damaged"  # much of what it sends arrives damaged


@dataclass(frozen=True)
class LidarReport:
    """The condition of one lidar."""

    name: str
    state: str
    """gazechair.base.health: STARTING, OK, DEGRADED or LOST."""
    reason: str
    """One of the keys above, "ok" when there is nothing to report."""
    detail: str
    source: int | None = None
    """codes.REAL, SIMULATED or REPLAYED; unset, like all below, while it delivers nothing."""
    acquired_s: float | None = None
    """CLOCK_MONOTONIC seconds of the oldest measurement in its scan."""
    rate_hz: float | None = None
    """Measured turns of its mirror per second."""
    coverage: float | None = None
    """Share of the degrees outside its mask that it sees, 0..1."""
    blind_deg: tuple[tuple[int, int], ...] = ()
    """Arcs of the chair's frame in which it is blind, [from, to) counter-clockwise."""
    points: int = 0
    """Measurements in the scan, those without a return included."""
    quarters: int = 0
    """Quarter turns of its mirror since it was started."""
    lost_share: float = 0.0
    """Share of its bytes of about the last second that were discarded."""
    resyncs: int = 0
    """How often its byte stream had to be realigned since it was started."""


@dataclass(frozen=True)
class Report:
    """The newest report of all lidars."""

    lidars: tuple[LidarReport, ...]
    acquired_s: float | None
    """CLOCK_MONOTONIC seconds of the oldest measurement in use; None: no lidar delivers."""
    source: int | None
    """codes.REAL if all that deliver are real; else SIMULATED or REPLAYED."""
    evaluation: dict[str, Any] | None = None
    """Result of the evaluation of all views, as plain JSON values."""

    def pack(self) -> bytes:
        """As one record."""
        return json.dumps({**vars(self), "lidars": [vars(one) for one in self.lidars]}).encode()

    @classmethod
    def unpack(cls, payload: bytes) -> Report:
        """From one record."""
        fields = json.loads(payload)
        for lidar in fields["lidars"]:
            lidar["blind_deg"] = tuple((int(a), int(b)) for a, b in lidar["blind_deg"])
        fields["lidars"] = tuple(LidarReport(**lidar) for lidar in fields["lidars"])
        return cls(**fields)
