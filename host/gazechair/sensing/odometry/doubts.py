"""Odometry's doubts, and events that it notices: each is reported once it has lasted."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.sensing.odometry.motion_check import MotionCheck
from gazechair.sensing.odometry.seen import DIFFERS_DEG, MOVES_DEG_S, MOVES_M_S, Seen

HEADING = "no_heading"  # none from the board: turns come from the lidars alone
TURNED = "lidar_turned"  # a lidar does not point where its configured mounting says
DIFFERS = "heading_differs"  # the lidars see another turn than the sensor reports
LITTLE = "little_seen"  # an empty hall, or all is blind
CORRIDOR = "corridor"  # the surfaces do not determine the position in one direction
CHANGED = "changed"  # many surfaces are not where they were: people, or moved furniture
LATE = "scans_late"  # the newest scans are old
SILENT = "lidar_silent"  # a lidar has stopped sending, or sends too late; another goes on
PUSHED = "pushed"  # moves without a command
STUCK = "stuck"  # does not move on a command
BY_HEADING = "by_heading"  # pushed or stuck, by the heading sensor: the lidars need not see
CARRIED = "carried"  # moves sideways, as no wheelchair does
LOST = "lost"  # recognizes nothing that it sees: it starts again

# These make a measured speed unsure.
UNSURE = frozenset((LITTLE, CORRIDOR, CHANGED, LATE, CARRIED, LOST))

_LASTS_S = {
    HEADING: 0.3,
    TURNED: 0.0,
    DIFFERS: 0.3,
    LITTLE: 0.2,
    CORRIDOR: 0.2,
    CHANGED: 0.3,
    LATE: 0.3,
    SILENT: 0.3,
    PUSHED: 0.0,  # these three have lasted already
    STUCK: 0.0,
    BY_HEADING: 0.0,
    CARRIED: 0.3,
    LOST: 2.0,
}

FEW = 60  # points
_LEAST_SHARE, _LEAST_INFORMATION = 0.02, 2500.0  # of the direction known best; 1/m^2
_MATCHED, _LOST_MATCHED = 0.5, 0.35
_SIDEWAYS_M_S = 0.12


class Doubts:
    """Decides which doubts apply."""

    def __init__(self) -> None:
        self._since_s: dict[str, float] = {}
        self._motion_check = MotionCheck()

    def judge(self, seen: Seen) -> tuple[str, ...]:
        """The doubts that have lasted long enough."""
        now = set(_now(seen))
        checked = self._motion_check.judge(
            seen, placed=LITTLE not in now and CORRIDOR not in now, matched=CHANGED not in now
        )
        now.update(
            key
            for key, applies in (
                (PUSHED, checked.pushed),
                (STUCK, checked.stuck),
                (BY_HEADING, checked.by_heading),
            )
            if applies
        )
        self._since_s = {key: self._since_s.get(key, seen.time_s) for key in now}
        return tuple(
            key
            for key, lasts_s in _LASTS_S.items()
            if key in now and seen.time_s - self._since_s[key] >= lasts_s
        )

    def forget(self) -> None:
        """Odometry starts again: drop what has been counted."""
        self._since_s.clear()
        self._motion_check.forget()


def _now(seen: Seen) -> Iterable[str]:
    if not seen.heading_known:
        yield HEADING
    if seen.turned:
        yield TURNED
    if seen.points < FEW:
        yield LITTLE
    elif is_corridor(seen.information):
        yield CORRIDOR
    speed = abs(seen.speed_m_s)
    turns = abs(seen.yaw_rate_deg_s) > MOVES_DEG_S
    if seen.matched < _LOST_MATCHED and speed < MOVES_M_S and not turns:
        yield LOST  # a moving chair may enter new rooms
    if abs(seen.heading_off_deg) > DIFFERS_DEG:
        yield DIFFERS
    if seen.matched < _MATCHED:
        yield CHANGED
    if seen.late:
        yield LATE
    if seen.silent:
        yield SILENT
    if abs(seen.sideways_m_s) > _SIDEWAYS_M_S:
        yield CARRIED


def is_corridor(information: FloatArray) -> bool:
    """Whether the position is undetermined in one direction."""
    low, high = np.linalg.eigvalsh(information)
    return bool(low < _LEAST_INFORMATION or low < _LEAST_SHARE * high)


def is_determined(information: FloatArray, axis: FloatArray) -> bool:
    """Whether the position is determined along `axis`, (2,)."""
    # Added, so that it can be inverted where nothing is told.
    return bool(axis @ np.linalg.inv(information + np.eye(2)) @ axis * _LEAST_INFORMATION < 1.0)
