"""Masks: the chair's own arcs are learned in empty surroundings; unsuitable scans are refused."""

from __future__ import annotations

import numpy as np
import pytest

from gazechair.base.footprint import DEFAULT_CORNERS
from gazechair.sensing.lidar.mask import MaskError, learn
from gazechair.sensing.lidar.scan import MASKED, Pose, Scan, to_chair
from gazelink import codes

OUTLINE = np.array(DEFAULT_CORNERS)
POSE = Pose(0.5)
ROUND = np.arange(-180.0, 180.0, 0.1125)
SPREAD_M = 0.006


def turns(distances_m: np.ndarray, count: int = 30) -> list[Scan]:
    random = np.random.default_rng(1)
    found = []
    for turn in range(count):
        noisy = distances_m + random.standard_normal(len(ROUND)) * SPREAD_M
        distances = np.where(distances_m > 0.0, noisy, 0.0)
        found.append(Scan(ROUND, distances, turn / 10, codes.SIMULATED))
    return found


def room(chair_from: float = 124.0, chair_to: float = 236.0, chair_m: float = 0.22) -> np.ndarray:
    degrees = ROUND % 360.0
    return np.where((degrees >= chair_from) & (degrees <= chair_to), chair_m, 3.0)


def test_the_chair_is_found_with_a_degree_to_spare() -> None:
    learned = learn(turns(room()), POSE, OUTLINE)
    assert learned.mask == ((123.0, -123.0),)
    assert learned.nothing == ()
    view = to_chair(turns(room())[0], POSE, learned.mask)
    assert np.hypot(view.points_m[:, 0] - 0.5, view.points_m[:, 1]).min() > 2.9
    assert np.count_nonzero(view.states == MASKED) == 114


def test_what_it_never_sees_is_masked_too() -> None:
    distances_m = room()
    distances_m[(ROUND >= 60.0) & (ROUND < 80.0)] = 0.0
    learned = learn(turns(distances_m), POSE, OUTLINE)
    assert learned.nothing == ((60.0, 80.0),)
    assert (59.0, 81.0) in learned.mask


def test_narrow_gaps_between_parts_of_the_chair_are_masked_with_them() -> None:
    distances_m = room()
    distances_m[(ROUND >= 150.0) & (ROUND < 154.0)] = 3.0  # a slit between backrest and armrest
    assert learn(turns(distances_m), POSE, OUTLINE).mask == ((123.0, -123.0),)


def test_a_chair_that_is_nowhere_in_the_way_needs_no_mask() -> None:
    assert learn(turns(np.full(len(ROUND), 3.0)), POSE, OUTLINE).mask == ()


def with_box(at_deg: float, distance_m: float) -> np.ndarray:
    distances_m = room()
    distances_m[np.abs(ROUND - at_deg) < 5.0] = distance_m
    return distances_m


REFUSED = [
    (turns(with_box(0.0, 0.4)), "something stands 0.2"),
    (turns(room(), 5), "only 5 turns"),
    (turns(room(0.0, 359.99)), "degrees would be masked"),
    (turns(np.zeros(len(ROUND))), "360 of 360 degrees"),
    (turns(np.where(np.abs(ROUND) < 20.0, 0.0, 12.0)), "no end is seen at -20"),
]


@pytest.mark.parametrize(("scans", "words"), REFUSED, ids=[words for _, words in REFUSED])
def test_nonsense_is_refused(scans: list[Scan], words: str) -> None:
    with pytest.raises(MaskError, match=words):
        learn(scans, POSE, OUTLINE)


def test_a_foot_that_moves_is_refused() -> None:
    still, moved = room(), room()
    moved[ROUND % 360.0 < 130.0] = np.where(moved[ROUND % 360.0 < 130.0] < 1.0, 0.32, 3.0)
    scans = [
        pair[turn % 2] for turn, pair in enumerate(zip(turns(still), turns(moved), strict=True))
    ]
    with pytest.raises(MaskError, match="something moves"):
        learn(scans, POSE, OUTLINE)


def test_upside_down_and_turned_it_is_the_same_chair() -> None:
    # Its left is the chair's right: the same arc seen in the mirror, about its own front.
    assert learn(turns(room(130.0, 236.0)), POSE, OUTLINE).mask == ((129.0, -123.0),)
    hanging = Pose(0.5, upside_down=True)
    assert learn(turns(room(124.0, 230.0)), hanging, OUTLINE).mask == ((123.0, -129.0),)
