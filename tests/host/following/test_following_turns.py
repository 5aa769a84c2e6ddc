"""Turns: pieces of the foremost lidar, joined as seen from one pose."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gazechair.following.turns import Turn, Turns
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.points import OLDER_S

_WALL_M = 3.0
_SPEED_M_S, _RATE_DEG_S = 0.3, 25.0
_FRONT, _REAR = (0.5, 0.0), (-0.4, 0.0)


def _pose(at_s: float) -> tuple[float, float, float]:
    """Estimates of a chair that drives a bend."""
    turned = math.radians(_RATE_DEG_S) * at_s
    radius_m = _SPEED_M_S / math.radians(_RATE_DEG_S)
    return radius_m * math.sin(turned), radius_m * (1.0 - math.cos(turned)), turned


def _estimate(at_s: float, track: int = 1) -> Estimate:
    x, y, turned = _pose(at_s)
    speeds = (_SPEED_M_S, 0.0, _RATE_DEG_S)
    return Estimate(at_s, x, y, math.degrees(turned), *speeds, 0.0, 0.0, 0.1, 0.02, 1.0, (), track)


def _half(number: int, origin: tuple[float, float] = _FRONT) -> Piece:
    """Half a clockwise turn that begins ahead, 50 ms each, in a round room about the start."""
    times = 0.05 * number + np.linspace(0.0, 0.0498, 250)
    directions = -180.0 * number - np.linspace(0.0, 179.3, 250)
    metres = []
    for at_s, direction in zip(times.tolist(), directions.tolist(), strict=True):
        x, y, heading = _pose(at_s)
        x += origin[0] * math.cos(heading) - origin[1] * math.sin(heading)
        y += origin[0] * math.sin(heading) + origin[1] * math.cos(heading)
        along = x * math.cos(heading + math.radians(direction))
        along += y * math.sin(heading + math.radians(direction))
        metres.append(-along + math.sqrt(along**2 - x * x - y * y + _WALL_M**2))
    return Piece(directions, np.array(metres), times, origin, 500)


def _turns(turns: Turns, numbers: range, track: int = 1) -> list[Turn]:
    found = []
    for number in numbers:
        piece = _half(number)
        turns.piece(piece)
        found.append(turns.estimate(_estimate(piece.middle_s, track)))
    return [one for one in found if one is not None]


def test_a_turn_made_while_the_chair_moves_shows_the_room_as_it_is() -> None:
    turns = Turns()
    _turns(turns, range(1))
    (first, second) = _turns(turns, range(1, 5))
    for turn in (first, second):
        assert len(turn.scan.points_m) in (499, 500)
        c, s = math.cos(turn.pose[2]), math.sin(turn.pose[2])
        points = turn.scan.points_m @ np.array(((c, s), (-s, c))) + turn.pose[:2]
        assert np.abs(np.hypot(*points.T) - _WALL_M).max() < 0.003
        off = turn.scan.points_m - turn.scan.origin_m
        assert (np.diff(np.arctan2(off[:, 1], off[:, 0])) >= 0.0).all()
    assert second.scan.at_s - first.scan.at_s == pytest.approx(0.1)


def test_only_what_belongs_together_is_one_turn() -> None:
    turns = Turns()
    _turns(turns, range(3))
    (turn,) = _turns(turns, range(4, 5))  # the piece between was lost
    assert len(turn.scan.points_m) == 250
    (turn,) = _turns(turns, range(5, 7), track=2)
    assert turn.track == 2
    assert len(turn.scan.points_m) in (499, 500)


def test_pieces_of_any_length_make_turns_that_show_everything_once() -> None:
    turns, sizes = Turns(), []
    times = np.arange(0.0, 1.2, 0.0002)
    for begin in range(0, len(times) - 300, 300):  # 60 ms
        part = times[begin : begin + 300]
        piece = Piece(part * 3600.0, np.full(300, 3.0), part, _FRONT, 500)
        turns.piece(piece)
        turn = turns.estimate(_estimate(piece.middle_s))
        if turn is not None:
            sizes.append(len(turn.scan.points_m))
    assert len(sizes) >= 9
    assert set(sizes[1:]) <= {499, 500}


def test_what_is_masked_costs_no_turn() -> None:
    turns, found = Turns(), []
    for number in range(20):
        whole = _half(number)
        kept = slice(0, 150) if number % 2 == 0 else slice(100, 250)
        arrays = (whole.directions_deg[kept], whole.distances_m[kept], whole.times_s[kept])
        piece = Piece(*arrays, whole.origin_m, 500)
        turns.piece(piece)
        found.append(turns.estimate(_estimate(piece.middle_s)))
    sizes = [len(one.scan.points_m) for one in found if one is not None]
    assert len(sizes) == 10
    assert min(sizes[1:]) >= 299


def test_only_the_foremost_lidar_counts() -> None:
    turns = Turns()
    half = _half(0, _REAR)
    rear = replace(half, times_s=half.times_s + 0.01, lidar=1)
    turns.piece(rear)
    turns.piece(_half(0))
    turns.piece(rear)
    assert turns.estimate(_estimate(rear.middle_s)) is None
    for turn in _turns(turns, range(1, 4)):
        assert turn.scan.origin_m == _FRONT


def test_of_two_lidars_at_one_place_one_counts() -> None:
    turns = Turns()
    other = replace(_half(0), times_s=_half(0).times_s + 0.01, lidar=1)
    turns.piece(_half(0))
    turns.piece(other)
    assert turns.estimate(_estimate(other.middle_s)) is None


@pytest.mark.parametrize("older_s", [0.0, 0.01, OLDER_S])
def test_a_piece_that_is_older_than_the_other_lidars_counts(older_s: float) -> None:
    turns, found = Turns(), []
    for number in range(6):
        piece, other = _half(number), _half(number, _REAR)
        rear = replace(other, times_s=other.times_s + older_s, lidar=1)
        turns.piece(rear)
        turns.piece(piece)
        for _ in range(2):  # odometry tells both at the same time
            found.append(turns.estimate(_estimate(rear.middle_s)))
    whole = [one for one in found if one is not None]
    assert len(whole) == 3
    for turn in whole[1:]:
        assert turn.scan.origin_m == _FRONT
        assert len(turn.scan.points_m) in (499, 500)
        c, s = math.cos(turn.pose[2]), math.sin(turn.pose[2])
        points = turn.scan.points_m @ np.array(((c, s), (-s, c))) + turn.pose[:2]
        assert np.abs(np.hypot(*points.T) - _WALL_M).max() < 0.004
