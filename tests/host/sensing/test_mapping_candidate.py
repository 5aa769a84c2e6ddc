"""What is seen decides which poses may be the chair's, and when one of them is certain."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from gazechair.base.arrays import FloatArray
from gazechair.sensing.mapping.locating.candidate import Candidate, is_only
from gazechair.sensing.mapping.locating.map_match import Agreement
from gazechair.sensing.mapping.locating.recent_looks import CELL_M, RecentLooks, Settled

STANDING = np.zeros(3)
LENGTH_M = 10.0  # of what is seen


@dataclass(frozen=True)
class Known:
    """A map that agrees with a share of what is seen, and is contradicted by a length of it."""

    agreed: float
    contradicted_m: float = 0.0

    def agreement(self, settled: Settled, _: FloatArray) -> Agreement:
        nth = np.arange(len(settled.surfaces_m))
        # Spread evenly, so that far and near surfaces agree alike.
        agreed = np.floor(self.agreed * (nth + 1)) > np.floor(self.agreed * nth)
        return Agreement(agreed, self.contradicted_m)

    def new_straight_m(self, *_: object) -> float:
        return 0.0


def settled(around: float = 1.0, length_m: float = LENGTH_M, away_m: float = 3.0) -> Settled:
    """Surfaces of that length, `away_m` from the chair, in the share `around` of the bearings."""
    count = round(length_m / CELL_M)
    bearings = 2.0 * math.pi * around * (np.arange(count) + 0.5) / count
    surfaces = away_m * np.stack((np.cos(bearings), np.sin(bearings)), axis=1)
    return Settled(surfaces, np.zeros((1, 1), dtype=bool), np.zeros(2, dtype=np.int64))


def candidate(
    agreed: float = 0.98, contradicted_m: float = 0.0, seen: Settled | None = None
) -> Candidate:
    known = Known(agreed, contradicted_m)
    return Candidate(known, seen or settled(), STANDING, STANDING, None)


def is_certain(one: Candidate, image: Candidate | None = None) -> bool:
    return one.is_certain(lambda _: [] if image is None else [image])


def test_until_it_has_looked_all_around_more_of_what_is_far_agrees_or_nothing_is_against() -> None:
    """In a corridor of another home 97 % agreed at first, and 72 % all around."""
    for agreed, contradicted_m, around, certain in (
        (0.87, 0.3, 0.6, True),
        (0.83, 0.3, 0.6, False),
        (0.83, 0.3, 0.8, False),
        (0.83, 0.3, 0.9, True),
        (0.83, 0.2, 0.8, True),
    ):
        assert is_certain(candidate(agreed, contradicted_m, settled(around))) == certain


def test_until_then_it_leads_its_mirror_image_by_more() -> None:
    for around, image, certain in (
        (1.0, 0.80, False),
        (1.0, 0.71, True),
        (0.6, 0.71, False),
        (0.6, 0.61, True),
    ):
        assert is_certain(candidate(seen=settled(around)), candidate(image)) == certain


def test_the_less_agrees_or_is_seen_the_less_may_be_contradicted() -> None:
    for agreed, contradicted_m, around, certain in (
        (0.90, 1.7, 1.0, True),
        (0.90, 1.9, 1.0, False),
        (0.80, 0.9, 1.0, True),
        (0.80, 1.1, 1.0, False),
        (0.74, 0.3, 1.0, True),
        (0.74, 0.5, 1.0, False),
        (0.92, 1.1, 0.6, True),
        (0.92, 1.2, 0.6, False),
    ):
        seen = settled(around)
        assert is_certain(candidate(agreed, contradicted_m, seen)) == certain


def test_a_place_whose_mirror_image_fits_as_well_is_certain_only_with_much_all_around() -> None:
    for length_m, around, agreed, certain in (
        (10.0, 1.0, 0.98, False),
        (16.0, 1.0, 0.98, True),
        (16.0, 0.7, 0.98, False),
        (16.0, 1.0, 0.93, False),
    ):
        one = candidate(agreed, seen=settled(around, length_m))
        assert is_certain(one, image=one) == certain
        assert is_certain(one, image=candidate(0.2))


def test_a_bearing_is_seen_by_a_surface_or_by_free_floor() -> None:
    assert candidate(seen=settled(0.5)).seen_around == pytest.approx(0.5, abs=0.03)
    looks = RecentLooks()
    bearings = np.radians(np.arange(-90.0, 90.0, 1.0))
    ends = 5.0 * np.stack((np.cos(bearings), np.sin(bearings)), axis=1)
    for number in range(2):  # no surface is seen twice
        looks.add(np.zeros_like(ends), ends * (1.0 + 0.1 * number), STANDING[:2])
    wall = np.tile(np.array([(-2.0, 0.0)]), (10, 1))
    for _ in range(2):
        looks.add(np.zeros_like(wall), wall, STANDING[:2])
    seen = looks.settled()
    assert seen is not None
    assert len(seen.surfaces_m) < 5
    assert candidate(seen=seen).seen_around == pytest.approx(0.53, abs=0.06)


def only(others: list[Candidate], agreed: float = 0.98) -> bool:
    return is_only([candidate(agreed), *others])


def test_one_piece_of_furniture_that_is_gone_elsewhere_is_no_reason_to_be_here() -> None:
    """The room's twin, in which a table stood that is gone, agrees as well as this one."""
    assert not only([candidate(0.98, contradicted_m=3.0)])
    assert only([candidate(0.98, contradicted_m=3.5)])  # more than a piece of furniture
    assert not only([candidate(0.90, contradicted_m=1.8)])
    assert only([candidate(0.83, contradicted_m=1.8)])  # half of the lead is what agrees


def test_a_place_that_is_ruled_out_by_itself_needs_half_the_lead() -> None:
    """People who stand around hide most: what is left is short, but at one place all of it fits."""
    assert only([candidate(0.69)], agreed=0.85)  # of what is far, 70 % have to agree
    assert not only([candidate(0.71)], agreed=0.85)
    assert not only([candidate(0.69)], agreed=0.80)
