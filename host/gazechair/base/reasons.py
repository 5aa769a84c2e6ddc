"""The table of reasons: what each part's trouble means, who can end it, what the chair still does.

The sentences are in web/strings/, under the same keys; docs/when-it-fails.md shows them together.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from gazelink import codes

STARTING, DEGRADED, LOST = "starting", "degraded", "lost"

# Severity, besides codes.WARNING and codes.ERROR: no page mentions it.
NOTE = 0

# Who can end it.
DRIVER, CARETAKER, BUILDER = WHO = ("driver", "caretaker", "builder")

# What the chair does for as long as it lasts.
DRIVES, ELSEWHERE, STRAIGHT, SLOWLY, STANDS = THEN = (
    "drives",
    "drives in other directions",
    "drives without turning",
    "drives slowly",
    "stands",
)


@dataclass(frozen=True)
class Part:
    """A source that can fail."""

    silent_s: float
    """The part is lost when it reports nothing for this long."""
    severity: Mapping[str, int]
    """By health state; a state that is not named is a NOTE."""
    caretaker_only: bool = False
    """The driver's page does not mention it: the chair drives as before."""


_MUST = {STARTING: codes.WARNING, DEGRADED: codes.WARNING, LOST: codes.ERROR}
_NOTES: Mapping[str, int] = {}
_MAY = {DEGRADED: codes.WARNING, LOST: codes.WARNING}

PLUGIN = "plugin"

PARTS: Mapping[str, Part] = {
    "board": Part(2.0, _MUST),
    "lidar": Part(2.0, _MUST),
    "odometry": Part(2.0, _MAY, caretaker_only=True),
    "motion": Part(2.0, {DEGRADED: codes.WARNING, LOST: codes.ERROR}),  # as odometry measures it
    "map": Part(3.0, _MAY, caretaker_only=True),
    "assist": Part(2.0, _NOTES),  # the driver's page shows it; without it the chair drives on
    "camera": Part(2.0, _MAY),
    "host": Part(2.0, _MAY),
    "log": Part(3.0, _MAY, caretaker_only=True),
    "alerts": Part(3.0, _NOTES),  # the pages show its deliveries
    PLUGIN: Part(1.0, _NOTES),  # the pages show each with its own health
}

FILES = (
    "speed_cap",
    "first_drive",
    "profiles",
    "devices",
    "alert_diary",
    "forward",
    "camera_floor",
)
SPEED_CAP, FIRST_DRIVE, PROFILES, DEVICES, ALERT_DIARY, FORWARD, CAMERA_FLOOR = FILES
"""Files of the state folder, as parts of the host's health."""

# Files of what caretakers do are no sources that can fall silent, as PARTS are. A page shows which
# routes fail, but neither that the broker gets nothing nor that the process that sends is lost.
_CARE = Part(math.inf, {DEGRADED: codes.WARNING, LOST: codes.WARNING}, caretaker_only=True)
SHOWN: Mapping[str, Part] = {**PARTS, **dict.fromkeys((*FILES, "alerts"), _CARE)}
"""The parts and files as the message of the pages' corner counts them."""


@dataclass(frozen=True)
class Reason:
    """Why a part is not OK, or why the board overrules or refuses."""

    severity: int
    """NOTE, codes.WARNING or codes.ERROR: the most that it can be."""
    who: str
    """One of WHO."""
    then: str
    """One of THEN."""


def kind(part: str) -> str:
    """Which of PARTS a part is: a plug-in's name begins with "input " or "mode "."""
    return PLUGIN if " " in part else part


_E, _W = codes.ERROR, codes.WARNING

_FAULTS = {
    "host_silent": (CARETAKER, STANDS),
    "service_stalled": (DRIVER, STANDS),
    "obstacle_data_old": (CARETAKER, STANDS),
    "heading_frozen": (CARETAKER, STRAIGHT),
    "heading_bus": (CARETAKER, STRAIGHT),
    "heading_reset": (DRIVER, STRAIGHT),
    "heading_jump": (CARETAKER, STRAIGHT),
    "wiper": (BUILDER, STANDS),
    "tick_exception": (BUILDER, STANDS),
    "tick_stalled": (DRIVER, STANDS),
    "emergency": (CARETAKER, STANDS),
    "tilt": (CARETAKER, STANDS),
    "relay_open": (BUILDER, STANDS),
    "relay_stuck": (BUILDER, STANDS),
    "calibration": (BUILDER, STANDS),
    "watchdog_boots": (BUILDER, STANDS),
    "simulated_source": (BUILDER, STANDS),
    "no_hard_timer": (BUILDER, STANDS),
    "disobeys": (BUILDER, STANDS),
    "relay_unexpected": (BUILDER, STANDS),
    "tilt_unknown": (BUILDER, STANDS),
    "storage": (BUILDER, STANDS),
}

REASONS: Mapping[str, Reason] = {
    # The board overrules or refuses.
    "not_armed": Reason(_W, DRIVER, STANDS),
    "command_expired": Reason(_W, DRIVER, STANDS),
    "needs_new_command": Reason(_W, DRIVER, STANDS),
    "time_limit": Reason(_W, DRIVER, STANDS),
    "obstacle_forward": Reason(_W, DRIVER, ELSEWHERE),
    "obstacle_backward": Reason(_W, DRIVER, ELSEWHERE),
    "obstacle_left": Reason(_W, DRIVER, ELSEWHERE),
    "obstacle_right": Reason(_W, DRIVER, ELSEWHERE),
    "not_owner": Reason(_W, DRIVER, STANDS),
    "not_connected": Reason(_W, DRIVER, STANDS),
    "neutral_not_proven": Reason(_W, CARETAKER, STANDS),
    "command_active": Reason(_W, DRIVER, STANDS),
    "no_owner": Reason(_W, DRIVER, STANDS),
    "bad_command": Reason(_W, DRIVER, STANDS),
    "version_differs": Reason(_E, BUILDER, STANDS),
    "maintenance_while_armed": Reason(_W, CARETAKER, DRIVES),
    "setting_unknown": Reason(_W, CARETAKER, DRIVES),
    "setting_out_of_range": Reason(_W, CARETAKER, DRIVES),
    "setting_while_armed": Reason(_W, CARETAKER, DRIVES),
    "setting_not_stored": Reason(_W, CARETAKER, DRIVES),
    "sensor_not_calibrated": Reason(_W, BUILDER, DRIVES),
    "tuning_angle": Reason(_W, BUILDER, STANDS),
    "above_creep": Reason(_W, CARETAKER, ELSEWHERE),
    "setting_by_calibration": Reason(_W, BUILDER, DRIVES),
    "supervision_lost": Reason(_W, DRIVER, STANDS),
    "auto_overruled": Reason(_W, DRIVER, STANDS),
    "auto_limit": Reason(_W, DRIVER, STANDS),
    "another_press": Reason(_W, DRIVER, STANDS),
    # The board detects.
    **{name: Reason(severity, *_FAULTS[name]) for _bit, name, severity, _latched in codes.FAULTS},
    # The link to the board.
    "board_starting": Reason(_W, DRIVER, STANDS),
    "board_lost": Reason(_E, CARETAKER, STANDS),
    "board_busy": Reason(_W, CARETAKER, STANDS),
    "wrong_port": Reason(_E, BUILDER, STANDS),
    # Lidars.
    "lidar_starting": Reason(_W, DRIVER, STANDS),
    "lidar_lost": Reason(_E, CARETAKER, STANDS),
    "lidar_silent": Reason(_E, CARETAKER, STANDS),
    "lidar_frozen": Reason(_E, CARETAKER, STANDS),
    "lidar_protection": Reason(_E, CARETAKER, STANDS),
    "lidar_power": Reason(_E, CARETAKER, STANDS),
    "lidar_mirror": Reason(_E, CARETAKER, STANDS),
    "lidar_one": Reason(_W, CARETAKER, ELSEWHERE),
    "lidar_damaged": Reason(_W, CARETAKER, SLOWLY),
    "lidar_view": Reason(_W, CARETAKER, ELSEWHERE),
    # Odometry.
    "odometry_starting": Reason(NOTE, CARETAKER, DRIVES),
    "odometry_unsure": Reason(NOTE, CARETAKER, DRIVES),
    "odometry_heading": Reason(_W, CARETAKER, DRIVES),
    "lidar_turned": Reason(_W, CARETAKER, DRIVES),
    "motion_stuck": Reason(_W, DRIVER, STANDS),
    "motion_uncommanded": Reason(_E, DRIVER, DRIVES),
    "odometry_lost": Reason(_W, CARETAKER, DRIVES),
    # Maps of the home.
    "map_starting": Reason(NOTE, CARETAKER, DRIVES),
    "map_unknown": Reason(NOTE, CARETAKER, DRIVES),
    "map_twins": Reason(_W, CARETAKER, DRIVES),
    "map_damaged": Reason(_W, CARETAKER, DRIVES),
    "map_lost": Reason(_W, CARETAKER, DRIVES),
    # Help with steering.
    "assist_starting": Reason(NOTE, CARETAKER, DRIVES),
    "assist_lost": Reason(NOTE, CARETAKER, DRIVES),
    # Camera, page, and the host itself.
    "camera_starting": Reason(NOTE, DRIVER, DRIVES),
    "camera_lost": Reason(_W, CARETAKER, DRIVES),
    "page_silent": Reason(_W, DRIVER, STANDS),
    "untuned": Reason(NOTE, CARETAKER, SLOWLY),
    "host_slow": Reason(_W, CARETAKER, DRIVES),
    "host_hot": Reason(_W, CARETAKER, DRIVES),
    # Black box and alerts.
    "log_starting": Reason(NOTE, CARETAKER, DRIVES),
    "log_missing": Reason(NOTE, BUILDER, DRIVES),
    "log_lost": Reason(_W, CARETAKER, DRIVES),
    "log_full": Reason(_W, CARETAKER, DRIVES),
    "log_disk": Reason(_W, BUILDER, DRIVES),
    "log_dropping": Reason(_W, CARETAKER, DRIVES),
    "alerts_starting": Reason(NOTE, CARETAKER, DRIVES),
    "alerts_lost": Reason(_W, BUILDER, DRIVES),
    "alerts_mqtt": Reason(_W, CARETAKER, DRIVES),
    # Plug-ins.
    "plugin_starting": Reason(NOTE, DRIVER, DRIVES),
    "plugin_trouble": Reason(_W, DRIVER, DRIVES),
    "plugin_lost": Reason(_W, CARETAKER, DRIVES),
    "plugin_raised": Reason(_W, BUILDER, DRIVES),
    "plugin_missing": Reason(_W, BUILDER, DRIVES),
    "plugin_setting": Reason(_W, BUILDER, DRIVES),
    "plugin_unstarted": Reason(_W, BUILDER, DRIVES),
    "plugin_wrong": Reason(_W, BUILDER, DRIVES),
    "plugin_ended": Reason(_W, BUILDER, DRIVES),
    "plugin_hangs": Reason(_W, BUILDER, DRIVES),
}

FILE_DAMAGED = "file_damaged"
"""A file could not be read; until it is written again."""
DEVICES_DAMAGED = "devices_damaged"
NOT_KEPT = "not_kept"
"""The disk did not take something; until it does."""

FILE_REASONS: Mapping[str, Reason] = {
    FILE_DAMAGED: Reason(_W, CARETAKER, DRIVES),
    DEVICES_DAMAGED: Reason(_W, CARETAKER, STANDS),
    NOT_KEPT: Reason(_W, CARETAKER, DRIVES),
}
"""Rows like those of REASONS, of the FILES."""
