"""Public lidar logs in CARMEN's format: scans, the corrected track, and the error of a track.

The logs are not part of the project: they are read from the folder GAZECHAIR_DATA, else from
../shared/data. The corrected track is only a reference; no method may see it, except as the
headings that the chair's sensor would give (`sensor_headings`).
"""

from __future__ import annotations

import gzip
import math
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between

FR079 = "freiburg-079-corrected.log.gz"
INTEL = "intel-corrected.log.gz"
_INTEL_RELATIONS = "intel.relations.gz"
_INTEL_EPOCH_S = 976052857.337284
_NEAREST_M, _FARTHEST_M = 0.05, 29.0
# The board's heading sensor.
_SCALE, _DRIFT_DEG_MIN, _NOISE_DEG = 0.005, 0.3, 0.1


class NoDataError(Exception):
    """Raised when the logs are not on this machine; the text is one plain line."""


@dataclass(frozen=True)
class Frame:
    """One scan of the log."""

    time_s: float
    points_m: FloatArray
    """(N, 2), in the robot's frame."""
    ranges_m: FloatArray
    """All beams from right to left, over 180 degrees; 0: no return."""
    reference: FloatArray
    """(3,): the corrected pose."""


def read(name: str) -> list[Frame]:
    """All scans of a log. Raises NoDataError."""
    frames = []
    with gzip.open(_path(name), "rt") as file:
        for line in file:
            if line.startswith("FLASER"):
                words = line.split()
                count = int(words[1])
                ranges = np.array(words[2 : 2 + count], dtype=np.float64)
                angles = directions_rad(count)
                seen = (ranges > _NEAREST_M) & (ranges < _FARTHEST_M)
                points = ranges * np.stack((np.cos(angles), np.sin(angles)))
                ranges = np.where(seen, ranges, 0.0)
                reference = np.array(words[2 + count : 5 + count], dtype=np.float64)
                frames.append(Frame(float(words[-1]), points[:, seen].T, ranges, reference))
    return frames


def is_here(name: str) -> bool:
    """True if that log is on this machine."""
    try:
        return _path(name).exists()
    except NoDataError:
        return False


def directions_rad(count: int) -> FloatArray:
    """Directions of a scan's beams, from right to left; 181 and 361 include both ends."""
    return np.asarray(
        math.pi / (count - count % 2) * np.arange(count) - 0.5 * math.pi, dtype=np.float64
    )


def sensor_headings(frames: list[Frame], seed: int = 0) -> FloatArray:
    """Unwrapped headings in radians, as the board's sensor would give them."""
    times = np.array([frame.time_s for frame in frames])
    true = np.unwrap([frame.reference[2] for frame in frames])
    noise = np.random.default_rng(seed).standard_normal(len(frames))
    drift = math.radians(_DRIFT_DEG_MIN / 60.0) * (times - times[0])
    return np.asarray((true - true[0]) * (1.0 + _SCALE) + drift + math.radians(_NOISE_DEG) * noise)


def position_rmse_m(track: FloatArray, reference: FloatArray) -> float:
    """RMS error of positions (N, 2), after the best rigid alignment of the whole track."""
    mean, mean_reference = track.mean(axis=0), reference.mean(axis=0)
    u, _, v = np.linalg.svd((track - mean).T @ (reference - mean_reference))
    turn = v.T @ np.diag((1.0, np.linalg.det(v.T @ u.T))) @ u.T
    off = (track - mean) @ turn.T + mean_reference - reference
    return float(np.sqrt((off**2).sum(axis=1).mean()))


def intel_relations_m(times_s: FloatArray, poses: FloatArray) -> FloatArray:
    """Translational errors of the Intel log's reference relations (Kuemmerle et al., 2009).

    Poses between those given are interpolated. Raises NoDataError.
    """
    with gzip.open(_path(_INTEL_RELATIONS), "rt") as file:
        relations = np.loadtxt(file)
    x, y, heading = poses.T
    rows = x, y, np.unwrap(heading)
    firsts, seconds = (
        np.stack([np.interp(relations[:, k], times_s + _INTEL_EPOCH_S, row) for row in rows], 1)
        for k in (0, 1)
    )
    found = [
        np.hypot(*(between(first, second)[:2] - seen))
        for first, second, seen in zip(firsts, seconds, relations[:, 2:4], strict=True)
    ]
    return np.array(found)


def _path(name: str) -> Path:
    root = os.environ.get("GAZECHAIR_DATA")
    folder = Path(root) if root else Path(__file__).parents[3] / "shared" / "data"
    path = folder / "lidar-logs" / name
    if not path.exists():
        raise NoDataError(f"{path} is missing (GAZECHAIR_DATA names the folder)")
    return path
