# Layout of CLEARANCE's `arcs` and `arc_views`: how far both axes may move at once.
#
# A chair that drives and turns follows no known curve: its axes start and stop in their own time.
# What counts is how far it turns and travels at most, in any order. The row of a quadrant at
# TURNS_DEG says how far it may travel while it turns by no more than that, either first, or both at
# once. The row of a side says the same for a chair that may turn in both directions, because its
# stick has just been reversed.

from gazelink.const import const

TURNS_DEG = (5, 8, 12, 17, 24, 34, 48, 75)  # of the quadrants' rows, ascending
BOTH_TURNS_DEG = (12, 28, 75)  # of the sides' rows

# Quadrants: forward left, backward left, forward right, backward right; then the sides.
QUADRANTS = const(4)
SIDES = const(2)
ROWS = const(8)
BOTH_ROWS = const(3)
BOTH_AT = const(32)  # rows of the sides begin here
SIZE = const(38)

UNIT_MM = const(10)  # of each byte, rounded down
FAR = const(255)  # that many units, or more

ALL_FAR = b"\xff" * SIZE
