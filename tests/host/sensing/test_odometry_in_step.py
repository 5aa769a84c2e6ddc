"""Two lidars whose half turns end together, or a little after each other: both count."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.mapping.locating.looks import Looks
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.odometry import Odometry
from gazechair.sensing.odometry.points import OLDER_S
from gazesim.homes import Home

HALF_S, POINTS = 0.05, 400
FRONT_M, REAR_M = 0.5, -0.4
PUSHED_S, PUSHED_M_S = 1.5, 0.3


def passage() -> Home:
    """A passage of 1.8 m, whose front end is out of sight."""
    return Home("passage", ((-3.0, -0.9, 60.0, -0.9), (-3.0, 0.9, 60.0, 0.9), (-3, -0.9, -3, 0.9)))


def half(step: int, origin_m: float, front: bool, older_s: float = 0.0) -> Piece:
    """The half turn that ends at `step`, or a little before; the lidar sees to one side only."""
    share = (np.arange(POINTS) + 0.5) / POINTS
    times = (step - 1 + share) * HALF_S - older_s
    own = -(share + step % 2) * 180.0
    x = PUSHED_M_S * np.maximum(0.0, times - PUSHED_S) + origin_m
    angles = np.radians(own) % (2.0 * math.pi)
    order = np.argsort(angles)
    metres = np.empty(POINTS)
    metres[order] = passage().cast_moving(x[order], np.zeros(POINTS), angles[order], 0.25)
    seen = (np.cos(angles) > 0.2) == front
    seen &= (np.cos(angles) < -0.2) != front
    noisy = metres + np.random.default_rng(step).normal(0.0, 0.006, POINTS)
    directions = (own + 180.0) % 360.0 - 180.0
    where = (origin_m, 0.0), 2 * POINTS, int(not front)
    return Piece(directions, np.where(seen & (metres < 30.0), noisy, 0.0), times, *where)


def halves(seconds: float, older_s: float) -> Iterator[tuple[Piece, Piece]]:
    for step in range(1, round(seconds / HALF_S)):
        yield half(step, FRONT_M, True), half(step, REAR_M, False, older_s)


@pytest.mark.parametrize("older_s", [0.0, 0.004, 0.02])
def test_what_only_the_second_lidar_sees_corrects_the_place(older_s: float) -> None:
    odometry, said = Odometry(), []
    for front, rear in halves(5.0, older_s):
        odometry.motion(Motion(front.middle_s, 0.0, 0, 0))
        said += [one for one in (odometry.piece(front), odometry.piece(rear)) if one is not None]
    times = [one.time_s for one in said]
    assert times == sorted(times)
    off_m = [one.x_m - PUSHED_M_S * max(0.0, one.time_s - PUSHED_S) for one in said]
    assert off_m[-1] == pytest.approx(0.0, abs=0.03)
    assert all(
        abs(off) < 3.0 * one.along_sigma_m + 0.05 for off, one in zip(off_m, said, strict=True)
    )


def test_a_piece_that_is_too_old_or_told_again_counts_for_nothing() -> None:
    odometry = Odometry()
    for front, rear in halves(2.0, 0.0):
        assert odometry.piece(front) is not None
        assert odometry.piece(front) is None
        assert odometry.piece(replace(rear, times_s=rear.times_s - OLDER_S - 0.001)) is None


@pytest.mark.parametrize("older_s", [0.0, 0.004, 0.02])
def test_a_look_shows_what_both_see(older_s: float) -> None:
    odometry, looks = Odometry(), Looks()
    for front, rear in halves(4.0, older_s):
        odometry.motion(Motion(front.middle_s, 0.0, 0, 0))
        for piece in (front, rear):
            looks.piece(piece)
        for estimate in (odometry.piece(front), odometry.piece(rear)):
            assert isinstance(estimate, Estimate)
            assert looks.estimate(estimate)
    seen = looks.seen()
    gone_m = PUSHED_M_S * (seen.estimate.time_s - PUSHED_S)
    end = seen.look.points_m[np.abs(seen.look.points_m[:, 1]) < 0.8]
    assert (seen.look.points_m[:, 0] > 1.0).any()
    assert len(end) > 10
    assert np.abs(end[:, 0] + 3.0 + gone_m).max() < 0.04
