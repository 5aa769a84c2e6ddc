"""A public log replayed through odometry alone, with headings as of the board's sensor."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.odometry.odometry import Odometry
from gazemeasure import carmen_log
from gazemeasure.carmen_log import Frame
from gazemeasure.report import Report

_LIMIT_M = 0.25
_SEEDS, _SEEDS_QUICK = range(4), range(1)


Run = Callable[[Callable[[int], tuple[float, float]], Sequence[int]], list[tuple[float, float]]]


def measure(report: Report, quick: bool, run: Run) -> None:
    """Add the rows; where the log is absent, a note. `run` maps seeds."""
    try:
        frames = carmen_log.read(carmen_log.FR079)
    except carmen_log.NoDataError as error:
        report.note(f"odometry of the public log not measured: {error}")
        return
    found = run(_of_log, _SEEDS_QUICK if quick else _SEEDS)
    report.add(
        "fr079, odometry alone: position RMSE, worst", max(one[0] for one in found), "m", _LIMIT_M
    )
    report.add("  computing, mean of a scan", float(np.mean([one[1] for one in found])), "ms")
    steps = np.diff([frame.reference[:2] for frame in frames], axis=0)
    way_m = float(np.hypot(steps[:, 0], steps[:, 1]).sum())
    report.note(
        f"fr079: {way_m:.0f} m, {len(found)} headings drawn; places within 25 m are remembered"
    )


def _of_log(seed: int) -> tuple[float, float]:
    """See `rmse_m`; raises NoDataError."""
    return rmse_m(carmen_log.read(carmen_log.FR079), seed)


def rmse_m(frames: list[Frame], seed: int) -> tuple[float, float]:
    """RMS error of the positions after the best rigid alignment; milliseconds per scan."""
    headings = np.degrees(carmen_log.sensor_headings(frames, seed))
    directions = np.degrees(carmen_log.directions_rad(len(frames[0].ranges_m)))
    odometry = Odometry()
    places, reference = [], []
    spent_s = 0.0
    for frame, heading in zip(frames, headings, strict=True):
        odometry.motion(Motion(frame.time_s, float(heading % 360.0)))
        at_s = np.full(len(directions), frame.time_s)
        begin_s = time.process_time()
        found = odometry.piece(Piece(directions, frame.ranges_m, at_s, (0.0, 0.0), 720))
        spent_s += time.process_time() - begin_s
        if found is not None:
            places.append((found.x_m, found.y_m))
            reference.append(frame.reference[:2])
    error_m = carmen_log.position_rmse_m(np.array(places), np.array(reference))
    return error_m, 1000.0 * spent_s / len(frames)
