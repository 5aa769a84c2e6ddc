"""The caretaker's page end to end: takes over, drives by stick, caps, gives back. Virtual time."""

from __future__ import annotations

from typing import Any

import pytest

from gazesim.chair_rig import NEUTRAL
from gazesim.lockstep_chair import Lockstep

pytestmark = pytest.mark.costly


class Caretaker:
    """A second page at the same chair, with a stick."""

    def __init__(self, chair: Lockstep) -> None:
        self.chair = chair
        self.page = chair.another_page("caretaker")
        chair.run(60)  # it has heard the host

    def pull(self, linear: int, turn: int = 0) -> None:
        """Hold the stick there, from now on."""
        self.page.pull(linear, turn)


@pytest.fixture
def caretaker(chair: Lockstep) -> Caretaker:
    chair.arm()
    return Caretaker(chair)


def deflection(chair: Lockstep) -> tuple[int, int]:
    linear, turn = chair.wipers()
    return linear - NEUTRAL[0], turn - NEUTRAL[1]


def take(caretaker: Any) -> None:
    caretaker.page.take()
    caretaker.chair.run(300)
    assert caretaker.page.shown["you"]


def test_the_stick_moves_the_wipers_in_proportion(caretaker: Any) -> None:
    chair = caretaker.chair
    take(caretaker)
    found = []
    for linear in (200, 400, 800):
        caretaker.pull(linear)
        chair.run(400)
        found.append(deflection(chair)[0])
    assert 0 < found[0] < found[1] < found[2]
    caretaker.pull(200)
    chair.run(400)
    assert deflection(chair)[0] == found[0]


def test_a_stick_let_go_is_neutral_at_once(caretaker: Any) -> None:
    chair = caretaker.chair
    take(caretaker)
    caretaker.pull(400)
    chair.run(300)
    caretaker.page.release()
    assert chair.until(chair.neutral, 10) <= 3
    chair.comes_to_rest()


def test_a_stick_whose_page_dies_is_neutral_within_300_ms(caretaker: Any) -> None:
    chair = caretaker.chair
    take(caretaker)
    caretaker.pull(400)
    chair.run(300)
    caretaker.page.alive = False
    chair.until(chair.neutral, 310)
    assert chair.now_ms - caretaker.page.proved_ms <= 300
    chair.stays_still(500)


def test_whoever_does_not_drive_moves_nothing(caretaker: Any) -> None:
    chair = caretaker.chair
    caretaker.pull(500)  # before taking over
    chair.stays_still(300)
    caretaker.page.release()
    take(caretaker)
    chair.page.press("forward")  # the driver, who does not drive any more
    chair.stays_still(300)
    assert "not_owner" in chair.host.refusals


def test_given_back_the_driver_arms_and_drives(caretaker: Any) -> None:
    chair = caretaker.chair
    take(caretaker)
    caretaker.pull(400)
    chair.run(300)
    caretaker.page.forget_button()
    caretaker.page.say(k="release")
    chair.until(chair.neutral, 10)
    chair.until(lambda: not chair.armed(), 10)
    chair.comes_to_rest()
    chair.arm()
    chair.page.press("forward")
    chair.until(lambda: not chair.neutral(), 10)


def test_a_cap_slows_whoever_drives(caretaker: Any) -> None:
    chair = caretaker.chair
    chair.page.press("forward")
    chair.run(500)
    free = deflection(chair)[0]
    caretaker.page.say(k="cap", permille=300)
    chair.run(100)
    capped = deflection(chair)[0]
    assert 0 < capped <= 84 * 300 // 1000 + 1
    assert capped < free
    assert chair.page.shown["cap_permille"] == 300  # the driver sees it
    caretaker.page.say(k="cap", permille=1000)
    chair.run(1000)
    assert deflection(chair)[0] == free


def test_anyones_stop_ends_the_caretakers_driving(caretaker: Any) -> None:
    chair = caretaker.chair
    take(caretaker)
    caretaker.pull(400)
    chair.run(300)
    chair.page.say(k="stop")
    assert chair.until(chair.neutral, 10) <= 3
    chair.stays_still(300)  # who still holds the stick
    caretaker.page.forget_button()
    caretaker.pull(400)  # anew
    chair.until(lambda: not chair.neutral(), 10)


def test_a_viewer_stops_nothing(caretaker: Any) -> None:
    chair = caretaker.chair
    viewer = chair.another_page("viewer")
    chair.page.press("forward")
    chair.run(300)
    viewer.say(k="stop")
    viewer.say(k="emergency")
    chair.run(100)
    assert not chair.neutral()
    assert chair.host.refusals.count("not_allowed") == 2
