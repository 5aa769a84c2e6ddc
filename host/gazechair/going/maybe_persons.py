"""Finds what the clearance takes for a standing person, as seen now: the board stops before it.

This depends on the viewpoint: of a wall behind a shelf, or of a wall's end, the lidars may see no
more than of a person who stands there. So it cannot be computed from the map.
"""

from __future__ import annotations

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.going.beams import of_each_lidar
from gazechair.sensing.clearance.standing import like_persons
from gazechair.sensing.clearance.surface import surfaces
from gazechair.sensing.clearance.walls import goes_on

_NEAR_M = 2.0
"""Only things this near to the chair: those farther off look different from close by."""


def maybe_persons_m(points_m: FloatArray, origins_m: FloatArray) -> FloatArray:
    """Points (N, 2) on such things; these, beam ends and beam origins are in the chair's frame."""
    found = [np.zeros((0, 2))]
    for beams in of_each_lidar(origins_m):
        others_m = np.delete(points_m, beams, axis=0)
        x, y = origins_m[beams[0]].tolist()
        seen = surfaces(points_m[beams], (x, y))
        for thing in like_persons(seen):
            piece_m = seen.points_m[thing]
            near = float(np.hypot(piece_m[:, 0], piece_m[:, 1]).min()) < _NEAR_M
            if near and not goes_on(piece_m, others_m):
                found.append(piece_m)
    return np.concatenate(found)
