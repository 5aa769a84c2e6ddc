"""Whether the time of day is plausible: without a clock battery a computer starts with any time."""

from __future__ import annotations

from pathlib import Path

EARLIEST_S = 1_767_225_600.0  # 2026: an earlier clock has not been set
_SYNCHRONIZED = Path("/run/systemd/timesync/synchronized")


def is_set() -> bool:
    """True once the clock was set from the network since the computer started."""
    return _SYNCHRONIZED.exists()
