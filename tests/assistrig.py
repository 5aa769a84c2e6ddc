"""Assist that has seen a door, by the scans of one lidar in front."""

import numpy as np

from gazechair.assist.assist import Assist
from gazechair.base.footprint import Footprint
from gazechair.board.board_commands import Clearance
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazelink import codes
from gazesim.rooms import Room, cast_rays
from gazesim.zone import zone_of

RAYS = 1600


def half(room, now_s, first_deg):
    angles = first_deg - 180.0 * (np.arange(RAYS // 2) + 0.5) / (RAYS // 2)
    segments = room.segments(0.25)
    metres = cast_rays(0.5, 0.0, np.radians(angles), segments, np.zeros((0, 3)))
    metres = np.where(np.isfinite(metres), metres, 0.0)
    times = np.linspace(now_s - 0.05, now_s, len(angles))
    wrapped = (angles + 180.0) % 360.0 - 180.0
    return Piece(wrapped, metres, times, (0.5, 0.0), RAYS)


def door_room(low, high, ahead_m=2.0):
    posts = (ahead_m, high, ahead_m, 4.0), (ahead_m, low, ahead_m, -4.0)
    return Room("door", (*posts, (-3.0, -4.0, -3.0, 4.0)))


def before_a_door(aside_m, ahead_m=2.0, width_m=0.9, margins=None):
    """Assist that has seen a door `ahead_m` before the axle, `aside_m` to the left."""
    low, high = aside_m - width_m / 2, aside_m + width_m / 2
    room = door_room(low, high, ahead_m)
    assist = Assist(Footprint(margins=margins), 1)
    assist.permits.zone = zone_of()
    assist.permits.clearance = Clearance(0, codes.REAL, 1.0, forward_mm=1200)
    for k in range(20):
        assist.motion(Motion(0.9 + 0.01 * k, 0.0, 0, 0))
    assist.see(0, half(room, 1.04, 90.0))
    assist.see(0, half(room, 1.09, -90.0))
    return assist
