# How the chair stops in one direction: the points of the ZONE message.
#
# The board computes them from its settings (gazeboard/core/zone.py); the host only interpolates.
#
# Units are 1 mm, or 1/16 degree in turns. The first point is the standing chair: its distance is
# the margin, its time is the delay before braking. The second is creep, the last full deflection in
# the fastest profile that the chair may be in; those between are evenly spread.

from gazelink.const import const

POINTS = const(6)
# speed: units/s. stop: from the decision until it stands, margin included. stop_ms: the time that
# takes. told: the clearance with which the board permits this speed and no more.
POINT = "<HHHH"
POINT_SIZE = const(8)
SIZE = const(48)
STANDING = const(0)
CREEP = const(1)
FULL = const(5)
