"""What the lidar's child process tells the daemon."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass

from gazechair.lidar.sectors import Reading

# Keys of the string tables.
LOST = "lidar_lost"
VIEW = "lidar_view"
STARTING = "lidar_starting"


@dataclass(frozen=True)
class Report:
    """The newest word on the sectors, one reading each."""

    readings: tuple[Reading, ...]
    acquired_s: float
    """CLOCK_MONOTONIC seconds of the oldest measurement in it."""
    source: int
    """codes.REAL or codes.SIMULATED."""
    points: int
    """Measurements in the scan, those without a return included."""
    turns: int
    """Turns since the scan started."""
    resyncs: int
    """How often the byte stream had to be realigned since then."""

    def pack(self) -> bytes:
        """As one record."""
        return json.dumps(asdict(self)).encode()

    @classmethod
    def unpack(cls, payload: bytes) -> Report:
        """From one record."""
        fields = json.loads(payload)
        fields["readings"] = tuple(Reading(**reading) for reading in fields["readings"])
        return cls(**fields)
