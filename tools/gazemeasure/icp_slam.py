"""Debian's icp-slam for comparison: the track that it finds from the same scans and headings."""

from __future__ import annotations

import math
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

import gazesetup
from gazechair.base.arrays import FloatArray
from gazemeasure.carmen_log import Frame

_LIMIT_S = 600.0
_NO_RETURN_M = 81.9
# The best on Intel of twelve settings of its distances and its least goodness.
_CONFIG = """
[MappingApplication]
rawlog_file={rawlog}
rawlog_offset=0
logOutput_dir={output}
LOG_FREQUENCY=1000000
SAVE_3D_SCENE=0
SAVE_POSE_LOG=0
SHOW_PROGRESS_3D_REAL_TIME=0
SHOW_LASER_SCANS_3D=false
CAMERA_3DSCENE_FOLLOWS_ROBOT=0
localizationLinDistance=0
localizationAngDistance=0
insertionLinDistance=0.3
insertionAngDistance=20
minICPgoodnessToAccept=0.6
matchAgainstTheGrid=0
pointsMap_count=1
occupancyGrid_count=0
gasGrid_count=0
landmarksMap_count=0
beaconMap_count=0
likelihoodMapSelection=-1
[MappingApplication_pointsMap_00_insertOpts]
minDistBetweenLaserPoints=0.05
fuseWithExisting=false
isPlanarMap=1
[ICP]
ICP_algorithm=icpClassic
maxIterations=100
minAbsStep_trans=1e-6
minAbsStep_rot=1e-6
thresholdDist=0.3
thresholdAng_DEG=5
ALFA=0.8
smallestThresholdDist=0.05
onlyClosestCorrespondences=true
corresponding_points_decimation=1
"""


def track(
    frames: list[Frame], headings: FloatArray, ahead_m: Callable[[float], float]
) -> FloatArray:
    """(N, 3): a pose for each frame, in its own coordinate frame.

    Its odometry input is `headings` (rad) and `ahead_m(turn_rad)`, the distance from one frame to
    the next. Raises NotAvailable when it is not available here, or fails.
    """
    program = gazesetup.ensure_icp_slam()
    with tempfile.TemporaryDirectory(prefix="gazechair-") as name:
        folder = Path(name)
        log, rawlog, output = folder / "carmen.log", folder / "rawlog", folder / "found"
        log.write_text("\n".join(_lines(frames, headings, ahead_m)))
        _run(program.with_name("carmen2rawlog"), "-q", "-w", "-i", str(log), "-o", str(rawlog))
        config = folder / "icp.ini"
        config.write_text(_CONFIG.format(rawlog=rawlog, output=output))
        _run(program, str(config))
        found = np.loadtxt(output / "log_estimated_path.txt")[1::2, 1:4]  # odometry, then scan
    if len(found) != len(frames):
        raise gazesetup.NotAvailable(f"icp-slam gave {len(found)} poses of {len(frames)}")
    return np.asarray(found, dtype=np.float64)


def _lines(
    frames: list[Frame], headings: FloatArray, ahead_m: Callable[[float], float]
) -> list[str]:
    x = y = 0.0
    lines = ["# CARMEN Logfile"]
    for number, frame in enumerate(frames):
        if number:
            turn = float(headings[number] - headings[number - 1])
            middle = headings[number - 1] + 0.5 * turn
            x += ahead_m(turn) * math.cos(middle)
            y += ahead_m(turn) * math.sin(middle)
        ranges = " ".join(f"{range_m or _NO_RETURN_M:.3f}" for range_m in frame.ranges_m)
        heading = math.remainder(float(headings[number]), math.tau)
        pose = f"{x:.6f} {y:.6f} {heading:.6f}"
        time = f"{frame.time_s:.6f}"
        lines.append(f"FLASER {len(frame.ranges_m)} {ranges} {pose} {pose} {time} host {time}")
    return [*lines, ""]


def _run(program: Path, *words: str) -> None:
    try:
        done = subprocess.run([program, *words], capture_output=True, timeout=_LIMIT_S)
    except subprocess.TimeoutExpired as error:
        raise gazesetup.NotAvailable(f"{program.name} took over {_LIMIT_S:g} s") from error
    if done.returncode:
        raise gazesetup.NotAvailable(f"{program.name} ended with {done.returncode}")
