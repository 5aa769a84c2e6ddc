"""Reasons for alerts: their kind, and after how long; base/reasons.py lists who can end them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gazechair.base import reasons
from gazechair.config.settings import ALERT_KINDS
from gazelink import codes

HELP, STUCK, FAILURE, SYSTEM, TEST = KINDS = (*ALERT_KINDS, "test")
"""In the order in which they are sent when several wait."""

# Keys of the string tables, too.
ANYONE, CARETAKER, TECHNICIAN = ("alert_anyone", "alert_caretaker", "alert_technician")

HELP_WANTED = "alert_help"
OVERRULED = "alert_overruled"
PART = "alert_part"
STANDS = "motion_stuck"
TRIED = "alert_test"

# How long a reason must last before it raises an alert.
AT_ONCE_S = 0.0
LASTED_S = 5.0
FAULT_S = 10.0
LOST_S = 60.0
EXTRA_S = 300.0  # of a lost part without which the chair can drive


@dataclass(frozen=True)
class Reason:
    """Why somebody is called; its text is in the string tables, under the same key."""

    kind: str
    lasts_s: float
    who: str
    """Who can fix it: ANYONE, CARETAKER, TECHNICIAN."""


_WHO = {reasons.DRIVER: ANYONE, reasons.CARETAKER: CARETAKER, reasons.BUILDER: TECHNICIAN}


def _of(key: str, kind: str, lasts_s: float) -> tuple[str, Reason]:
    return key, Reason(kind, lasts_s, _WHO[reasons.REASONS[key].who])


REASONS: Mapping[str, Reason] = {
    HELP_WANTED: Reason(HELP, AT_ONCE_S, ANYONE),
    OVERRULED: Reason(STUCK, AT_ONCE_S, ANYONE),  # see Watch
    TRIED: Reason(TEST, AT_ONCE_S, ANYONE),
    PART: Reason(SYSTEM, EXTRA_S, TECHNICIAN),
    **dict(
        [
            *(
                _of(name, FAILURE, FAULT_S if latched else LOST_S)
                for _bit, name, severity, latched in codes.FAULTS
                if severity == codes.ERROR and name != "simulated_source"
            ),
            _of("board_lost", FAILURE, LOST_S),
            _of("wrong_port", FAILURE, LOST_S),
            _of("version_differs", FAILURE, LOST_S),
            _of("lidar_lost", FAILURE, LOST_S),
            _of("lidar_one", FAILURE, LOST_S),
            _of("lidar_view", FAILURE, EXTRA_S),
            _of("lidar_silent", FAILURE, LOST_S),
            _of("lidar_frozen", FAILURE, LOST_S),
            _of("lidar_protection", FAILURE, LOST_S),
            _of("lidar_power", FAILURE, LOST_S),
            _of("lidar_mirror", FAILURE, LOST_S),
            _of("lidar_damaged", FAILURE, LOST_S),
            _of("motion_uncommanded", FAILURE, AT_ONCE_S),
            _of(STANDS, STUCK, LASTED_S),
            _of("camera_lost", SYSTEM, EXTRA_S),
            _of("host_slow", SYSTEM, EXTRA_S),
            _of("host_hot", SYSTEM, EXTRA_S),
        ]
    ),
    "tilt": Reason(STUCK, LASTED_S, ANYONE),  # turned over
}
