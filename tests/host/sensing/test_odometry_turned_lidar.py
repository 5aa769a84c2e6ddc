"""Drives with a lidar that is turned on its mount: told, named, and never confidently wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from gazechair.base.poses import between, compose
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.odometry.doubts import TURNED
from gazechair.sensing.odometry.odometry import Odometry
from gazesim import home_plans
from gazesim.home_drive import FRONT, REAR, Drive, Mounted
from gazesim.homes import Home

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


def half_of(passage: Home, step: int, x_m: float, turned_deg: float) -> Piece:
    """The half turn that ends at `step`, 0.05 s each, of a lidar 0.5 m before the axle."""
    own = -(np.arange(400) + 0.5) * 0.45 - step % 2 * 180.0
    angles = np.radians(own + turned_deg) % (2.0 * math.pi)
    order, metres = np.argsort(angles), np.empty(400)
    at = np.full(400, x_m + 0.5)
    metres[order] = passage.cast_moving(at, np.zeros(400), angles[order], 0.25)
    noisy = metres + np.random.default_rng(step).normal(0.0, 0.006, 400)
    times = 0.05 * (step - 1 + (np.arange(400) + 0.5) / 400)
    distances = np.where(metres < 18.0, noisy, 0.0)
    return Piece((own + 180.0) % 360.0 - 180.0, distances, times, (0.5, 0.0), 800)


def test_in_a_passage_where_a_bumped_lidar_may_seem_to_stand_its_whole_way_is_unsure() -> None:
    walls = ((-10.0, -0.9, 60.0, -0.9), (-10.0, 0.9, 60.0, 0.9), (-10.0, -0.9, -10.0, 0.9))
    passage = Home("passage", walls)
    odometry, x_m, told_m = Odometry(), 0.0, math.inf
    for step in range(1, 160):
        moves = step >= 20
        x_m += 0.02 if moves else 0.0
        odometry.motion(Motion(0.05 * step, 0.0, 800 if moves else 0, 0))
        said = odometry.piece(half_of(passage, step, x_m, 8.0 if step >= 70 else 0.0))
        assert said is not None
        if TURNED in said.doubts:
            told_m = min(told_m, x_m)
    assert told_m < 1.3
    assert 3.0 * min(said.along_sigma_m, said.across_sigma_m) > x_m - told_m


@pytest.mark.parametrize("deg", [0.0, 1.0])
def test_one_that_sits_as_configured_or_a_degree_off_is_soon_known_to(deg: float) -> None:
    driven = drive((FRONT,), 0, deg, 0.0)
    assert driven.known_m < 1.0
    assert driven.named == set()
    assert driven.outside == 0
