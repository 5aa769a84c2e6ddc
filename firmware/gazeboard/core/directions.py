# The directions in which a command leads, as `blocked` of Obstacles has them. Pure.

from gazelink import codes
from gazelink.const import const
from gazelink.native import micropython

# A bit per direction, then this for both axes together; tests/firmware/test_obstacle_numbers.py.
ARC_BLOCKED = const(256)


# What must not be blocked for this command to move the chair. 0: it asks for nothing, so nothing
# refuses it, even while the chair still rolls along an arc that is blocked.
@micropython.viper
def heads(i, verb: int) -> int:
    if verb != int(codes.DRIVE):
        return 1 << verb >> 1 | int(ARC_BLOCKED)
    bits = 0
    permille = int(i.linear_permille)
    if permille > 0:
        bits |= 1
    elif permille < 0:
        bits |= 2
    permille = int(i.turn_permille)
    if permille > 0:
        bits |= 4
    elif permille < 0:
        bits |= 8
    if bits:
        bits |= int(ARC_BLOCKED)
    return bits


# How a blocked arc is reported: as the side to which it leads, or as the single axis' direction.
@micropython.native
def of_arc(i):
    if i.verb != codes.DRIVE:
        return i.verb - codes.FORWARD
    if i.turn_permille:
        return codes.DIR_LEFT if i.turn_permille > 0 else codes.DIR_RIGHT
    return codes.DIR_FORWARD if i.linear_permille > 0 else codes.DIR_BACKWARD
