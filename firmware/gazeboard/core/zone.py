# Stopping distances and times for the host, sent in ZONE (outgoing.py).
#
# Computed when settings change. The formulas are those of Stopping; the fields of a point are in
# gazelink/zone.py.

import struct

from gazeboard.core import limits
from gazelink import zone


# The points of one direction: for a chair that may be in any profile, and for one that is trusted.
def points(untrusted, trusted):
    found = bytearray(zone.SIZE)
    creep = untrusted.creep
    creeps = untrusted.stop(creep)
    steps = zone.FULL - zone.CREEP
    for k in range(zone.POINTS):
        speed = 0
        told = untrusted.margin
        if k >= zone.CREEP:
            faster = (untrusted.full - creep) * (k - zone.CREEP) // steps
            speed = creep + faster
            # Where it is trusted, a shorter way permits the same.
            least = min(untrusted.stop(speed), trusted.stop(speed))
            told = max(creeps, least + faster * limits.SLOW_AHEAD_MS // 1000)
        struct.pack_into(
            zone.POINT,
            found,
            k * zone.POINT_SIZE,
            speed,
            untrusted.stop(speed),
            untrusted.stop_ms(speed),
            told,
        )
    return bytes(found)
