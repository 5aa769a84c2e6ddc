"""Drives with a lidar that is turned on its mount: told, named, and never confidently wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from gazechair.base.poses import between, compose
from gazechair.sensing.odometry.doubts import TURNED
from gazechair.sensing.odometry.motion import Motion
from gazechair.sensing.odometry.odometry import Odometry
from gazesim import home_plans
from gazesim.home_drive import FRONT, REAR, Drive, Mounted

pytestmark = pytest.mark.costly

HOME, SECONDS = 4, 12.0


@dataclass
class Driven:
    """What odometry made of a drive."""

    outside: int = 0
    """Estimates farther off than three of their standard deviations and 5 cm, or 1 degree."""
    told_m: float = math.inf
    """Way from the turn to its report."""
    named: set[int | None] = field(default_factory=set)
    known_m: float = math.inf
    """Way until the mountings were known to be right."""
    way_m: float = 0.0


def drive(lidars: tuple[Mounted, ...], which: int, deg: float, at_s: float) -> Driven:
    """Drive through a home; the lidar `which` is turned by `deg` from `at_s` on."""
    home = home_plans.home(HOME)
    home.script = ()
    driven, odometry, done = Drive(home, HOME, lidars, per_turn=800), Odometry(), Driven()
    began: np.ndarray | None = None
    turned_m = math.inf
    for event in driven.events(SECONDS):
        if driven.time_s >= at_s and turned_m == math.inf:
            turned_m = driven.way_m
            mounted = replace(lidars[which], heading_deg=lidars[which].heading_deg + deg)
            driven.lidars = tuple(mounted if n == which else one for n, one in enumerate(lidars))
        if isinstance(event, Motion):
            odometry.motion(event)
            continue
        if turned_m < math.inf and event.lidar == which:  # nobody told the host
            event = replace(event, directions_deg=event.directions_deg - deg)
        said = odometry.piece(event)
        if said is None:
            continue
        truth = driven.truth(said.time_s)
        true = np.array((truth.x_m, truth.y_m, math.radians(truth.heading_deg)))
        if began is None:
            began = compose(true, between(said.pose(), np.zeros(3)))
        off = np.abs(between(true, compose(began, said.pose())))
        most_deg = 3.0 * said.heading_sigma_deg + 1.0
        done.outside += bool(
            off[0] > 3.0 * said.along_sigma_m + 0.05
            or off[1] > 3.0 * said.across_sigma_m + 0.05
            or math.degrees(off[2]) > most_deg
        )
        if TURNED in said.doubts:
            done.told_m = min(done.told_m, driven.way_m - turned_m)
            done.named.add(said.turned_lidar)
        elif said.mounting_sigma_deg < 2.0:
            done.known_m = min(done.known_m, driven.way_m)
    done.way_m = driven.way_m
    return done


@pytest.mark.parametrize(("deg", "told_m"), [(3.0, 0.9), (-8.0, 0.5), (15.0, 0.5)])
def test_one_that_was_turned_before_the_start_is_told_soon(deg: float, told_m: float) -> None:
    driven = drive((FRONT,), 0, deg, 0.0)
    assert driven.way_m > 1.2
    assert driven.outside == 0
    assert driven.told_m < told_m
    assert driven.named == {0}


@pytest.mark.parametrize(("lidars", "which"), [((FRONT,), 0), ((FRONT, REAR), 0)])
def test_one_that_is_bumped_on_the_way_is_told_and_the_place_is_less_sure(
    lidars: tuple[Mounted, ...], which: int
) -> None:
    driven = drive(lidars, which, -8.0, 6.0)
    assert driven.outside == 0
    assert driven.told_m < 1.2
    assert driven.named == {which}


@pytest.mark.parametrize("deg", [0.0, 1.0])
def test_one_that_sits_as_configured_or_a_degree_off_is_soon_known_to(deg: float) -> None:
    driven = drive((FRONT,), 0, deg, 0.0)
    assert driven.known_m < 1.0
    assert driven.named == set()
    assert driven.outside == 0
