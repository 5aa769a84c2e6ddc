"""Loops: matches current scans to an earlier place, and selects consistent matches."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between, compose, rotation
from gazechair.sensing.mapping.building.pose_graph import Edge
from gazechair.sensing.mapping.matching import ndt
from gazechair.sensing.mapping.matching.correlative_search import search
from gazechair.sensing.mapping.matching.likelihood_field import LikelihoodField

RANGE_M = 15.0  # points farther away than this are left out

_CELL_M, _SIGMA_M, _LEVELS = 0.06, 0.10, 4
_STEP_RAD = _CELL_M / 8.0  # half a cell at 4 m
_POINTS = 180  # for the search; the fine fit takes all
_COARSE_SCORE, _FINE_SCORE = 0.55, 0.6
# Rejected if a second place, this far off, has nearly the same score.
_RIVAL_M, _RIVAL_RATIO = 0.5, 0.93
_FIRM = 0.1  # ratio of least to most information: less is a corridor, without a position along it
_SIGMA_FIRM_M, _SIGMA_RAD = 0.03, math.radians(0.4)

_CONFIRM_WITHIN = 15  # key scans
_AGREE_M, _AGREE_RAD = 0.15, math.radians(1.5)


def match(
    known_m: FloatArray,
    seen_m: FloatArray,
    guess: FloatArray,
    window_m: float,
    window_rad: float,
    place: FloatArray,
) -> tuple[FloatArray, FloatArray] | None:
    """The pose, as seen from `place`, at which points seen from `guess` fit; its information.

    None: nowhere within the windows, at several poses, or along a line only.
    """
    field = LikelihoodField(known_m, _CELL_M, _SIGMA_M, _LEVELS)
    few = seen_m[:: max(1, len(seen_m) // _POINTS)]
    window = np.full(2, window_m)
    turns = np.arange(-window_rad, window_rad + _STEP_RAD, _STEP_RAD)
    candidates = search(
        field,
        few,
        guess[:2] - window,
        guess[:2] + window,
        guess[2] + turns,
        _COARSE_SCORE,
        _RIVAL_M,
        _RIVAL_RATIO,
    )
    if len(candidates) != 1:
        return None
    best = ndt.fit(ndt.NdtGrid(known_m), seen_m, candidates[0].pose)
    turn = rotation(-place[2])
    shape = turn @ best.information[:2, :2] @ turn.T
    soft, firm = np.linalg.eigvalsh(shape)
    if best.score < _FINE_SCORE or soft <= _FIRM * firm:
        return None
    information = np.zeros((3, 3))
    information[:2, :2] = shape / firm / _SIGMA_FIRM_M**2
    information[2, 2] = _SIGMA_RAD**-2
    return between(place, best.pose), information


def agreeing(loops: Sequence[Edge], poses: Sequence[FloatArray]) -> list[Edge]:
    """The loops that at least one other loop confirms, through the poses between their ends."""
    sure: set[int] = set()
    for at, a in enumerate(loops):
        for other, b in enumerate(loops[:at]):
            near = 0 < abs(a.second - b.second) <= _CONFIRM_WITHIN
            near &= abs(a.first - b.first) <= _CONFIRM_WITHIN
            if near and not {at, other} <= sure:
                there = between(poses[b.first], poses[a.first])
                here = between(poses[b.second], poses[a.second])
                if agree(compose(b.seen, here), compose(there, a.seen)):
                    sure |= {at, other}
    return [loops[at] for at in sorted(sure)]


def agree(one: FloatArray, other: FloatArray) -> bool:
    """Whether two measurements of the same pose may both be right."""
    off = between(one, other)
    return bool(math.hypot(off[0], off[1]) < _AGREE_M and abs(off[2]) < _AGREE_RAD)
