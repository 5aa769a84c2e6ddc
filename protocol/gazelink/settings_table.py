# The board's settings: one table of names, defaults and limits.
#
# The index of a row is its number on the wire; the table is part of the schema hash, so both ends
# always mean the same row.
#
# Units are in the names; *_permille is of full deflection, q4 is sixteenths. No limit here exceeds
# what the safety promises allow (firmware/gazeboard/core/limits.py; a test compares them).

# The chair's speed profiles that have rows of their own.
PROFILES = ("1.2", "2.1", "3.1", "4.1", "5.1")

NO_CASTERS_Q4_DEG = 320  # caster_q4_deg of casters without effect: the row has no sign

# (name, default, lowest, highest)
_GENERAL = (
    ("neutral_linear_count", 170, 150, 190),
    ("neutral_turn_count", 170, 150, 190),
    ("profile", 2, 0, 4),  # the chair's selected profile: row of PROFILES
    ("linear_permille", 600, 50, 1000),
    ("turn_permille", 500, 50, 1000),
    ("step_forward_ms", 2000, 100, 5000),
    ("step_turn_q4_deg", 160, 32, 1440),
    ("step_turn_permille", 1000, 50, 1000),  # of a step turn and of a tuning pulse
    ("step_turn_limit_ms", 6000, 1000, 10000),
    ("tune_angle_q4_deg", 480, 80, 960),
    ("step_ramp_ms", 300, 0, 1000),  # a step straight on begins and ends over this long
    ("turn_cutoff_q4_deg", 16, 8, 80),  # nearer, less the sensor's error, a step turn has arrived
    ("hold_kp_q4", 320, 0, 3200),  # going straight: permille per degree of heading error
    ("hold_kd_q4", 80, 0, 3200),  # permille per degree/s
    ("hold_permille", 150, 0, 300),  # the most that holding puts out
    ("reaction_ms", 350, 200, 1000),  # from the obstacle's echo to the first braking
    ("stop_margin_mm", 100, 50, 500),
    ("stop_margin_q4_deg", 48, 16, 160),
    ("creep_mm_s", 120, 50, 200),
    ("tilt_limit_q4_deg", 240, 80, 480),
    ("relay_fitted", 1, 0, 1),
    # Of an auto motion. A slower one could not turn a chair whose profile is not known yet.
    ("supervision_ms", 3000, 500, 10000),  # it ends when its supervision is older
    ("auto_mm_s", 350, 250, 350),  # forward; in a turn, of the chair's outermost point
    ("auto_limit_s", 600, 10, 1800),
)
# One of each per profile: what the chair makes of the joystick. Speeds are at full deflection; the
# dead time is from the wiper to the heading as the board reads it, the sensor's delay included.
PROFILE_ROWS = (
    ("forward_mm_s", 100, 2000),
    ("backward_mm_s", 100, 2000),
    ("brake_mm_s2", 200, 2000),
    ("left_q4_dps", 80, 2400),
    ("right_q4_dps", 80, 2400),
    ("deadband_permille", 0, 300),
    ("dead_time_ms", 20, 400),
    ("lag_ms", 20, 800),
    ("accelerate_dps2", 20, 600),
    ("brake_dps2", 20, 600),
    ("breakaway_q4_dps", 0, 480),  # a ramp below this does not set a standing chair in motion
    ("caster_q4_deg", 0, 640),  # turned further after a reversal, above NO_CASTERS_Q4_DEG
    ("caster_way_q4_deg", 80, 2000),  # turned by the wheels until the casters have swung round
    ("tuned", 0, 1),
)
# Until a chair is tuned: the speeds seen on the chair, the rest from comparable chairs.
_DEFAULTS = (
    (194, 250, 500, 364, 273, 56, 140, 350, 36, 150, 155, 320, 400, 0),
    (278, 278, 500, 637, 637, 56, 140, 350, 36, 150, 155, 320, 400, 0),
    (361, 389, 500, 728, 728, 56, 140, 350, 36, 150, 155, 320, 400, 0),
    (444, 472, 500, 910, 910, 56, 140, 350, 36, 150, 155, 320, 400, 0),
    (556, 389, 500, 910, 910, 56, 140, 350, 36, 150, 155, 320, 400, 0),
)


def profile_row(profile, name):
    # Name in TABLE of a profile's row; `profile` is a row of PROFILES.
    return "p%s_%s" % (PROFILES[profile].replace(".", "_"), name)


TABLE = _GENERAL + tuple(
    [
        (profile_row(profile, row[0]), _DEFAULTS[profile][at], row[1], row[2])
        for profile in range(len(PROFILES))
        for at, row in enumerate(PROFILE_ROWS)
    ]
)
NAMES = tuple([row[0] for row in TABLE])


def index_of(name):
    # Row number of a setting; ValueError when there is none of that name.
    if name not in NAMES:
        raise ValueError("no setting %r; there are %s" % (name, ", ".join(NAMES)))
    return NAMES.index(name)
