"""A drive through a home becomes a map: closed loops remove drift, wrong loops do not count."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest

from gazechair.base.poses import between, compose
from gazechair.sensing.mapping.building import pose_graph
from gazechair.sensing.mapping.building.loops import agreeing
from gazechair.sensing.mapping.building.mapper import Mapper
from gazechair.sensing.mapping.building.pose_graph import Edge, MissingPackageError, optimized
from homerig import flat, points, poses, scan

# What it is made of takes longer than the tests: one process makes it.
pytestmark = pytest.mark.xdist_group("mapping_mapper")

SCALE, DRIFT_RAD_S = 1.005, math.radians(0.3 / 60.0)
STEP_S = 0.5


def drive(scale: float = 1.01) -> tuple[Mapper, np.ndarray]:
    """A map made with an odometry whose lengths are wrong by `scale`; and the true key poses."""
    chance = np.random.default_rng(1)
    room, mapper, true = flat(), Mapper(), []
    path = list(poses())
    odometry = np.zeros(3)
    for number, pose in enumerate(path):
        moved = between(path[number - 1], pose) if number else np.zeros(3)
        moved[:2] = moved[:2] * scale + chance.normal(0.0, 0.01, 2)
        heading = SCALE * pose[2] + DRIFT_RAD_S * STEP_S * number
        heading += chance.normal(0.0, math.radians(0.1))
        odometry = compose(odometry, moved)
        odometry[2] = heading
        seen = points(*scan(room, pose, chance))
        if mapper.add(odometry, seen, heading, number * STEP_S):
            true.append(pose)
    return mapper, np.array(true)


@pytest.fixture(scope="module")
def driven() -> tuple[Mapper, np.ndarray]:
    return drive()


def off_m(mapper: Mapper, true: np.ndarray) -> np.ndarray:
    """Each key pose's distance from the truth, both seen from the first key scan."""
    first = mapper.keys[0].pose
    found = [between(first, key.pose) for key in mapper.keys]
    return np.array(
        [math.dist(a[:2], between(true[0], b)[:2]) for a, b in zip(found, true, strict=True)]
    )


def test_loops_take_the_drift_of_the_odometry_away(driven: tuple[Mapper, np.ndarray]) -> None:
    mapper, true = driven
    mapper.finish()
    assert mapper.loops >= 20
    assert np.sqrt((off_m(mapper, true) ** 2).mean()) < 0.06
    assert off_m(mapper, true).max() < 0.15


def test_every_loop_that_counts_is_right(driven: tuple[Mapper, np.ndarray]) -> None:
    mapper, true = driven
    for edge in mapper.edges:
        if edge.loop:
            off = between(edge.seen, between(true[edge.first], true[edge.second]))
            assert math.hypot(off[0], off[1]) < 0.1
            assert abs(off[2]) < math.radians(2.5)


def test_key_scans_are_taken_after_30_cm_or_20_degrees(driven: tuple[Mapper, np.ndarray]) -> None:
    mapper, _ = driven
    for before, key in zip(mapper.keys, mapper.keys[1:], strict=False):
        turned = abs(key.heading_rad - before.heading_rad)
        assert key.driven_m - before.driven_m >= 0.3 or turned >= math.radians(20.0)


def test_a_loop_counts_only_when_another_one_agrees() -> None:
    line = [np.array((0.3 * number, 0.0, 0.0)) for number in range(60)]
    good = [Edge(n, 50 + n, np.array((0.2, 0.0, 0.0)), np.eye(3), True) for n in (0, 3)]
    wrong = Edge(1, 52, np.array((1.2, 0.5, 0.3)), np.eye(3), True)
    assert agreeing([good[0], wrong], line) == []
    assert agreeing([good[0], wrong, good[1]], line) == good


def test_one_wrong_loop_does_not_bend_the_map() -> None:
    line = [np.array((float(number), 0.0, 0.0)) for number in range(21)]
    steps = [Edge(n, n + 1, np.array((1.0, 0.0, 0.0)), np.eye(3) * 1e3) for n in range(20)]
    wrong = Edge(0, 20, np.array((15.0, 0.0, 0.0)), np.eye(3) * 1e3, loop=True)
    found = optimized(line, [*steps, wrong])
    assert found[20][0] == pytest.approx(20.0, abs=1.5)


def test_without_the_extra_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "g2opy", None)
    with pytest.raises(MissingPackageError, match=r"pip install gazechair\[home\]"):
        pose_graph.optimized([np.zeros(3)], [])
