"""Following a line end to end in virtual time: whole firmware, drawn floor, real pictures."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

from e2e.going_chair import PATH_MS
from e2e.picture_chair import PictureChair
from gazeboard.core import limits
from gazechair.following.line import LOST_S
from gazechair.producers.places import Target
from gazechair.producers.tiles import spots
from gazesim.floor_view import Floor, distance_to_line_m
from gazesim.rooms import Person
from promises import END_TO_END, measured

pytestmark = pytest.mark.costly

TAPE = np.array([(0.8, 0.0), (2.2, 0.0), *((2.2 + 0.1 * k, 0.0035 * k * k) for k in range(1, 9))])
FRONT_M = 0.65
PAGE_MS = 20
STEP_MS = 50
LOST_MS = round(1000 * LOST_S)


class OnTape(PictureChair):
    """Stands before a tape that bends to the left."""

    kind, tile = "line", "follow-line"

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, Floor(lines=[TAPE]))

    def _targets(self) -> Callable[[], Mapping[str, Target]]:
        return lambda: spots("line", self.allowed, self.floor)

    def chooses(self) -> None:
        """The tape, 1.7 m ahead."""
        self.looks_at(1.7, 0.0)
        self.until(lambda: bool(self.spot["mode"]), 1000)

    def drives(self) -> None:
        """On its way."""
        self.chooses()
        self.go()
        self.until(lambda: self.world.chair.speed_m_s > 0.15, 3000)


@pytest.fixture
def chair(tmp_path: Path) -> OnTape:
    return OnTape(tmp_path)


def test_follows_what_was_chosen_and_shown_to_its_end_by_the_truth(chair: OnTape) -> None:
    assert chair.host is not None
    chair.chooses()
    chair.stays_still(1000)  # a look starts nothing
    shown = np.array(chair.spot["px"])
    assert len(shown) > 5
    assert ((shown >= 0.0) & (shown <= 1.0)).all()
    seen = [chair.view.eye.pixel(x, 0.0) for x in (1.2, 1.8)]
    for u, v in np.array(seen) / (320, 240):
        assert np.hypot(*(shown - (u, v)).T).min() < 0.06
    other = chair.another_page()
    chair.run(100)
    other.spot("follow-line", (0.5, 0.9))
    chair.run(PATH_MS)
    assert chair.host.refusals[-1] == "not_owner"
    off: list[float] = []

    def watch() -> None:
        if chair.now_ms % 100 == 0:
            at = np.array(((chair.world.chair.x_m, chair.world.chair.y_m),))
            off.append(float(distance_to_line_m(np.concatenate(([(0.0, 0.0)], TAPE)), at)[0]))

    chair.watchers.append(watch)
    mode = chair.spot["mode"]
    chair.go()
    chair.until(lambda: chair.news["state"] == "drives", PATH_MS + 200)
    assert chair.page.shown["auto"] in (["", ""], [mode, ""])
    chair.until(lambda: chair.news["state"] == "arrived", 20_000)
    chair.until(chair.neutral, PAGE_MS)
    chair.comes_to_rest()
    assert max(off) < 0.10
    one = chair.world.chair
    turn = math.radians(one.heading_deg)
    front = np.array((one.x_m + FRONT_M * math.cos(turn), one.y_m + FRONT_M * math.sin(turn)))
    assert np.hypot(*(front - TAPE[-1])) < 0.2
    chair.until(lambda: not chair.spot["mode"], 400)  # going on needs another choice
    chair.page.choose(mode)
    chair.run(PATH_MS)
    assert chair.host.refusals[-1] == "no_answer"
    chair.stays_still(500)


def test_what_is_lost_and_what_people_do_ends_it(chair: OnTape) -> None:
    assert chair.host is not None
    chair.drives()
    chair.page.say(k="stop")
    ms = chair.until(chair.neutral, PAGE_MS)
    measured(END_TO_END, "P20", "Stop on a line", ms, PAGE_MS)
    chair.stays_still(500)
    assert chair.news["reason"] == "going_stopped"
    chair.until(lambda: bool(chair.spot["mode"]), 200)  # Verder: the line is still seen
    chair.go()
    chair.until(lambda: chair.world.chair.speed_m_s > 0.1, 3000)
    chair.sees = False
    chair._coming.clear()
    ms = chair.until(chair.neutral, LOST_MS + STEP_MS + PATH_MS)
    measured(END_TO_END, "P20", "no picture on a line", ms, LOST_MS + STEP_MS + PATH_MS)
    chair.until(lambda: chair.news["state"] == "ended", 1500)
    assert chair.news["reason"] == "line_lost"
    chair.sees = True
    chair.stays_still(1500)  # pictures again are no choice
    assert not chair.spot["mode"]


def test_who_stands_in_front_is_waited_for_from_the_beginning(chair: OnTape) -> None:
    chair.chooses()
    for goes in (True, False):
        chair.world.room.people = (Person(((chair.world.chair.x_m + 1.15, 0.0),)),)
        chair.run(500)
        chair.go()
        chair.stays_still(1500)
        assert chair.news["state"] == "drives"
        if goes:
            chair.world.room.people = ()
            chair.until(lambda: chair.world.chair.speed_m_s > 0.1, 3000)
            chair.page.say(k="stop")
            chair.until(chair.neutral, PAGE_MS)
            chair.comes_to_rest()
            chair.until(lambda: bool(chair.spot["mode"]), 300)
    chair.until(lambda: chair.news["state"] == "ended", 10_000)
    assert chair.news["reason"] == "auto_overruled"


def test_a_tape_that_is_gone_is_neutral_in_time(chair: OnTape) -> None:
    chair.drives()
    chair.until(lambda: chair.now_ms % 100 == 1, 100)
    chair.view.floor.lines = []
    chair.view.paint()
    ms = chair.until(chair.neutral, LOST_MS + 2 * STEP_MS + PATH_MS)
    measured(END_TO_END, "P20", "the line is gone", ms, LOST_MS + 2 * STEP_MS + PATH_MS)
    chair.until(lambda: chair.news["state"] == "ended", 1500)
    assert chair.news["reason"] == "line_lost"
    chair.stays_still(500)


@pytest.mark.parametrize("how", ["killed", "hung"])
def test_p17_its_process_ends_or_hangs(chair: OnTape, how: str) -> None:
    chair.drives()
    chair.until(lambda: chair.now_ms % STEP_MS == 1, STEP_MS)
    chair.child_fails(how)
    ms = chair.until(chair.neutral, limits.AUTO_TTL_MS + PATH_MS)
    measured(END_TO_END, "P17", f"on a line the producer is {how}", ms, limits.AUTO_TTL_MS)
    chair.stays_still(300)
    assert chair.news["reason"] == "going_failed"
    if how == "killed":
        chair.begin_child()
        chair.run(600)
        assert not chair.spot["mode"]  # it has not seen what was chosen
    else:
        chair.stopped = False
    chair.stays_still(600)


def test_p20_its_pose_is_lost(chair: OnTape) -> None:
    chair.drives()
    chair.loses_its_pose()
    assert chair.news["reason"] == "line_no_place"


def test_a_pose_that_is_late_for_a_moment_ends_nothing(chair: OnTape) -> None:
    chair.drives()
    chair.measured = False
    chair.until(lambda: chair.news["reason"] == "line_no_place", 400)
    chair.measured = True
    chair.until(chair.neutral, 100)
    chair.until(lambda: not chair.neutral(), 700)
    assert chair.news["state"] == "drives"


def test_nobody_looks_and_no_tape_where_one_looks(chair: OnTape) -> None:
    chair.looks_at(1.7, 0.5)
    chair.until(lambda: chair.spot["state"] == "ended", 1000)
    assert chair.spot["reason"] == "line_no_line"
    assert not chair.spot["mode"]
    chair.drives()
    chair.until(lambda: chair.now_ms % 250 == 1, 250)
    chair.looks = False
    chair.until(chair.neutral, 3001)
    chair.run(PATH_MS)
    assert chair.news["reason"] == "supervision_lost"
    chair.stays_still(300)


def test_old_pictures_and_another_tile_end_it(chair: OnTape) -> None:
    chair.drives()
    chair.late_ms = 400  # they go on to come
    chair.until(chair.neutral, LOST_MS + STEP_MS + PATH_MS)
    chair.until(lambda: chair.news["state"] == "ended", 2000)
    assert chair.news["reason"] == "line_lost"
    chair.stays_still(500)
    chair.late_ms = 60
    chair.run(500)
    chair.drives()
    chair.page.press("left")
    chair.until(lambda: chair.wipers()[0] == 170, PATH_MS)
    chair.until(lambda: chair.news["state"] == "ended", PATH_MS)
    chair.page.release()
    chair.until(chair.neutral, PATH_MS)
    chair.stays_still(500)
