"""Odometry's doubts, and events that it notices: each is reported once it has lasted."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from gazechair.base.footprint import FloatArray

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
    PUSHED: 0.1,
    STUCK: 0.1,
    CARRIED: 0.3,
    LOST: 2.0,
}

_FEW = 60  # points
_LEAST_SHARE, _LEAST_INFORMATION = 0.02, 2500.0  # of the direction known best; 1/m^2
_MATCHED, _LOST_MATCHED = 0.5, 0.35
_MOVES_M_S, _MOVES_DEG_S, _STANDS_M_S = 0.06, 6.0, 0.03
_MOVED_M_S = 0.075
_SIDEWAYS_M_S = 0.12
_DIFFERS_DEG = 0.6
_HEARD_S = 0.1  # longest age of the board's report
_STOPS_S, _STOPPED_S = 1.2, 2.5  # after these times most chairs, all chairs have stopped
# A command that moves any chair in its slowest profile: its deadband and its stiction are less.
_DRIVE, _TURN = 600, 800
_DEADBAND = 150
_EXPECTED_M_S = 0.08


@dataclass(frozen=True)
class Outputs:
    """What the board has put out, permille, without signs."""

    drive: int
    """The least in one direction over the time that the chair takes to start."""
    turn: int
    """The same for the turn output."""
    idle_s: float
    """Time since the last output; limited to the few seconds that are kept."""


@dataclass(frozen=True)
class Seen:
    """What doubts are judged by, at one time."""

    time_s: float
    heading_known: bool
    points: int
    information: FloatArray
    """(2, 2), of the position by this piece alone, 1/m^2."""
    matched: float
    speed_m_s: float
    speed_sigma_m_s: float
    sideways_m_s: float
    yaw_rate_deg_s: float
    got_on_m_s: float
    """Mean speed of the last moments, by positions alone."""
    outputs: Outputs | None
    """None: not known."""
    full_m_s: float
    """The slowest speed of a full command, as learned for this chair; 0 or less: not known."""
    heading_off_deg: float
    """Recent difference between the turn seen by the lidars and that of the heading sensor."""
    late: bool
    """This piece is older than the board's reports by more than the limit."""
    silent: bool
    """Another lidar has sent nothing usable for longer than that before this piece."""
    turned: bool
    """See mounting."""


class Doubts:
    """Decides which doubts apply."""

    def __init__(self) -> None:
        self._since_s: dict[str, float] = {}
        self._least: tuple[float, ...] = (
            math.inf,
        ) * 3  # slowest since nothing is commanded: see _motion

    def judge(self, seen: Seen) -> tuple[str, ...]:
        """The doubts that have lasted long enough."""
        commanded = seen.outputs is None or seen.outputs.idle_s < _HEARD_S
        before: tuple[float, ...] = (math.inf,) * 3 if commanded else self._least
        self._least = tuple(map(min, before, _motion(seen)))
        now = set(_now(seen, self._least))
        self._since_s = {key: self._since_s.get(key, seen.time_s) for key in now}
        return tuple(
            key
            for key, lasts_s in _LASTS_S.items()
            if key in now and seen.time_s - self._since_s[key] >= lasts_s
        )

    def forget(self) -> None:
        """Odometry starts again: drop what has been counted."""
        self._since_s.clear()


def _motion(seen: Seen) -> tuple[float, float, float]:
    """Speeds: m/s as filtered, m/s by positions alone, degrees/s."""
    return abs(seen.speed_m_s), seen.got_on_m_s, abs(seen.yaw_rate_deg_s)


def _pushed(seen: Seen, outputs: Outputs, least: tuple[float, ...]) -> bool:
    """Whether it moves after it should rest; or earlier, speeds up without a command."""
    if outputs.idle_s < _STOPS_S:
        return False
    if outputs.idle_s >= _STOPPED_S:
        least = (0.0,) * 3
    speed, got_on, yaw = _motion(seen)
    turns = yaw > least[2] + _MOVES_DEG_S and abs(seen.heading_off_deg) <= _DIFFERS_DEG
    faster = speed > least[0] + _MOVES_M_S + seen.speed_sigma_m_s
    return faster or got_on > least[1] + _MOVED_M_S or turns


def _now(seen: Seen, least: tuple[float, ...]) -> Iterable[str]:
    if not seen.heading_known:
        yield HEADING
    if seen.turned:
        yield TURNED
    if seen.points < _FEW:
        yield LITTLE
    elif is_corridor(seen.information):
        yield CORRIDOR
    speed = abs(seen.speed_m_s)
    turns = abs(seen.yaw_rate_deg_s) > _MOVES_DEG_S
    if seen.matched < _LOST_MATCHED and speed < _MOVES_M_S and not turns:
        yield LOST  # a moving chair may enter new rooms
    if abs(seen.heading_off_deg) > _DIFFERS_DEG:
        yield DIFFERS
    if seen.matched < _MATCHED:
        yield CHANGED
    if seen.late:
        yield LATE
    if seen.silent:
        yield SILENT
    if abs(seen.sideways_m_s) > _SIDEWAYS_M_S:
        yield CARRIED
    if seen.outputs is None or seen.matched < _MATCHED:
        return
    if _pushed(seen, seen.outputs, least):
        yield PUSHED
    expected_m_s = seen.full_m_s * (seen.outputs.drive - _DEADBAND) / (1000 - _DEADBAND)
    told = seen.outputs.drive >= _DRIVE or seen.outputs.turn >= _TURN
    if (
        (told or expected_m_s > _EXPECTED_M_S)
        and min(speed, seen.got_on_m_s) < _STANDS_M_S
        and not turns
    ):
        yield STUCK


def is_corridor(information: FloatArray) -> bool:
    """Whether the position is undetermined in one direction."""
    low, high = np.linalg.eigvalsh(information)
    return bool(low < _LEAST_INFORMATION or low < _LEAST_SHARE * high)
