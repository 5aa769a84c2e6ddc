# Every number with a meaning on the wire: verbs, modes, states, motions, orders, reasons, faults.
# Texts for people are in web/strings/, with the names in these tables as keys.

# Verbs: the driver's requests. A command repeats its verb for as long as its press is active.
STOP = 0
FORWARD = 1
BACKWARD = 2
LEFT = 3
RIGHT = 4
DRIVE = 5  # proportional: uses linear_permille and turn_permille
VERBS = ("stop", "forward", "backward", "left", "right", "drive")

# Modes: a step is one small motion per command; continuous moves while the command is active; tune
# is one open-loop pulse of COMMAND's permille, active, for pulse_ms at most: to identify the chair;
# auto is a drive that nobody holds: the press goes on under supervision only (SUPERVISION).
STEP = 0
CONTINUOUS = 1
TUNE = 2
AUTO = 3
MODES = ("step", "continuous", "tune", "auto")

# States of the safety core.
DISARMED = 0
ARMING = 1
ARMED = 2
STATES = ("disarmed", "arming", "armed")

# Motion in progress on the board (the first prototype's 0 Stop, 1 Forward, 2 Turn, continued).
STOPPED = 0
MOVING_FORWARD = 1
TURNING = 2
MOVING_BACKWARD = 3
DRIVING = 4
MOTIONS = ("stopped", "forward", "turn", "backward", "drive")

# Directions in which clearance is judged: bit numbers in `blocked`, 2-bit fields in `decisions`.
DIR_FORWARD = 0
DIR_BACKWARD = 1
DIR_LEFT = 2
DIR_RIGHT = 3
DIRECTIONS = ("forward", "backward", "left", "right")

# The board's decision per direction, 2 bits each in `decisions`.
FREE = 0
SLOW = 1
BLOCKED = 2
UNKNOWN = 3  # no fresh obstacle data: counts as blocked
DECISIONS = ("free", "slow", "blocked", "unknown")

# Of HELLO: who says it, and bits of the board's flags.
ROLE_HOST = 0
ROLE_BOARD = 1
FLAG_SIMULATED = 1
FLAG_ARMED = 2

# Owners: who drives. 0 is none; only the owner's motion commands count, anyone's stop does.
NOBODY = 0
DRIVER = 1
CARETAKER = 2
OWNERS = ("nobody", "driver", "caretaker")

# Orders: acted on once per new order number.
DISARM = 0
ARM = 1
EMERGENCY_STOP = 2
RESET_FAULTS = 3
ORDERS = ("disarm", "arm", "emergency_stop", "reset_faults")

# Requests for the settings (settings_table.py). A set value is active at once and kept
# across a reset only after a save.
SETTING_GET = 0
SETTING_SET = 1
SETTING_SAVE = 2
SETTING_DEFAULTS = 3
SETTING_SAVE_HEADING = 4  # store the heading sensor's calibration
# Set one of the joystick's neutral counts, which plain set refuses. The board does not arm until a
# save, and forgets the change when another session begins first. A new neutral, and any after the
# stored settings were damaged, is saved only straight after both its counts were set.
SETTING_SET_NEUTRAL = 5
SETTING_REQUESTS = ("get", "set", "save", "defaults", "save_heading", "set_neutral")

# Source of the obstacle data. A real board arms only with REAL.
REAL = 0
SIMULATED = 1
REPLAYED = 2
SOURCES = ("real", "simulated", "replayed")

# Reasons: why a command is overruled (override) or arming is refused (arm_reason). 0 is no reason.
NO_REASON = 0
NOT_ARMED = 1
COMMAND_EXPIRED = 2
NEEDS_NEW_COMMAND = 3
TIME_LIMIT = 4
OBSTACLE_FORWARD = 5  # OBSTACLE_FORWARD + direction, in the order of DIRECTIONS
OBSTACLE_BACKWARD = 6
OBSTACLE_LEFT = 7
OBSTACLE_RIGHT = 8
NOT_OWNER = 9
NOT_CONNECTED = 10
NEUTRAL_NOT_PROVEN = 11
COMMAND_ACTIVE = 12
NO_OWNER = 13
BAD_COMMAND = 14
VERSION_DIFFERS = 15
MAINTENANCE_WHILE_ARMED = 16
SETTING_UNKNOWN = 17
SETTING_OUT_OF_RANGE = 18
SETTING_WHILE_ARMED = 19
SETTING_NOT_STORED = 20
SENSOR_NOT_CALIBRATED = 21
TUNING_ANGLE = 22  # a tuning pulse turned the chair as far as it may
ABOVE_CREEP = 23  # only creep is allowed in this direction, and the chair needs more to move at all
SETTING_BY_CALIBRATION = 24  # the joystick's neutral: only by SETTING_SET_NEUTRAL
# Why an auto motion has ended, or does not begin:
SUPERVISION_LOST = 25
AUTO_OVERRULED = 26  # an obstacle has overruled it for too long
AUTO_LIMIT = 27  # its time is over
ANOTHER_PRESS = 28  # by anyone, a bypass included
REASONS = (
    "none",
    "not_armed",
    "command_expired",
    "needs_new_command",
    "time_limit",
    "obstacle_forward",
    "obstacle_backward",
    "obstacle_left",
    "obstacle_right",
    "not_owner",
    "not_connected",
    "neutral_not_proven",
    "command_active",
    "no_owner",
    "bad_command",
    "version_differs",
    "maintenance_while_armed",
    "setting_unknown",
    "setting_out_of_range",
    "setting_while_armed",
    "setting_not_stored",
    "sensor_not_calibrated",
    "tuning_angle",
    "above_creep",
    "setting_by_calibration",
    "supervision_lost",
    "auto_overruled",
    "auto_limit",
    "another_press",
)

# Faults: bit numbers in `faults`. As a reason, fault n is code FAULT_REASON + n.
FAULT_REASON = 32
HOST_SILENT = 0
SERVICE_STALLED = 1
OBSTACLE_DATA_OLD = 2
HEADING_FROZEN = 3
HEADING_BUS = 4
HEADING_RESET = 5
HEADING_JUMP = 6
WIPER = 7
TICK_EXCEPTION = 8
TICK_STALLED = 9
EMERGENCY = 10
TILT = 11
RELAY_OPEN = 12
RELAY_STUCK = 13
CALIBRATION = 14
WATCHDOG_BOOTS = 15
SIMULATED_SOURCE = 16
NO_HARD_TIMER = 17
DISOBEYS = 18  # it turns although it should stand, or otherwise than commanded
RELAY_UNEXPECTED = 19  # the settings have no contact fitted, and one closes
TILT_UNKNOWN = 20  # the sensor is dead, and creeping on has had its time
STORAGE = 21  # a stored file is damaged, or the flash takes none

# Severity of a fault: what the page's corner shows.
WARNING = 1
ERROR = 2

# (bit, name, severity, latched: cleared by reset_faults only, once its cause is gone)
FAULTS = (
    (HOST_SILENT, "host_silent", ERROR, False),
    (SERVICE_STALLED, "service_stalled", ERROR, False),
    (OBSTACLE_DATA_OLD, "obstacle_data_old", ERROR, False),
    (HEADING_FROZEN, "heading_frozen", WARNING, False),
    (HEADING_BUS, "heading_bus", WARNING, False),
    (HEADING_RESET, "heading_reset", WARNING, False),
    (HEADING_JUMP, "heading_jump", WARNING, False),
    (WIPER, "wiper", ERROR, True),
    (TICK_EXCEPTION, "tick_exception", ERROR, True),
    (TICK_STALLED, "tick_stalled", ERROR, False),
    (EMERGENCY, "emergency", ERROR, True),
    (TILT, "tilt", ERROR, False),
    (RELAY_OPEN, "relay_open", ERROR, False),
    (RELAY_STUCK, "relay_stuck", ERROR, False),
    (CALIBRATION, "calibration", ERROR, False),
    (WATCHDOG_BOOTS, "watchdog_boots", ERROR, True),
    (SIMULATED_SOURCE, "simulated_source", ERROR, False),
    (NO_HARD_TIMER, "no_hard_timer", ERROR, False),
    (DISOBEYS, "disobeys", ERROR, True),
    (RELAY_UNEXPECTED, "relay_unexpected", ERROR, True),
    (TILT_UNKNOWN, "tilt_unknown", ERROR, False),
    (STORAGE, "storage", ERROR, True),
)

# Without a heading that can be trusted; the tilt comes from the same sensor, and a heading that
# jumps says nothing against it.
HEADING_FAULTS = (
    (1 << HEADING_FROZEN) | (1 << HEADING_BUS) | (1 << HEADING_RESET) | (1 << HEADING_JUMP)
)
TILT_LOST = HEADING_FAULTS & ~(1 << HEADING_JUMP)


def reason_name(code):
    # Name of an override or arm_reason code, as in the string tables; "unknown_<n>" if a newer
    # board sent it.
    if code < len(REASONS):
        return REASONS[code]
    for fault in FAULTS:
        if fault[0] == code - FAULT_REASON:
            return fault[1]
    return "unknown_%d" % code
