"""The classic sectors: an obstacle blocks its direction, what is not seen is never free."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazelink import codes
from gazemeasure.prototype_rule import (
    ALL_BLOCKED,
    DISTANCE_M,
    HYSTERESIS_M,
    MIN_COVERAGE,
    Sector,
    blocked,
    measure,
)

FORWARD, BACKWARD, LEFT, RIGHT = (1 << d for d in range(4))
ROUND = np.arange(-180.0, 180.0, 0.25)


def bits(distances_m: np.ndarray, before: int = 0) -> int:
    return blocked(ROUND, distances_m, before)


def room(default_m: float = 3.0, **at_m: float) -> np.ndarray:
    """Distances all round, with single beams as `deg_30=0.4` (m30 for -30)."""
    distances = np.full(len(ROUND), default_m)
    for name, value in at_m.items():
        angle = float(name.removeprefix("deg_").replace("m", "-"))
        distances[np.argmin(np.abs(ROUND - angle))] = value
    return distances


def test_a_free_room_leaves_only_what_no_sector_watches_blocked() -> None:
    assert bits(room()) == BACKWARD


@pytest.mark.parametrize(
    ("beam", "blocked"),
    [
        ("deg_0", FORWARD),
        ("deg_29", FORWARD),
        ("deg_m29", FORWARD),
        ("deg_30", FORWARD | LEFT),
        ("deg_m30", FORWARD | RIGHT),
        ("deg_60", LEFT),
        ("deg_90", LEFT),
        ("deg_91", 0),
        ("deg_m60", RIGHT),
        ("deg_m90", RIGHT),
        ("deg_m91", 0),
        ("deg_m180", 0),
    ],
)
def test_one_beam_blocks_exactly_its_directions(beam: str, blocked: int) -> None:
    assert bits(room(**{beam: 0.49})) == BACKWARD | blocked
    assert bits(room(**{beam: 0.5})) == BACKWARD


def test_a_blocked_direction_is_free_again_five_centimetres_later() -> None:
    assert HYSTERESIS_M == 0.05
    assert bits(room(deg_0=0.54), before=FORWARD) & FORWARD
    assert not bits(room(deg_0=0.54), before=0) & FORWARD
    assert not bits(room(deg_0=0.56), before=FORWARD) & FORWARD


def test_no_points_block_everything() -> None:
    empty = np.zeros(0)
    assert blocked(empty, empty) == ALL_BLOCKED


def test_beams_without_a_return_are_not_seen() -> None:
    assert bits(np.zeros(len(ROUND))) == ALL_BLOCKED


def test_a_half_covered_sector_is_enough_and_less_is_not() -> None:
    distances = room()
    front = (ROUND >= -30) & (ROUND <= 30)
    distances[front & (ROUND >= 0)] = 0.0
    assert not bits(distances) & FORWARD
    distances[front & (ROUND >= -1)] = 0.0
    assert bits(distances) & FORWARD


points = st.lists(
    st.tuples(st.floats(-180, 179.99), st.one_of(st.just(0.0), st.floats(0.05, 16.0))), max_size=200
)


@settings(deadline=None)
@given(points, st.floats(-180, 180), st.floats(1, 180))
def test_a_reading_is_the_nearest_return_of_its_sector(
    beams: list[tuple[float, float]], from_deg: float, width_deg: float
) -> None:
    sector = Sector(codes.DIR_FORWARD, from_deg, from_deg + width_deg)
    angles = np.array([a for a, _ in beams])
    distances = np.array([d for _, d in beams])
    reading = measure(angles, distances, sector)
    assert 0.0 <= reading.coverage <= 1.0
    inside = [d for a, d in beams if (a - from_deg) % 360 <= width_deg and d > 0]
    assert reading.nearest_m == (min(inside) if inside else float("inf"))


@settings(deadline=None)
@given(points, st.integers(0, 15))
def test_free_means_seen_and_nothing_near(beams: list[tuple[float, float]], before: int) -> None:
    angles = np.array([a for a, _ in beams])
    distances = np.array([d for _, d in beams])
    reading = measure(angles, distances, Sector(codes.DIR_FORWARD, -30.0, 30.0))
    free = not blocked(angles, distances, before) & FORWARD
    limit_m = DISTANCE_M + (HYSTERESIS_M if before & FORWARD else 0.0)
    assert free == (reading.coverage >= MIN_COVERAGE and reading.nearest_m >= limit_m)
