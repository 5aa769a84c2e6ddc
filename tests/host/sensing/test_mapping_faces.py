"""A thin wall has two faces: a beam hits one, and only that one counts in a fit."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.sensing.mapping.matching import ndt
from gazechair.sensing.mapping.matching.faces import faces_of

_CELL_M = 0.04


def _walls(thick: int) -> tuple[np.ndarray, np.ndarray]:
    """A room of 4 m x 3 m, its walls solid, so many cells thick; floor within and around."""
    occupied = np.zeros((120, 95), dtype=np.bool_)
    occupied[10 - thick : 110 + thick, 10 - thick : 85 + thick] = True
    occupied[10:110, 10:85] = False
    return occupied, ~occupied


def test_a_cell_belongs_to_the_face_whose_floor_is_nearest() -> None:
    occupied, free = _walls(4)
    faces = faces_of(occupied, free, _CELL_M)
    at = np.argwhere(occupied)
    wall = (at[:, 1] > 20) & (at[:, 1] < 70)
    left = {tuple(one.tolist()) for one in faces[wall & (at[:, 0] == 6)]}
    right = {tuple(one.tolist()) for one in faces[wall & (at[:, 0] == 9)]}
    assert left == {(True, False, False, False)}
    assert right == {(False, True, False, False)}


def test_a_wall_of_one_cell_has_both_faces_and_unknown_all_around_has_none() -> None:
    occupied, free = _walls(1)
    at = np.argwhere(occupied)
    wall = (at[:, 0] == 9) & (at[:, 1] > 20) & (at[:, 1] < 70)
    assert faces_of(occupied, free, _CELL_M)[wall, :2].all()
    assert not faces_of(occupied, np.zeros_like(free), _CELL_M).any()


@pytest.mark.parametrize("heading_deg", [20.0, 200.0])
def test_a_fit_is_not_drawn_into_walls_whose_other_face_is_known(heading_deg: float) -> None:
    occupied, free = _walls(2)
    known_m = (np.argwhere(occupied) + 0.5) * _CELL_M
    grid = ndt.NdtGrid(known_m, faces_of(occupied, free, _CELL_M))
    true = np.array((2.0, 1.4, math.radians(heading_deg)))
    beams = np.radians(np.arange(-100.0, 100.0, 0.6))  # what is behind is not seen
    c, s = np.cos(beams + true[2]), np.sin(beams + true[2])
    low_m, high_m = np.array((10, 10)) * _CELL_M, np.array((110, 85)) * _CELL_M
    to_x = np.where(c > 0, high_m[0] - true[0], low_m[0] - true[0]) / c
    to_y = np.where(s > 0, high_m[1] - true[1], low_m[1] - true[1]) / s
    metres = np.minimum(to_x, to_y)[:, None]
    seen = metres * np.stack((np.cos(beams), np.sin(beams)), axis=1)
    start = true + np.array((0.04, -0.03, 0.01))
    found = ndt.fit(grid, seen, start, origins_m=np.zeros(2)).pose
    assert found[:2] == pytest.approx(true[:2], abs=_CELL_M)
    both = ndt.fit(ndt.NdtGrid(known_m), seen, start).pose
    off, off_both = (math.hypot(*(one[:2] - true[:2])) for one in (found, both))
    assert off < 0.6 * off_both
