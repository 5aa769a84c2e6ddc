"""Following a person end to end in virtual time: the whole firmware, a lidar, somebody's legs."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from e2e.going_chair import PATH_MS, GoingChair
from gazeboard.core import limits
from gazechair.producers.places import Target
from gazechair.producers.tiles import people
from gazechair.sensing.mapping.stored.places import Drawn
from gazesim.gaits import PLAIN, Actor
from gazesim.rooms import Person

pytestmark = pytest.mark.costly

FRONT_M = 0.65
STEP_MS = 50
TURN_MS = 300  # until a whole turn of the lidar has been made, read and judged


class _Leg(Person):
    """A disc of somebody."""

    def __init__(self, owner: Actor, number: int) -> None:
        super().__init__(((0.0, 0.0),))
        self._owner, self._number = owner, number
        self.step()

    def step(self) -> None:
        """To where it is now."""
        self.x_m, self.y_m, self.radius_m = self._owner.legs()[self._number]


class Following(GoingChair):
    """Somebody walks before the chair, along its way: `far_m` from where its axle began."""

    kind = "person"

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, Drawn())
        self.far_m, self.walks_m_s = 2.9, 0.0
        self._who = Actor(self.far_m, 0.0, PLAIN, random.Random(1))
        self._legs = [_Leg(self._who, number) for number in (0, 1)]
        self.world.room.people = tuple(self._legs)
        self.watchers.append(self._walk)
        self.until(lambda: bool(self.tiles), 600)

    def _targets(self) -> Callable[[], Mapping[str, Target]]:
        return lambda: people(self.allowed)

    def _walk(self) -> None:
        if self.now_ms % STEP_MS == 0:
            self.far_m += self.walks_m_s * STEP_MS / 1000.0
            if self.walks_m_s:
                self._who.go(self.far_m, 0.0)
            else:
                self._who.stand()
            for leg in self._legs:
                leg.step()

    def leaves(self) -> None:
        """Out of the lidar's sight, at once."""
        self.world.room.people = ()

    def press(self) -> None:
        """Dwell on its tile, once."""
        self.page.choose(self.tiles["Volg persoon"])
        self.until(lambda: self.service.rides, PATH_MS)

    def follows(self) -> None:
        """Somebody comes, is followed, and walks on."""
        self.walks_m_s = -0.5
        self.until(lambda: self.far_m < FRONT_M + 1.2, 5000)
        self.walks_m_s = 0.0
        self.press()
        self.until(lambda: self.news["state"] == "drives", 4000)
        self.walks_m_s = 0.3
        self.until(lambda: self.world.chair.speed_m_s > 0.1, 4000)

    @property
    def news(self) -> dict[str, object]:
        """What pages are told of it."""
        return self.service.news() or {"state": "", "reason": ""}

    @property
    def gap_m(self) -> float:
        """From the chair's front to the person, by the truth."""
        chair = self.world.chair
        return math.dist((chair.x_m, chair.y_m), (self.far_m, 0.0)) - FRONT_M


@pytest.fixture
def chair(tmp_path: Path) -> Following:
    return Following(tmp_path)


def test_follows_at_a_distance_and_out_of_sight_is_told_and_neutral(chair: Following) -> None:
    chair.follows()
    chair.walks_m_s = 0.15
    chair.run(3000)
    assert not chair.neutral(), chair.why()
    assert 0.9 < chair.gap_m < 1.8
    chair.leaves()
    chair.until(chair.neutral, TURN_MS)
    chair.until(lambda: chair.news["state"] == "ended", 1500)
    assert chair.news["reason"] == "person_lost"
    chair.world.room.people = tuple(chair._legs)  # whoever stands there then was not chosen
    chair.comes_to_rest()
    chair.stays_still(1000)


def test_the_lidar_is_lost(chair: Following) -> None:
    assert chair.host is not None
    chair.follows()
    chair.host.lidar_child = False
    chair.until(chair.neutral, TURN_MS)
    chair.stays_still(1200)
    assert chair.news["state"] == "ended"


def test_p20_its_pose_is_lost(chair: Following) -> None:
    chair.follows()
    chair.loses_its_pose()
    assert chair.news["reason"] == "person_no_sight"


def test_p17_its_process_is_killed(chair: Following) -> None:
    chair.follows()
    chair.until(lambda: chair.now_ms % STEP_MS == 1, STEP_MS)
    chair.child_fails()
    chair.until(chair.neutral, limits.AUTO_TTL_MS + PATH_MS)
    chair.stays_still(1000)
    assert (chair.news["state"], chair.news["reason"]) == ("ended", "going_failed")
