"""What odometry doubts, and what it notices: each only once it has lasted for a moment."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from gazechair.base.footprint import FloatArray

HEADING = "no_heading"  # the board gives none: turns come from the lidars alone
LITTLE = "little_seen"  # an empty hall, or all is blind
CORRIDOR = "corridor"  # what is seen does not tell the place in one direction
CHANGED = "changed"  # much of what is seen is not where it was: people, or moved furniture
LATE = "scans_late"  # a lidar that was there does not say anything, or too late
PUSHED = "pushed"  # moves, and is not told to
STUCK = "stuck"  # is told to move, and does not
CARRIED = "carried"  # moves sideways, as no wheelchair does
LOST = "lost"  # knows nothing of what it sees: it begins afresh

_LASTS_S = {
    HEADING: 0.3,
    LITTLE: 0.2,
    CORRIDOR: 0.2,
    CHANGED: 0.3,
    LATE: 0.3,
    PUSHED: 0.2,
    STUCK: 0.1,
    CARRIED: 0.3,
    LOST: 2.0,
}

_FEW = 60  # points
_LEAST_SHARE, _LEAST_INFORMATION = 0.02, 2500.0  # of the direction known best; 1/m^2
_MATCHED, _LOST_MATCHED = 0.5, 0.35
_MOVES_M_S, _MOVES_DEG_S, _STANDS_M_S = 0.06, 6.0, 0.03
_SIDEWAYS_M_S = 0.12
_COMMAND, _NO_COMMAND = 150, 0  # permille


@dataclass(frozen=True)
class Seen:
    """What there is to judge by, at a time."""

    time_s: float
    heading_known: bool
    points: int
    information: FloatArray
    """(2, 2), of the place by this piece alone, 1/m^2."""
    matched: float
    speed_m_s: float
    speed_sigma_m_s: float
    sideways_m_s: float
    yaw_rate_deg_s: float
    outputs: tuple[int, int] | None
    """The least that the board put out for as long as the chair takes to start, and the most for
    as long as it takes to stop, of either axis; permille; None: not known."""
    silent_s: float
    """For how long the lidar that is silent longest has said nothing of use."""


class Doubts:
    """Which of them hold."""

    def __init__(self) -> None:
        self._since_s: dict[str, float] = {}

    def judge(self, seen: Seen) -> tuple[str, ...]:
        """Those that have lasted long enough."""
        now = set(_now(seen))
        self._since_s = {key: self._since_s.get(key, seen.time_s) for key in now}
        return tuple(
            key
            for key, lasts_s in _LASTS_S.items()
            if key in now and seen.time_s - self._since_s[key] >= lasts_s
        )

    def forget(self) -> None:
        """It begins afresh."""
        self._since_s.clear()


def _now(seen: Seen) -> Iterable[str]:
    if not seen.heading_known:
        yield HEADING
    if seen.points < _FEW:
        yield LITTLE
    elif is_corridor(seen.information):
        yield CORRIDOR
    speed = abs(seen.speed_m_s)
    turns = abs(seen.yaw_rate_deg_s) > _MOVES_DEG_S
    if seen.matched < _LOST_MATCHED and speed < _MOVES_M_S and not turns:
        yield LOST  # one that moves sees new rooms
    if seen.matched < _MATCHED:
        yield CHANGED
    if seen.silent_s > 0.0:
        yield LATE
    if abs(seen.sideways_m_s) > _SIDEWAYS_M_S:
        yield CARRIED
    if seen.outputs is None or seen.matched < _MATCHED:
        return
    least, most = seen.outputs
    moves = speed > _MOVES_M_S + seen.speed_sigma_m_s
    if most <= _NO_COMMAND and (moves or turns):
        yield PUSHED
    if least >= _COMMAND and speed < _STANDS_M_S and not turns:
        yield STUCK


def is_corridor(information: FloatArray) -> bool:
    """Whether the place is not determined in one direction."""
    low, high = np.linalg.eigvalsh(information)
    return bool(low < _LEAST_INFORMATION or low < _LEAST_SHARE * high)
