"""From a scan to points in the chair's frame, and the state of each direction's view."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.sensing.lidar.blind import Blindness
from gazechair.sensing.lidar.scan import BLIND, MASKED, SEEN, ChairView, Pose, Scan, to_chair
from gazelink import codes

ROUND = np.arange(-180.0, 180.0, 0.1125)


def scan(distances_m: np.ndarray, at_s: float = 1.0) -> Scan:
    return Scan(ROUND, distances_m, at_s, codes.SIMULATED)


def room(distance_m: float = 3.0) -> np.ndarray:
    return np.full(len(ROUND), distance_m)


def cover(distances_m: np.ndarray, from_deg: float, to_deg: float) -> np.ndarray:
    return np.where((from_deg <= ROUND) & (to_deg > ROUND), 0.0, distances_m)


def blind_deg(view: ChairView) -> list[int]:
    return [int(b) - 180 for b in np.flatnonzero(view.states == BLIND)]


def test_points_are_in_the_chairs_frame() -> None:
    one = Scan(np.array([0.0, 90.0]), np.array([2.0, 1.0]), 5.0, codes.REAL)
    view = to_chair(one, Pose(0.5, -0.1), ())
    assert view.points_m == pytest.approx(np.array([[2.5, -0.1], [0.5, 0.9]]))
    assert (view.acquired_s, view.source, view.origin_m) == (5.0, codes.REAL, (0.5, -0.1))
    turned = to_chair(one, Pose(0.5, -0.1, 90.0), ())
    assert turned.points_m == pytest.approx(np.array([[0.5, 1.9], [-0.5, -0.1]]))
    hanging = to_chair(one, Pose(0.5, -0.1, upside_down=True), ())
    assert hanging.points_m == pytest.approx(np.array([[2.5, -0.1], [0.5, -1.1]]))


def test_a_room_is_seen_all_round_and_the_mask_is_no_point() -> None:
    near_chair = np.where(np.abs(ROUND) > 122.0, 0.2, 3.0)
    view = to_chair(scan(near_chair), Pose(0.5), [(122.0, -122.0)])
    assert np.hypot(view.points_m[:, 0] - 0.5, view.points_m[:, 1]).min() == pytest.approx(3.0)
    assert np.all(view.states[:58] == MASKED)
    assert np.all(view.states[58:302] == SEEN)
    assert np.all(view.states[302:] == MASKED)


@given(st.floats(-180, 180), st.floats(1, 300), st.floats(-180, 180), st.booleans())
@settings(deadline=None)
def test_the_masked_degrees_are_where_the_masked_beams_point(
    from_deg: float, width_deg: float, heading_deg: float, upside_down: bool
) -> None:
    to_deg = (from_deg + width_deg + 180.0) % 360.0 - 180.0
    pose = Pose(0.0, 0.0, heading_deg, upside_down)
    view = to_chair(scan(room()), pose, [(from_deg, to_deg)])
    seen = np.unique(np.floor(np.degrees(np.arctan2(view.points_m[:, 1], view.points_m[:, 0]))))
    masked = int(np.count_nonzero(view.states == MASKED))
    assert width_deg - 1.001 <= masked <= width_deg + 2.001
    assert len(seen) >= 360 - masked - 2
    assert not np.any(view.states == BLIND)


def test_a_covered_half_is_blind_and_comes_back() -> None:
    memory = Blindness()
    assert not blind_deg(to_chair(scan(room()), Pose(), (), memory))
    view = to_chair(scan(cover(room(), 0.0, 180.0), 1.1), Pose(), (), memory)
    assert blind_deg(view) == list(range(180))
    assert not blind_deg(to_chair(scan(room(), 1.2), Pose(), (), memory))


def test_without_any_return_it_is_blind_all_round() -> None:
    assert len(blind_deg(to_chair(scan(room(0.0)), Pose(), ()))) == 360
    empty = Scan(np.zeros(0), np.zeros(0), 0.0, codes.REAL)
    assert len(blind_deg(to_chair(empty, Pose(), ()))) == 360


def test_returns_from_the_window_are_a_cover() -> None:
    view = to_chair(scan(np.where(np.abs(ROUND) < 20.0, 0.02, 3.0)), Pose(), ())
    assert blind_deg(view) == list(range(-20, 20))


def test_a_wide_hall_is_open() -> None:
    """40 x 25 m: the far end is beyond the standard scan's 16 m."""
    with np.errstate(divide="ignore"):
        ahead = np.abs(20.0 / np.cos(np.radians(ROUND)))
        aside = np.abs(12.5 / np.sin(np.radians(ROUND)))
    distances_m = np.minimum(ahead, aside)
    distances_m[distances_m > 16.38] = 0.0
    assert not blind_deg(to_chair(scan(distances_m), Pose(), ()))


def test_a_gap_with_a_near_border_is_blind_at_once() -> None:
    distances_m = np.where(ROUND < 0.0, 12.0, 2.0)
    assert blind_deg(to_chair(scan(cover(distances_m, -40.0, 0.0)), Pose(), ())) == list(
        range(-40, 0)
    )


def test_in_a_hall_a_cover_is_told_by_its_suddenness_and_stays() -> None:
    memory = Blindness()
    to_chair(scan(room(12.0)), Pose(), (), memory)
    for turn in range(20):
        covered = scan(cover(room(12.0), -60.0, 60.0), 1.1 + turn / 10)
        assert blind_deg(to_chair(covered, Pose(), (), memory)) == list(range(-60, 60))
    assert not blind_deg(to_chair(scan(room(12.0), 4.0), Pose(), (), memory))


@pytest.mark.parametrize("rate_deg_s", [20.0, 60.0])
def test_turning_towards_open_space_is_no_cover(rate_deg_s: float) -> None:
    memory = Blindness()
    wide_m = cover(room(12.0), -60.0, 60.0)  # half of it has no end
    for step in range(int(360 / rate_deg_s / 0.025)):
        turned = Pose(heading_deg=(rate_deg_s * 0.025 * step) % 360.0 - 180.0)
        assert not blind_deg(to_chair(scan(wide_m, 1.0 + 0.025 * step), turned, (), memory))


def test_a_gap_too_narrow_for_a_cover_counts_as_seen() -> None:
    assert not blind_deg(to_chair(scan(cover(room(), 10.0, 18.0)), Pose(), ()))
    assert blind_deg(to_chair(scan(cover(room(), 10.0, 19.0)), Pose(), ())) == list(range(10, 19))


def test_degrees_without_any_measurement_are_blind_even_in_the_open() -> None:
    kept = (ROUND < 10.0) | (ROUND >= 14.0)
    gap = Scan(ROUND[kept], room(12.0)[kept], 1.0, codes.REAL)
    assert blind_deg(to_chair(gap, Pose(), ())) == [10, 11, 12, 13]


@given(st.lists(st.tuples(st.floats(-180, 179.99), st.floats(0, 40)), max_size=300))
@settings(deadline=None)
def test_no_degree_counts_as_open_without_any_return_near_it(
    beams: list[tuple[float, float]],
) -> None:
    one = Scan(np.array([a for a, _ in beams]), np.array([d for _, d in beams]), 0.0, codes.REAL)
    view = to_chair(one, Pose(), ())
    measured = np.zeros(360, dtype=bool)
    for angle_deg, _ in beams:
        measured[int(angle_deg + 180.0)] = True
    for at in np.flatnonzero(view.states == SEEN):
        near = (at + np.arange(-4, 5)) % 360
        assert measured[near].any()
