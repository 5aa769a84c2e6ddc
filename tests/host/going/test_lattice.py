"""The lattice after what is seen has changed: as computed anew, though only what differs is."""

from __future__ import annotations

import numpy as np
import pytest

from gazechair.base.footprint import FloatArray
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
