"""Random rooms and their tasks: the same for the same seed, and true to their kind."""

from __future__ import annotations

import pytest

from gazelink import codes
from gazesim import chair
from gazesim.random_rooms import KINDS, Walker, door_task, task, wall_task


@pytest.mark.parametrize("kind", KINDS)
def test_a_seed_is_a_task(kind: str) -> None:
    one, again, other = task(kind, 7), task(kind, 7), task(kind, 8)
    assert (one.room.walls, one.room.furniture) == (again.room.walls, again.room.furniture)
    assert (one.room.start, one.verb, one.goal) == (again.room.start, again.verb, again.goal)
    assert one.walker == again.walker
    assert (one.goal, one.walker) != (other.goal, other.walker)
    for seed in range(20):
        found = task(kind, seed)
        assert not found.room.collides(*found.room.start)
        assert (found.walker is not None) == (kind == "people")


def test_a_door_is_crossed_where_it_says() -> None:
    found = door_task(0.90, 0.1, 0.01, 3.0, 1.0)
    x_m, y_m, heading_deg = found.room.start
    assert x_m + chair.FRONT_M < -1.0
    # Clearance in the passage: 7.5 cm less 1 cm and the effect of 3 degrees.
    crossing = found.room.clearance_m(0.0 - chair.FRONT_M / 2, 0.01 - 0.017, heading_deg)
    assert 0.04 < crossing < 0.075
    assert y_m < 0.0


def test_a_wall_is_beside_the_chair() -> None:
    found = wall_task(0.15)
    assert found.room.clearance_m(*found.room.start) == pytest.approx(0.15)
    assert found.verb == codes.FORWARD


def test_a_walker_waits_and_walks() -> None:
    walker = Walker(1.0, 2.0, 180.0, from_s=3.0)
    assert walker.at(2.0) == (1.0, 2.0)
    assert walker.at(4.0) == pytest.approx((0.0, 2.0))


def test_an_unknown_kind_is_refused() -> None:
    with pytest.raises(ValueError, match="there are door"):
        task("castle", 1)
