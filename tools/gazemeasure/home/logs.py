"""Maps from two public lidar logs: the mapper's key poses compared with the logs' references.

fr079: full rate, 4 to 8 Hz. Intel: only 910 key frames, up to a metre apart, no odometry.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

import gazesetup
from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between, compose, to_frame
from gazechair.sensing.mapping.building.loops import RANGE_M
from gazechair.sensing.mapping.building.mapper import STEP_SIGMA_M, Mapper
from gazechair.sensing.mapping.matching import ndt
from gazechair.sensing.mapping.matching.correlative_search import Candidate, search
from gazechair.sensing.mapping.matching.likelihood_field import LikelihoodField
from gazemeasure import carmen_log, icp_slam
from gazemeasure.carmen_log import Frame
from gazemeasure.report import Report

_FR079_LIMIT_M, _INTEL_LIMIT_M = 0.10, 0.13
_QUICK_FRAMES = 2500

# Scan matching that stands in for odometry on fr079: to the last key scans, after a steady speed.
_KEY_M, _KEY_RAD, _KEYS = 0.25, 0.3, 14
_STEADY_S = 0.6
_MATCH_SIGMAS = np.array((0.1, 0.1, 0.002))

# Intel: the frames are those that GMapping's defaults keep, after 1 m or 0.5 rad.
_FRAME_M, _FRAME_RAD, _FRAME_SIGMA_M, _SIDE_SIGMA_M = 1.0, 0.42, 0.1, 0.15
_PRIOR, _PRIOR_MOST = 0.02, 5.0  # of the score, per squared deviation; its limit
_AHEAD_M, _WINDOW_M = 0.4, 0.9
_HEADINGS_RAD = np.radians((-0.6, -0.3, 0.0, 0.3, 0.6))
_BEFORE, _NEARBY, _NEARBY_M = 10, 25, 4.0  # key scans that a frame is compared with
_LEAST, _APART_M, _RATIO, _RIVAL = 0.1, 0.15, 0.6, 0.06
_INTEL_SIGMAS = np.array((0.2, 0.2, 0.003))


def measure(report: Report, quick: bool) -> None:
    """Add the rows; where the logs are absent, a note."""
    try:
        frames = carmen_log.read(carmen_log.FR079)[: _QUICK_FRAMES if quick else None]
        mapper, taken = map_fr079(frames)
        reference = np.array([frames[number].reference[:2] for number in taken])
        rmse_m = carmen_log.position_rmse_m(poses_of(mapper)[:, :2], reference)
        report.add("fr079: position RMSE of the map's poses", rmse_m, "m", _FR079_LIMIT_M)
        report.add("fr079: loops closed", mapper.loops, "")
        frames = carmen_log.read(carmen_log.INTEL)
        errors_m = carmen_log.intel_relations_m(times_of(frames), poses_of(_map_intel(frames)))
        report.add("Intel: mean error of the relations", errors_m.mean(), "m", _INTEL_LIMIT_M)
        report.add("Intel: standard deviation", errors_m.std(), "m")
        _add_rival(report, frames, float(errors_m.mean()))
    except carmen_log.NoDataError as error:
        report.note(f"public logs not measured: {error}")
        return
    report.note(
        "Intel: from the lidar, the heading sensor's model and the rule by which the frames were "
        "kept (1 m or 0.5 rad); the reference track itself scores 0.126."
    )


def _add_rival(report: Report, frames: list[Frame], ours_m: float) -> None:
    """Add Intel by icp-slam, with the same headings and the same rule of the frames."""
    headings = carmen_log.sensor_headings(frames)
    try:
        found = icp_slam.track(frames, headings, _usual_step_m)
    except gazesetup.NotAvailable as error:
        report.note(f"icp-slam not measured: {error}")
        return
    rival_m = carmen_log.intel_relations_m(times_of(frames), found).mean()
    report.add("Intel: mean error by Debian's icp-slam", rival_m, "m")
    report.add("Intel: our mean error, as a share of that", ours_m / rival_m, "", 1.0)


def _usual_step_m(turn_rad: float) -> float:
    return _FRAME_M if abs(turn_rad) < _FRAME_RAD else _AHEAD_M


def poses_of(mapper: Mapper) -> FloatArray:
    """(N, 3): the poses of its key scans."""
    return np.array([key.pose for key in mapper.keys])


def times_of(frames: list[Frame]) -> FloatArray:
    """Times of the frames, s."""
    return np.array([frame.time_s for frame in frames])


def map_fr079(frames: list[Frame]) -> tuple[Mapper, list[int]]:
    """A finished map, and the numbers of the frames that became key scans."""
    headings = carmen_log.sensor_headings(frames)
    mapper, taken = Mapper(), []
    recent: deque[FloatArray] = deque(maxlen=_KEYS)
    pose = key = np.array((0.0, 0.0, headings[0]))
    velocity = np.zeros(2)
    grid: ndt.NdtGrid | None = None
    for number, frame in enumerate(frames):
        points = _near(frame.points_m)
        if grid is not None:
            elapsed_s = frame.time_s - frames[number - 1].time_s
            ahead = pose[:2] + velocity * min(elapsed_s, _STEADY_S)
            turned = headings[number] - headings[number - 1]
            guess = np.array((*ahead, pose[2] + turned))
            found = ndt.fit(grid, points, guess, _MATCH_SIGMAS).pose
            moved = found[:2] - pose[:2]
            steady = elapsed_s < _STEADY_S
            velocity = 0.5 * (velocity + moved / max(elapsed_s, 0.05)) if steady else np.zeros(2)
            pose = np.array((*found[:2], guess[2]))
        since = between(key, pose)
        if grid is None or math.hypot(since[0], since[1]) > _KEY_M or abs(since[2]) > _KEY_RAD:
            recent.append(to_frame(points, pose))
            key, grid = pose, ndt.NdtGrid(np.concatenate(recent))
        if mapper.add(pose, frame.points_m, float(headings[number]), frame.time_s):
            taken.append(number)
    mapper.finish()
    return mapper, taken


def _map_intel(frames: list[Frame]) -> Mapper:
    """A finished map: every frame is a key scan, found by a wide search among those near it."""
    headings = carmen_log.sensor_headings(frames)
    mapper = Mapper(0.0, 0.0)
    pose = np.array((0.0, 0.0, headings[0]))
    for number, frame in enumerate(frames):
        sigma_m = STEP_SIGMA_M
        if number:
            turn = float(headings[number] - headings[number - 1])
            step, rival_m = _intel_step(mapper, _near(frame.points_m), turn)
            pose, sigma_m = compose(pose, step), max(sigma_m, rival_m)
        mapper.add(pose, frame.points_m, float(headings[number]), frame.time_s, sigma_m)
    mapper.finish()
    return mapper


def _intel_step(mapper: Mapper, points_m: FloatArray, turn_rad: float) -> tuple[FloatArray, float]:
    """Motion from the newest key scan to the frame; distance of the farthest good rival, m."""
    last = mapper.keys[-1].pose
    poses = poses_of(mapper)
    away_m = np.hypot(*(poses[:, :2] - last[:2]).T)
    before = range(max(0, len(poses) - _BEFORE), len(poses))
    near = np.argsort(away_m)[:_NEARBY]
    near = near[(near < len(poses) - _BEFORE) & (away_m[near] < _NEARBY_M)]
    known = mapper.known_m([*before, *near.tolist()])
    middle = last[2] + 0.5 * turn_rad
    ahead = np.array((math.cos(middle), math.sin(middle)))
    centre = last[:2] + _AHEAD_M * ahead
    candidates = search(
        LikelihoodField(known, 0.05, 0.08, 4),
        points_m,
        centre - _WINDOW_M,
        centre + _WINDOW_M,
        last[2] + turn_rad + _HEADINGS_RAD,
        _LEAST,
        _APART_M,
        _RATIO,
    )

    def value(candidate: Candidate) -> float:
        moved = candidate.pose[:2] - last[:2]
        forward, aside = float(moved @ ahead), float(moved @ (-ahead[1], ahead[0]))
        off = forward - _FRAME_M
        if abs(turn_rad) >= _FRAME_RAD:  # the distance may be anything up to the whole
            off = max(0.0, off, -forward)
        length = min(_PRIOR_MOST, (off / _FRAME_SIGMA_M) ** 2)
        return candidate.score - _PRIOR * (length + (aside / _SIDE_SIGMA_M) ** 2)

    best = max(candidates, key=value)
    rivals = [one.pose for one in candidates if value(one) > value(best) - _RIVAL]
    rival_m = max(math.hypot(*(pose[:2] - best.pose[:2])) for pose in rivals)
    guess = np.array((*best.pose[:2], last[2] + turn_rad))
    step = between(last, ndt.fit(ndt.NdtGrid(known), points_m, guess, _INTEL_SIGMAS).pose)
    return np.array((step[0], step[1], turn_rad)), rival_m


def _near(points_m: FloatArray) -> FloatArray:
    return points_m[np.hypot(points_m[:, 0], points_m[:, 1]) < RANGE_M]
