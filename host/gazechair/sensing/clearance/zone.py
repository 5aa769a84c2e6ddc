"""The chair's stopping distances and times as sent by the board.

The board has the formulas and the settings; the host only looks the values up. Until the board has
sent them, the stopping time is infinite: every beam counts, and the chair does not approach
anything that may be a person.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.board.zone import BoardZone
from gazelink import codes, zone

_MM = 1000.0
_Q4 = 16.0


class Stopping:
    """Stopping in one direction: metres and m/s, or degrees and degrees/s."""

    def __init__(self, points: bytes, unit: float) -> None:
        """`points` as in gazelink.zone; raises ValueError for impossible ones."""
        if len(points) != zone.SIZE:
            raise ValueError(f"{len(points)} bytes are no zone")
        rows = np.array(list(struct.iter_unpack(zone.POINT, points)), dtype=np.float64)
        rising = (np.diff(rows, axis=0) >= 0.0).all()
        if rows[zone.STANDING, 0] != 0.0 or rows[zone.FULL, 0] <= 0.0 or not rising:
            raise ValueError("a zone whose speeds and ways do not grow")
        self.speeds: FloatArray = rows[:, 0] / unit
        self.stops: FloatArray = rows[:, 1] / unit
        """Distance from the decision until the chair stands, margin included."""
        self.times_s: FloatArray = rows[:, 2] / 1000.0
        self.permits_at: FloatArray = rows[:, 3] / unit
        """Clearance with which the board permits that speed, and no higher one."""
        self.margin = float(self.stops[zone.STANDING])
        self.zone = float(self.stops[zone.FULL])
        """Distance in which the fastest profile stops: too near to wait for a second look."""

    def time_s(self, speed: float) -> float:
        """Time to stop from `speed`, extrapolated above the board's highest."""
        speed = abs(speed)
        full = float(self.speeds[zone.FULL])
        found = float(np.interp(speed, self.speeds, self.times_s))
        if speed > full:
            braking_s = float(self.times_s[zone.FULL] - self.times_s[zone.STANDING])
            found += braking_s * (speed / full - 1.0)
        return found


class StopZone:
    """Stopping in all directions; UNKNOWN until the board has sent it."""

    def __init__(self, points: Sequence[bytes] | None = None) -> None:
        """`points` of each direction, in the order of codes.DIRECTIONS. Raises ValueError."""
        self._directions: tuple[Stopping, ...] = ()
        self.far: FloatArray = np.full(len(codes.DIRECTIONS), math.inf)
        """Per direction, metres or degrees in which the fastest profile stops."""
        if points is None:
            return
        if len(points) != len(codes.DIRECTIONS):
            raise ValueError(f"a zone of {len(points)} directions")
        self._directions = tuple(
            Stopping(one, _Q4 if direction >= codes.DIR_LEFT else _MM)
            for direction, one in enumerate(points)
        )
        self.far = np.array([one.zone for one in self._directions])

    def of(self, direction: int) -> Stopping | None:
        """Stopping in one direction (codes.DIR_*); None: not known."""
        return self._directions[direction] if self._directions else None

    def time_s(self, speed_m_s: float) -> float:
        """Time to stop from that speed, negative for backward; inf: not known."""
        direction = codes.DIR_BACKWARD if speed_m_s < 0.0 else codes.DIR_FORWARD
        one = self.of(direction)
        return math.inf if one is None else one.time_s(speed_m_s)


UNKNOWN = StopZone()


def to_hex(zone: BoardZone) -> list[str]:
    """The points of `zone` as they are sent to a child process."""
    return [one.hex() for one in zone.points]


def from_hex(points: Sequence[str]) -> tuple[BoardZone, StopZone]:
    """The zone in `points` of to_hex: as sent by the board, and to look up in.

    Raises ValueError or TypeError.
    """
    zone = BoardZone(tuple(bytes.fromhex(one) for one in points))
    return zone, StopZone(zone.points) if zone.points else UNKNOWN
