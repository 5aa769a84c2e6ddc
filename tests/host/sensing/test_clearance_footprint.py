"""Outlines that are accepted, outlines that are refused, and how they grow."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazechair.base.footprint import (
    DEFAULT_CORNERS,
    Footprint,
    Margins,
    distance_m,
    inside,
    why_not,
)
from gazesim import chair

SQUARE = [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)]


def test_the_default_is_the_simulated_chair() -> None:
    xs, ys = zip(*DEFAULT_CORNERS, strict=True)
    assert (max(xs), min(xs)) == (chair.FRONT_M, chair.REAR_M)
    assert (max(ys), min(ys)) == (chair.HALF_WIDTH_M, -chair.HALF_WIDTH_M)


@pytest.mark.parametrize(
    ("corners", "reason"),
    [
        ([], "corners"),
        ([(0.5, 0.5), (-0.5, 0.5)], "corners"),
        ([(0.5, 0.5)] * 30, "corners"),
        ([(0.5, 0.5), (-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5)], "cross"),
        ([(0.5, 0.5), (0.5, 0.5), (-0.5, 0.5), (0, -0.5)], "touch"),
        ([(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (-0.5, 0.4), (0.5, -0.5)], "touch"),
        ([(0.1, 0.0), (-0.1, 0.1), (-0.1, -0.1)], "cover"),
        ([(x + 1.0, y) for x, y in SQUARE], "drive axle"),
        ([(9.0, 0.5), (-0.5, 0.5), (-0.5, -0.5)], "within 3 m"),
        ([(float("nan"), 0.5), (-0.5, 0.5), (-0.5, -0.5)], "within 3 m"),
    ],
)
def test_nonsense_is_refused(corners: list[tuple[float, float]], reason: str) -> None:
    assert reason in why_not(corners)
    with pytest.raises(ValueError, match="the outline must"):
        Footprint(corners)


def test_either_sense_of_rotation_is_the_same_outline() -> None:
    points = np.random.default_rng(1).uniform(-1, 1, (500, 2))
    one, other = Footprint(SQUARE), Footprint(SQUARE[::-1])
    assert (one.contains(points) == other.contains(points)).all()


@given(
    st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)),
    st.floats(0.0, 0.3),
    st.floats(0.0, 0.3),
    st.floats(0.0, 0.3),
)
def test_a_box_grows_by_its_margins(
    place: tuple[float, float], front: float, side: float, rear: float
) -> None:
    x, y = place
    grown = Footprint(SQUARE, Margins(front, side, rear))
    ways = (0.5 + front - x, x + 0.5 + rear, 0.5 + side - abs(y))
    if min(abs(way) for way in ways) > 1e-6:
        assert grown.contains(np.array([place]))[0] == (min(ways) > 0)


@given(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)))
def test_an_angled_outline_grows_on_all_sides(place: tuple[float, float]) -> None:
    corners = [(0.6, 0.2), (0.2, 0.2), (0.2, 0.5), (-0.4, 0.3), (-0.4, -0.4), (0.6, -0.4)]
    margin = 0.1
    shape = Footprint(corners, Margins(margin, margin, margin))
    point = np.array([place])
    gap = 0.0 if inside(shape.body, point)[0] else float(distance_m(shape.body, point)[0])
    if gap < margin - 1e-6:
        assert shape.contains(point)[0]
    if gap > margin * 2**0.5 + 1e-6:
        assert not shape.contains(point)[0]
