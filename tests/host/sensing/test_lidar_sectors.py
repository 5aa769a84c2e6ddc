"""The classic sectors: an obstacle blocks its direction, what is not seen is never free."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.config.configuration import SectorsConfig
from gazechair.sensing.lidar.sectors import (
    ALL_BLOCKED,
    HYSTERESIS_M,
    MIN_COVERAGE,
    Reading,
    Sector,
    blocked_bits,
    measure,
)
from gazechair.sensing.lidar.service import classic
from gazelink import codes

FORWARD, BACKWARD, LEFT, RIGHT = (1 << d for d in range(4))
ROUND = np.arange(-180.0, 180.0, 0.25)
SECTORS = classic(SectorsConfig())


def bits(distances_m: np.ndarray, before: int = 0, sectors: tuple[Sector, ...] = SECTORS) -> int:
    readings = tuple(measure(ROUND, distances_m, sector) for sector in sectors)
    return blocked_bits(sectors, readings, 0.5, before)


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


def test_a_rear_sector_lets_the_chair_go_back() -> None:
    sectors = classic(SectorsConfig(rear_deg=(150.0, -150.0)))
    assert bits(room(), sectors=sectors) == 0
    assert bits(room(deg_170=0.3), sectors=sectors) == BACKWARD
    assert bits(room(deg_m170=0.3), sectors=sectors) == BACKWARD


def test_a_blocked_direction_is_free_again_five_centimetres_later() -> None:
    assert HYSTERESIS_M == 0.05
    assert bits(room(deg_0=0.54), before=FORWARD) & FORWARD
    assert not bits(room(deg_0=0.54), before=0) & FORWARD
    assert not bits(room(deg_0=0.56), before=FORWARD) & FORWARD


def test_no_points_block_everything() -> None:
    empty = np.zeros(0)
    readings = tuple(measure(empty, empty, sector) for sector in SECTORS)
    assert blocked_bits(SECTORS, readings, 0.5) == ALL_BLOCKED


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
@given(points, st.floats(-180, 180), st.floats(1, 180), st.floats(0.2, 5.0))
def test_free_means_seen_and_nothing_near(
    beams: list[tuple[float, float]], from_deg: float, width_deg: float, limit_m: float
) -> None:
    sector = Sector(codes.DIR_FORWARD, from_deg, from_deg + width_deg)
    angles = np.array([a for a, _ in beams])
    distances = np.array([d for _, d in beams])
    reading = measure(angles, distances, sector)
    assert 0.0 <= reading.coverage <= 1.0
    inside = [d for a, d in beams if (a - from_deg) % 360 <= width_deg and d > 0]
    assert reading.nearest_m == (min(inside) if inside else float("inf"))
    free = not blocked_bits((sector,), (reading,), limit_m, 0) & FORWARD
    assert free == (reading.coverage >= MIN_COVERAGE and reading.nearest_m >= limit_m)


@settings(deadline=None)
@given(st.floats(0.05, 16), st.floats(0, 1), st.integers(0, 15))
def test_a_nearer_obstacle_or_a_poorer_view_never_frees_anything(
    nearest_m: float, coverage: float, before: int
) -> None:
    def at(distance_m: float, share: float) -> int:
        readings = (Reading(distance_m, share),) * len(SECTORS)
        return blocked_bits(SECTORS, readings, 0.5, before)

    here = at(nearest_m, coverage)
    assert here & ~at(nearest_m / 2, coverage) == 0
    assert here & ~at(nearest_m, coverage / 2) == 0
