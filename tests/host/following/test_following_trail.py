"""The request: keeps its distance, bounded, never backward, and on the person's own way."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from gazechair.following.request import CAP_M_S, Request
from gazechair.following.trail import ACCELERATE_M_S2, BRAKE_M_S2, KEEP_M, Trail

_FRONT_M, _STEP_S = 0.65, 0.1


def _follow(
    way: list[tuple[float, float]], pose: np.ndarray, after: int = 300
) -> tuple[list[np.ndarray], list[Request]]:
    """Poses and requests of a chair that follows each request exactly, behind a patient person."""
    trail = Trail(_FRONT_M)
    trail.begin(pose)
    poses, requests, at = [pose.copy()], [], 0
    for _ in range(len(way) * 3 + after):
        person = way[at]
        if math.dist(person, pose[:2]) < _FRONT_M + 1.6:
            at = min(at + 1, len(way) - 1)
        trail.walked(*person)
        request = trail.request(pose, *person, _STEP_S)
        heading = pose[2] + 0.5 * request.yaw_rad_s * _STEP_S
        step = request.linear_m_s * _STEP_S
        pose = pose + np.array(
            (
                step * math.cos(heading),
                step * math.sin(heading),
                request.yaw_rad_s * _STEP_S,
            )
        )
        poses.append(pose)
        requests.append(request)
    return poses, requests


def _line(*corners: tuple[float, float]) -> list[tuple[float, float]]:
    found = []
    for a, b in pairwise(corners):
        count = round(math.dist(a, b) / 0.04)
        found += [
            (a[0] + (b[0] - a[0]) * k / count, a[1] + (b[1] - a[1]) * k / count)
            for k in range(count)
        ]
    return [*found, corners[-1]]


def test_keeps_its_distance_and_bounds() -> None:
    poses, requests = _follow(_line((1.85, 0.0), (6.0, 0.0)), np.zeros(3))
    assert abs(6.0 - poses[-1][0] - _FRONT_M - KEEP_M) < 0.1
    assert max(one.linear_m_s for one in requests) <= CAP_M_S
    assert min(one.linear_m_s for one in requests) >= 0.0
    for a, b in pairwise(requests):
        change = (b.linear_m_s - a.linear_m_s) / _STEP_S
        assert -BRAKE_M_S2 - 1e-9 <= change <= ACCELERATE_M_S2 + 1e-9


def test_never_backward_and_stops_for_one_who_comes_near() -> None:
    _, requests = _follow(_line((1.85, 0.0), (4.0, 0.0), (1.0, 0.0)), np.zeros(3))
    assert min(one.linear_m_s for one in requests) >= 0.0
    assert requests[-1].linear_m_s == 0.0


def test_faces_who_walks_round_it() -> None:
    way = [(1.8 * math.cos(k / 60), 1.8 * math.sin(k / 60)) for k in range(80)]
    poses, _ = _follow(way, np.zeros(3))
    assert abs(poses[-1][2] - 79 / 60) < math.radians(13.0)
    assert math.hypot(*poses[-1][:2]) < 0.1


def test_passes_a_door_where_the_person_did() -> None:
    # Along a wall, then straight through a door of 0.85 m in it, whose middle is at x = 3.
    way = _line((1.85, 0.0), (3.0, 0.0), (3.0, 4.5))
    poses, _ = _follow(way, np.zeros(3))
    assert poses[-1][1] > 2.0
    through = [one for one in poses if 0.6 < one[1] < 2.0]
    beside = [abs(one[0] - 3.0) + 0.375 * abs(math.cos(one[2] - math.pi / 2)) for one in through]
    assert max(beside) < 0.425
