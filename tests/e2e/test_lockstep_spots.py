"""Spots of the picture that are chosen from a chair that moves, or is moved: end to end."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from e2e.picture_chair import EYE, PictureChair
from e2e.test_lockstep_line import OnTape
from e2e.test_lockstep_look import OnFloor
from gazechair.sensing.inbox.inbox import HalfTurn

pytestmark = pytest.mark.costly

SPOT = (1.7, 0.0)
PATH_MS = 60


@pytest.fixture(params=[OnFloor, OnTape])
def chair(request: pytest.FixtureRequest, tmp_path: Path) -> PictureChair:
    made: PictureChair = request.param(tmp_path)
    return made


def looks(chair: PictureChair) -> str:
    """At the spot, and the host answers."""
    chair.looks_at(*SPOT)
    chair.run(PATH_MS)
    chair.until(lambda: chair.spot["state"] in ("ready", "ended"), 6000)
    return str(chair.spot["reason"])


def test_what_was_looked_at_is_meant_though_the_chair_turned_on(chair: PictureChair) -> None:
    one = chair.world.chair
    chair.page.press("right")
    chair.until(lambda: one.heading_deg < -8.0, 3000)
    turned_deg = one.heading_deg
    chair.page.release()
    assert looks(chair) == ""
    assert one.heading_deg < turned_deg - 5.0  # it has rolled on
    px = chair.spot["px"]
    turn = math.radians(-one.heading_deg)
    ahead = math.cos(turn) * (SPOT[0] - one.x_m) - math.sin(turn) * (SPOT[1] - one.y_m)
    left = math.sin(turn) * (SPOT[0] - one.x_m) + math.cos(turn) * (SPOT[1] - one.y_m)
    u, v = EYE.pixel(ahead, left)
    there = u / EYE.width_px, v / EYE.height_px
    assert min(math.dist(there, point) for point in px) < 0.08
    if isinstance(chair, OnFloor):
        assert math.dist(chair.spot["at"], there) < 0.02
    chair.stays_still(300)


def test_moved_by_hand_right_after_the_look_it_is_gone(chair: PictureChair) -> None:
    assert looks(chair) == ""
    mode = chair.spot["mode"]
    chair.page.press("forward")
    chair.run(900)
    chair.page.release()
    chair.until(chair.neutral, PATH_MS)
    chair.comes_to_rest()
    assert chair.world.chair.x_m > 0.12
    chair.run(300)
    assert chair.spot["mode"] == ""
    assert chair.spot["reason"] in ("look_not_now", "line_not_now")
    chair.page.choose(mode)
    chair.stays_still(500)


def test_somebodys_stop_is_newer_than_a_ga_that_was_longer_on_its_way(chair: PictureChair) -> None:
    caretaker = chair.another_page("caretaker")
    assert looks(chair) == ""
    chair.page.delay_ms = 80
    chair.run(200)
    chair.go()
    chair.run(40)
    caretaker.say(k="stop")
    chair.stays_still(600)
    assert chair.host.refusals[-1] == "needs_new_command"
    chair.go()
    chair.until(lambda: not chair.neutral(), 3000)


@pytest.mark.parametrize("role", ["driver", "caretaker"])
def test_so_is_anybodys_press_of_something_that_drives(chair: PictureChair, role: str) -> None:
    other = chair.another_page(role)
    assert looks(chair) == ""
    chair.page.delay_ms = 80
    chair.run(200)
    chair.go()
    chair.run(40)
    other.press("forward")
    chair.stays_still(100)
    other.release()
    chair.stays_still(500)
    assert chair.host is not None
    assert chair.host.refusals[-2:] == ["not_owner", "needs_new_command"]
    chair.go()
    chair.until(lambda: not chair.neutral(), 3000)


def test_whose_lidars_show_nothing_it_says_so_in_time(tmp_path: Path) -> None:
    chair = OnFloor(tmp_path)
    received = chair._runner.received

    def not_scans(sent: object, now_s: float) -> None:
        if not isinstance(sent, HalfTurn):
            received(sent, now_s)  # type: ignore[arg-type]

    chair._runner.received = not_scans  # type: ignore[method-assign]
    assert looks(chair) == "look_no_place"
