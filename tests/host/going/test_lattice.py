"""The lattice after what is seen has changed: as computed anew, though only what differs is."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from gazechair.base.arrays import FloatArray
from gazechair.going.costmap import Costmap
from gazechair.going.lattice import LOOSE_M, Lattice
from goingrig import TWO_ROOMS, floor

HERE_M = (2.0, 2.0)
BOX_M = np.array([(x, y) for x in (5.0, 5.1, 5.2) for y in (1.0, 1.1)])
POST_M = np.array([(2.5, 3.0), (6.6, 2.9)])


def see(costmap: Costmap, points_m: FloatArray, at_s: float) -> None:
    """What is seen now; what was seen longer ago than it is kept is gone."""
    costmap.see(points_m, at_s, HERE_M)
    costmap.suspect(points_m)
    costmap.refresh(at_s)


def prepared(lattice: Lattice) -> list[np.ndarray]:
    """Everything that the search reads."""
    lattice.use(LOOSE_M, 0.085, ())
    return [
        lattice._free, lattice._stands, lattice._dearer,
        lattice._left, lattice._right, lattice._tight,
    ]  # fmt: skip


def same(one: list[np.ndarray], other: list[np.ndarray]) -> bool:
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


def is_as_anew(lattice: Lattice, costmap: Costmap) -> bool:
    anew = Lattice(costmap)
    anew.refresh()
    return same(prepared(lattice), prepared(anew))


@pytest.fixture
def costmap() -> Costmap:
    return floor(TWO_ROOMS)


def test_things_that_come_and_go(costmap: Costmap) -> None:
    lattice = Lattice(costmap)
    empty = prepared(lattice)
    for at_s, points_m in ((0.0, BOX_M), (1.0, POST_M), (6.5, POST_M[:1]), (9.0, BOX_M[:2])):
        see(costmap, points_m, at_s)
        lattice.refresh()
        assert not same(prepared(lattice), empty)
        assert is_as_anew(lattice, costmap)
    see(costmap, np.zeros((0, 2)), 30.0)
    lattice.refresh()
    assert same(prepared(lattice), empty)


def test_a_costmap_that_changes_meanwhile(
    costmap: Costmap, monkeypatch: pytest.MonkeyPatch
) -> None:
    lattice = Lattice(costmap)
    see(costmap, BOX_M, 0.0)
    clearance_m, left = costmap.clearance_m, [3]

    def seen_meanwhile(*at: FloatArray) -> FloatArray:
        left[0] -= 1
        if not left[0]:
            see(costmap, POST_M, 7.0)  # the box is gone
        return clearance_m(*at)

    monkeypatch.setattr(costmap, "clearance_m", seen_meanwhile)
    lattice.refresh()
    see(costmap, BOX_M, 14.0)
    lattice.refresh()
    assert is_as_anew(lattice, costmap)


def test_refresh_and_use_prepare_once(costmap: Costmap, monkeypatch: pytest.MonkeyPatch) -> None:
    lattice = Lattice(costmap)
    prepare, times = lattice._prepare, [0]

    def counted() -> None:
        times[0] += 1
        prepare()

    monkeypatch.setattr(lattice, "_prepare", counted)
    see(costmap, BOX_M, 0.0)
    lattice.refresh()
    lattice.use(LOOSE_M, 0.04, ())
    lattice.use(LOOSE_M, 0.04, ())
    assert times == [1]


def test_random_changes_one_after_the_other(costmap: Costmap) -> None:
    chance, lattice, now_s = np.random.default_rng(1), Lattice(costmap), 0.0
    for _ in range(12):
        now_s += chance.choice((0.3, 1.0, 3.0, 7.0))
        at = chance.uniform((0.5, 0.5), (7.5, 3.5))
        points_m = at + chance.normal(
            0.0, chance.choice((0.03, 0.5)), (int(chance.choice((3, 60))), 2)
        )
        if chance.random() < 0.3:
            costmap.forget(*at, 1.0)
        else:
            costmap.see(points_m, now_s, (at[0], at[1]))
        if chance.random() < 0.5:
            costmap.suspect(points_m)
        costmap.refresh(now_s)
        lattice.refresh()
        assert is_as_anew(lattice, costmap)


def test_a_refresh_that_raises_leaves_it_as_it_was(
    costmap: Costmap, monkeypatch: pytest.MonkeyPatch
) -> None:
    lattice = Lattice(costmap)
    see(costmap, BOX_M, 0.0)
    with monkeypatch.context() as patched:
        patched.setattr(lattice, "_ahead_of", too_much)
        with pytest.raises(MemoryError):
            lattice.refresh()
    costmap.refresh(30.0)  # the box is gone
    lattice.refresh()
    assert is_as_anew(lattice, costmap)


def too_much(_: object) -> None:
    raise MemoryError


def test_many_possible_persons_need_little_memory() -> None:
    posts = [(x, y, x + 0.1, y + 0.1) for x in np.arange(1, 14, 0.4) for y in np.arange(1, 14, 0.4)]
    costmap = floor(posts, (15.0, 15.0))
    lattice = Lattice(costmap)
    costmap.suspect(costmap.standing_m[::20] + 0.2)
    tracemalloc.start()
    lattice.refresh()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 15e6
