# The board's settings: one table of names, defaults and limits. The index of a row is its number on
# the wire; the table is part of the schema hash, so both ends always mean the same row.
#
# Units are in the names; *_permille is of full deflection, q4 is sixteenths. No limit here exceeds
# what the safety promises allow (firmware/gazeboard/limits.py; a test compares them).

# (name, default, lowest, highest)
TABLE = (
    ("neutral_linear_count", 170, 150, 190),
    ("neutral_turn_count", 170, 150, 190),
    ("linear_permille", 600, 50, 1000),
    ("turn_permille", 500, 50, 1000),
    ("step_forward_ms", 2000, 100, 5000),
    ("step_turn_q4_deg", 160, 32, 720),
    ("step_turn_limit_ms", 6000, 1000, 10000),
    ("turn_kp_q4", 400, 0, 3200),
    ("turn_ki_q4", 0, 0, 3200),
    ("turn_kd_q4", 100, 0, 3200),
    ("turn_cutoff_q4_deg", 20, 8, 80),
    ("turn_offset_permille", 100, 0, 300),
    ("tilt_limit_q4_deg", 240, 80, 480),
    ("relay_fitted", 1, 0, 1),
)
NAMES = tuple([row[0] for row in TABLE])


def index_of(name):
    # Row number of a setting; ValueError when there is none of that name.
    if name not in NAMES:
        raise ValueError("no setting %r; there are %s" % (name, ", ".join(NAMES)))
    return NAMES.index(name)
