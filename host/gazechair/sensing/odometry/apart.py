"""Whether a direction of the position is determined by more than one thing that may move.

A bed that is pushed along a corridor, or a person, looks like the end of the corridor: what it
alone says of the position along the corridor is nothing that is known.
"""

from __future__ import annotations

import numpy as np

from gazechair.base.footprint import FloatArray

_LONG_M, _WIDE_M = 2.5, 1.3  # along the direction, and across it: a bed, with who pushes it
_EDGES = 0.05, 0.95  # of the information of a thing, across: its sides
_LEAST = 150.0  # 1/m^2, from all other things: less may be noise


def is_by_several(along_m: FloatArray, across_m: FloatArray, information: FloatArray) -> bool:
    """Whether at least two things, or a wide one, tell the position along a direction.

    (N,) each: the points along and across it, and how much each tells, 1/m^2.
    """
    total = float(information.sum())
    if total < _LEAST:
        return False
    order = np.argsort(along_m)
    along, summed = along_m[order], np.concatenate(([0.0], np.cumsum(information[order])))
    ends = np.searchsorted(along, along + _LONG_M, side="right")
    within = summed[ends] - summed[:-1]
    first = int(np.argmax(within))
    if total - within[first] >= _LEAST:
        return True
    thing = order[first : ends[first]]
    across_order = thing[np.argsort(across_m[thing])]
    shares = np.cumsum(information[across_order]) / within[first]
    left, right = across_m[across_order[np.searchsorted(shares, _EDGES)]]
    return bool(right - left > _WIDE_M)
