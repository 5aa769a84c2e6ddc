"""Information about the pose from the map's surfaces that are seen, and the open directions.

A point on a wall gives none along the wall. What only one thing determines, which may have moved,
counts where odometry agrees.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import rotation
from gazechair.sensing.mapping.locating.map_match import Look
from gazechair.sensing.mapping.matching.ndt import NdtGrid
from gazechair.sensing.odometry import apart
from gazechair.sensing.odometry.straight import main_direction, straightened

_FLAT = 5.0  # a surface's length in proportion to its depth, variances
_SAME_RAD = math.radians(15.0)  # a wall drawn in cells is rough
_LIMIT = 4.0  # squared deviations: beyond, a point counts less
# 1/m^2, and a share of the direction determined best: with less, a direction is open. A wall that
# is drawn on a cell's edge has rough cells, and the more points it has, the more lie on those.
_LEAST, _LEAST_SHARE = 1600.0, 0.01
_WEAK = 0.05  # of the direction determined best: what little there is may be overlooked
# The pose is wrong if elsewhere along a weak direction so many more points, and such a share, lie
# on known surfaces.
_ELSEWHERE_M = np.array([0.0, *(side * m for m in np.arange(0.1, 1.21, 0.05) for side in (-1, 1))])
_MORE, _MORE_SHARE, _POINTS, _FITS = 4, 0.02, 240, 6.0


@dataclass(frozen=True)
class PoseInformation:
    """Information from one look about a pose in a map."""

    information: FloatArray
    """(3, 3), of x, y and heading; in the scale of ndt.Fit's."""
    open_axes: FloatArray
    """(N, 2): directions of the position that nothing determines."""
    by_one: FloatArray
    """(N, 2): those that only one thing determines."""
    weak_axes: FloatArray
    """(N, 2): those that little determines."""

    @classmethod
    def of(cls, grid: NdtGrid, look: Look, pose: FloatArray) -> PoseInformation:
        """The information in `look` if it was taken at `pose`."""
        turn = rotation(pose[2]).T
        turned = look.points_m @ turn
        known, _, weights, squared = grid.at(
            turned + pose[:2], (look.origins_m - look.points_m) @ turn
        )
        turned, (wxx, wxy, wyy) = turned[known], weights[known].T
        robust = 1.0 / (1.0 + squared[known] / _LIMIT) ** 2
        half, root = 0.5 * (wxx + wyy), np.hypot(0.5 * (wxx - wyy), wxy)
        across, along = half + root, half - root
        flat = across > _FLAT * along
        angles = 0.5 * np.arctan2(2.0 * wxy, wxx - wyy)
        tolerance = np.full(int(flat.sum()), _SAME_RAD)
        main_rad = main_direction(angles[flat], robust[flat])
        angles[flat] = straightened(angles[flat], tolerance, main_rad)
        rows = np.stack((np.cos(angles), np.sin(angles)), axis=1)
        ends = np.stack((-rows[:, 1], rows[:, 0]), axis=1)[~flat]
        rows, at = np.concatenate((rows, ends)), np.concatenate((turned, turned[~flat]))
        strength = np.concatenate((robust * across, (robust * along)[~flat]))
        jacobian = np.column_stack((rows, rows[:, 1] * at[:, 0] - rows[:, 0] * at[:, 1]))
        information = (jacobian.T * strength) @ jacobian
        firm = information[:2, :2] - np.outer(information[:2, 2], information[2, :2]) / (
            information[2, 2] + 1.0
        )
        found, axes = np.linalg.eigh(firm)
        by_one = apart.Constraints(rows, at, strength / apart.CORRELATED).open_axes()
        open_axes = axes.T[found < max(_LEAST, _LEAST_SHARE * found[1])]
        weak_axes = axes.T[found < _WEAK * found[1]]
        return cls(information, open_axes, np.array(by_one).reshape(-1, 2), weak_axes)


def fits_elsewhere(grid: NdtGrid, look: Look, pose: FloatArray, axes: FloatArray) -> bool:
    """Whether `look` fits clearly better at another place along one of the `axes`, (N, 2)."""
    every, count = max(1, len(look.points_m) // _POINTS), len(_ELSEWHERE_M)
    turn = rotation(pose[2]).T
    ends, starts = look.points_m[::every], look.origins_m[::every]
    at, towards = ends @ turn + pose[:2], np.tile((starts - ends) @ turn, (count, 1))
    for axis in axes:
        moved = (at + (_ELSEWHERE_M[:, None] * axis)[:, None]).reshape(-1, 2)
        fits = (grid.at(moved, towards)[3] < _FITS).reshape(count, -1).sum(axis=1)
        if fits.max() - fits[0] >= max(_MORE, _MORE_SHARE * len(at)):
            return True
    return False
