"""Poses in the plane, (3,) arrays: x, y in metres, heading in radians counter-clockwise."""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.angles import half_turn_rad
from gazechair.base.arrays import FloatArray


def compose(frame: FloatArray, pose: FloatArray) -> FloatArray:
    """`pose`, given relative to `frame`, transformed into the frame in which `frame` is given."""
    c, s = math.cos(frame[2]), math.sin(frame[2])
    x = frame[0] + c * pose[0] - s * pose[1]
    y = frame[1] + s * pose[0] + c * pose[1]
    return np.array((x, y, frame[2] + pose[2]))


def between(first: FloatArray, second: FloatArray) -> FloatArray:
    """`second` as seen from `first`; the heading within half a turn."""
    c, s = math.cos(first[2]), math.sin(first[2])
    dx, dy = second[0] - first[0], second[1] - first[1]
    return np.array((c * dx + s * dy, c * dy - s * dx, half_turn_rad(second[2] - first[2])))


def rotation(angle_rad: float) -> FloatArray:
    """(2, 2), to multiply columns with: turns counter-clockwise."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return np.array(((c, -s), (s, c)))


def to_frame(points_m: FloatArray, pose: FloatArray) -> FloatArray:
    """(N, 2) points relative to `pose`, transformed into the frame in which `pose` is given."""
    return np.asarray(points_m @ rotation(pose[2]).T + pose[:2])


def from_frame(points_m: FloatArray, pose: FloatArray) -> FloatArray:
    """The inverse of `to_frame`: (N, 2) points as seen from `pose`."""
    return np.asarray((points_m - pose[:2]) @ rotation(pose[2]))
