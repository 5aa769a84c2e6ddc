"""Narrow places: their middle to millimetres, and what does not count as one."""

import math

import numpy as np
import pytest

from gazechair.assist.narrow import narrow
from gazechair.assist.ways import Ways
from gazechair.base.footprint import Footprint, Margins

FRONT_M, NEEDS_M = 0.7, (0.385, 0.385)


def door(width_m, ahead_m=0.5, aside_m=0.0, turned_deg=0.0):
    """Points of a door's frame as the chair sees it, turned about the axle."""
    chance = np.random.default_rng(3)
    deep = np.linspace(0.0, 0.15, 40) + FRONT_M + ahead_m
    left = np.stack((deep, np.full(40, aside_m + width_m / 2)), axis=1)
    right = np.stack((deep, np.full(40, aside_m - width_m / 2)), axis=1)
    points = np.concatenate((left, right)) + chance.normal(0.0, 0.002, (80, 2))
    c, s = math.cos(math.radians(turned_deg)), math.sin(math.radians(turned_deg))
    return points @ np.array(((c, s), (-s, c)))


@pytest.mark.parametrize("aside_m", [-0.02, 0.0, 0.01])
def test_its_middle_to_a_few_millimetres(aside_m):
    found = narrow(door(0.81, aside_m=aside_m), FRONT_M, NEEDS_M)
    assert found.ahead_m == pytest.approx(0.5, abs=0.16)
    assert (FRONT_M + 0.55) * math.tan(found.aim_rad) == pytest.approx(aside_m, abs=0.004)


def test_off_the_side_that_needs_more():
    found = narrow(door(0.81), FRONT_M, (0.398, 0.385))
    assert (FRONT_M + 0.55) * math.tan(found.aim_rad) == pytest.approx(-0.0065, abs=0.004)


def test_turned_it_is_found_within_four_degrees():
    assert math.degrees(narrow(door(0.81, turned_deg=2.0), FRONT_M, NEEDS_M).aim_rad) == (
        pytest.approx(2.0, abs=0.3)
    )
    assert narrow(door(0.81, turned_deg=7.0), FRONT_M, NEEDS_M) is None


def test_what_is_no_narrow_place():
    assert narrow(door(0.86), FRONT_M, NEEDS_M) is None
    assert narrow(door(0.74), FRONT_M, NEEDS_M) is None
    assert narrow(door(0.81, ahead_m=1.0), FRONT_M, NEEDS_M) is None
    post = np.array(((FRONT_M + 0.7, 0.1), (FRONT_M + 0.7, 0.12), (FRONT_M + 0.7, 0.14)))
    assert narrow(np.concatenate((door(0.81, 0.3), post - (0.1, 0.0))), FRONT_M, NEEDS_M) is None
    assert narrow(door(0.81)[:40], FRONT_M, NEEDS_M) is None
    assert narrow(np.zeros((0, 2)), FRONT_M, NEEDS_M) is None


@pytest.mark.parametrize("aside_m", [0.26, 0.35, 0.45])
def test_without_side_margin_a_way_through_a_narrow_door_aside_is_found_from_afar(aside_m):
    half_m = 0.405
    beside = np.concatenate(
        (np.arange(aside_m + half_m, 3, 0.005), np.arange(-3, aside_m - half_m, 0.005))
    )
    wall = np.stack((np.full(len(beside), 2.4), beside), axis=1)
    c, s = math.cos(math.radians(9.0)), math.sin(math.radians(9.0))
    points = np.concatenate((wall, wall + np.array((0.12, 0.0)))) @ np.array(((c, s), (-s, c)))
    way = Ways(Footprint(margins=Margins(0.05, 0.0, 0.05))).choose(
        points, 0.0, None, (256.0, 256.0), False
    )
    assert way.first_m > 1.0
    assert math.degrees(way.then_rad) == pytest.approx(11.0, abs=3.0)
