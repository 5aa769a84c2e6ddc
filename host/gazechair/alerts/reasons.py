"""The table of reasons: what is worth an alert, how severe, after how long, who can fix it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gazechair.config.configuration import ALERT_KINDS
from gazelink import codes

HELP, STUCK, FAILURE, SYSTEM, TEST = KINDS = (*ALERT_KINDS, "test")
"""In the order in which they are sent when several wait."""

# Keys of the string tables, too.
ANYONE, CARETAKER, TECHNICIAN = ("alert_anyone", "alert_caretaker", "alert_technician")

HELP_WANTED = "alert_help"
OVERRULED = "alert_overruled"
PART = "alert_part"
TRIED = "alert_test"

# How long it must last before it is an alert.
AT_ONCE_S = 0.0
FAULT_S = 10.0
LOST_S = 60.0
EXTRA_S = 300.0  # the chair drives without it


@dataclass(frozen=True)
class Reason:
    """Why somebody is called; its text is in the string tables, under the same key."""

    kind: str
    severity: int
    """codes.WARNING or codes.ERROR."""
    lasts_s: float
    who: str
    """Who can fix it: ANYONE, CARETAKER, TECHNICIAN."""


def _faults() -> dict[str, Reason]:
    found = {
        name: Reason(FAILURE, severity, FAULT_S if latched else LOST_S, TECHNICIAN)
        for _bit, name, severity, latched in codes.FAULTS
        if severity == codes.ERROR and name != "simulated_source"
    }
    found["tilt"] = Reason(STUCK, codes.ERROR, 5.0, ANYONE)  # turned over
    found["emergency"] = Reason(FAILURE, codes.ERROR, FAULT_S, CARETAKER)
    return found


REASONS: Mapping[str, Reason] = {
    HELP_WANTED: Reason(HELP, codes.ERROR, AT_ONCE_S, ANYONE),
    OVERRULED: Reason(STUCK, codes.ERROR, AT_ONCE_S, ANYONE),  # see Watch
    TRIED: Reason(TEST, codes.WARNING, AT_ONCE_S, ANYONE),
    PART: Reason(SYSTEM, codes.WARNING, EXTRA_S, TECHNICIAN),
    "board_lost": Reason(FAILURE, codes.ERROR, LOST_S, CARETAKER),
    "wrong_port": Reason(FAILURE, codes.ERROR, LOST_S, TECHNICIAN),
    "version_differs": Reason(FAILURE, codes.ERROR, LOST_S, TECHNICIAN),
    "lidar_lost": Reason(FAILURE, codes.ERROR, LOST_S, CARETAKER),
    "lidar_view": Reason(FAILURE, codes.WARNING, EXTRA_S, CARETAKER),
    "lidar_one": Reason(FAILURE, codes.WARNING, LOST_S, CARETAKER),
    "lidar_silent": Reason(FAILURE, codes.ERROR, LOST_S, CARETAKER),
    "lidar_frozen": Reason(FAILURE, codes.ERROR, LOST_S, CARETAKER),
    "lidar_protection": Reason(FAILURE, codes.ERROR, LOST_S, CARETAKER),
    "lidar_power": Reason(FAILURE, codes.ERROR, LOST_S, CARETAKER),
    "lidar_mirror": Reason(FAILURE, codes.ERROR, LOST_S, CARETAKER),
    "lidar_damaged": Reason(FAILURE, codes.ERROR, LOST_S, CARETAKER),
    "camera_lost": Reason(SYSTEM, codes.WARNING, EXTRA_S, CARETAKER),
    **_faults(),
}
