"""In a noisy hand-drawn map the chair knows its pose, and the pose's accuracy."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.base.poses import between, compose
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.locating.localization import Localization
from gazechair.sensing.mapping.stored import ros_map
from gazemeasure.go import foreign_maps
from gazemeasure.home.localization import look
from gazesim import ros_map as ros_home
from gazesim.homes import Home

# What it is made of takes longer than the tests: one process makes it.
pytestmark = pytest.mark.xdist_group("mapping_drawn_maps")

STEP_M, TURN_RAD = 0.10, math.radians(8.0)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> tuple[Home, OccupancyGrid]:
    """The plan itself, and the map of it."""
    clean, frayed = (tmp_path_factory.mktemp(name) for name in ("clean", "frayed"))
    home = ros_home.load(foreign_maps.drawn_by_hand(clean, noisy=False))
    path = foreign_maps.drawn_by_hand(frayed, noisy=True)
    return home, ros_map.read(path, "plan").grid


@pytest.mark.parametrize(
    "start", [(5.9, 2.5, -2.5), (7.1, 3.6, 0.8), (1.6, 4.6, 0.3), (9.4, 4.4, 2.0), (2.2, 2.2, -0.7)]
)
def test_it_is_never_more_off_than_it_says(
    drawn: tuple[Home, OccupancyGrid], start: tuple[float, float, float]
) -> None:
    (home, grid), chance, pose = drawn, np.random.default_rng(3), np.array(start)
    localization, odometry, known = Localization(grid), np.zeros(3), 0
    localization.place(pose, odometry)
    for step in range(30):
        ahead = compose(pose, np.array((STEP_M, 0.0, 0.0)))
        free = home.clearance_m(ahead[0], ahead[1], math.degrees(ahead[2])) > 0.05
        moved = np.array((STEP_M, 0.0, 0.0) if free and step % 10 < 6 else (0.0, 0.0, TURN_RAD))
        pose, odometry = compose(pose, moved), compose(odometry, moved)
        found = localization.look(look(home, pose, chance), odometry, 0.2 * step)
        if found is None:
            continue
        known += 1
        off = between(pose, found.pose)
        assert math.hypot(off[0], off[1]) < min(0.1, 2.5 * found.sigma_m)
        assert abs(off[2]) < math.radians(3.0)
    assert known >= 24
