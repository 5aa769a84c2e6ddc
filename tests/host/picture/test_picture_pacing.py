"""Pacing over links of known delay and rate: as large as fits, never larger for long."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazechair.picture.pacing import BUDGET_S, Pacing

SIZES = (2500, 4000, 7000, 14000, 25000, 45000)  # bytes in each level
PERIOD_S = 0.1


class Link:
    """A link with a delay there and back, and a rate; pictures go one at a time."""

    def __init__(self, delay_s: float, rate_b_s: float) -> None:
        self.delay_s = delay_s
        self.rate_b_s = rate_b_s
        self.pacing = Pacing(len(SIZES) - 1)
        self.now_s = 0.0
        self.journeys: list[float] = []
        self.levels: list[int] = []

    def run(self, seconds: float, noise: float = 0.0) -> None:
        until_s = self.now_s + seconds
        count = 0
        while self.now_s < until_s:
            level = self.pacing.level
            count += 1
            wobble = noise * ((count * 7) % 5) / 5
            journey_s = self.delay_s + SIZES[level] / self.rate_b_s + wobble
            self.now_s += max(journey_s, PERIOD_S)
            self.pacing.acknowledged(journey_s, self.now_s)
            self.journeys.append(journey_s)
            self.levels.append(level)


@pytest.mark.parametrize(
    ("delay_s", "mbit_s", "level"),
    [(0.001, 100, 5), (0.01, 2, 3), (0.2, 0.3, 1), (0.2, 2, 3), (0.05, 8, 5), (0.3, 0.05, 0)],
)
def test_it_finds_what_the_link_carries_and_stays_there(
    delay_s: float, mbit_s: float, level: int
) -> None:
    link = Link(delay_s, mbit_s * 125_000)
    link.run(10)
    assert link.pacing.level == level
    link.levels.clear()
    link.run(300)
    there = sum(1 for each in link.levels if each == level)
    assert there >= 0.93 * len(link.levels)
    assert max(link.levels) <= level + 1


def test_the_first_picture_is_the_smallest() -> None:
    assert Pacing(5).level == 0


def test_a_link_that_gets_slower_gets_smaller_pictures_within_seconds() -> None:
    link = Link(0.01, 1_000_000)
    link.run(10)
    assert link.pacing.level == 5
    link.rate_b_s = 37_500
    link.run(4)
    assert link.pacing.level <= 1


def test_a_link_that_gets_better_gets_larger_pictures_within_a_minute_or_so() -> None:
    link = Link(0.2, 37_500)
    link.run(60)
    link.delay_s, link.rate_b_s = 0.01, 1_000_000
    link.run(70)
    assert link.pacing.level == 5


def test_a_longer_delay_alone_costs_no_size_for_long() -> None:
    link = Link(0.01, 1_000_000)
    link.run(10)
    link.delay_s = 0.15
    link.run(15)
    assert link.pacing.level == 5


@given(st.floats(0.0005, 0.5), st.floats(20_000, 5_000_000), st.floats(0, 0.02))
def test_pictures_seldom_take_longer_than_the_budget(
    delay_s: float, rate_b_s: float, noise: float
) -> None:
    link = Link(delay_s, rate_b_s)
    link.run(120, noise)
    least_s = delay_s + SIZES[0] / rate_b_s
    over = [j for j in link.journeys if j > least_s + 2 * noise + 1.01 * BUDGET_S]
    assert len(over) <= max(20, 0.1 * len(link.journeys))


def test_the_way_to_the_page_is_most_of_the_last_journey() -> None:
    assert Pacing(5).way_s == 0.0
    link = Link(0.2, 37_500)
    link.run(10)
    true_s = 0.1 + SIZES[link.pacing.level] / 37_500
    assert 0.5 * true_s <= link.pacing.way_s <= 1.2 * true_s
