"""Going where one looks, end to end in virtual time: whole firmware, drawn floor, no map needed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from e2e.going_chair import PATH_MS, POSE_LOST_MS
from e2e.picture_chair import CAMERA, PictureChair
from gazeboard.core import limits
from gazechair.picture.floor_calibration import Calibration
from gazechair.producers.places import Target
from gazechair.producers.tiles import spots
from gazesim.floor_view import Floor
from gazesim.rooms import Room
from promises import END_TO_END, measured

pytestmark = pytest.mark.costly

SPOT = (1.5, 0.35)
HALL = Room("hall", ((-3, -3, 5, -3), (5, -3, 5, 3), (5, 3, -3, 3), (-3, 3, -3, -3)))
VAST = Room(
    "vast", ((-14, -14, 14, -14), (14, -14, 14, 14), (14, 14, -14, 14), (-14, 14, -14, -14))
)
AROUND_SPOT = [[1.2, 0.05], [1.8, 0.05], [1.8, 0.65], [1.2, 0.65]]
ACROSS = [[0.9, -3.0], [1.0, -3.0], [1.0, 3.0], [0.9, 3.0]]
PAGE_MS = 20
STEP_MS = 50
PLAN_MS = 3000


class OnFloor(PictureChair):
    """Stands in a hall of 8 by 6 m, all of which its lidars see."""

    kind, tile = "look", "go-look"
    room = HALL

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, Floor(), self.room)

    def _targets(self) -> Callable[[], Mapping[str, Target]]:
        return lambda: spots("look", self.allowed, self.floor)

    def looks_there(self, x_m: float = SPOT[0], y_m: float = SPOT[1]) -> str:
        """And the host answers: the reason, or "" and the way is shown."""
        self.looks_at(x_m, y_m)
        self.run(PATH_MS)
        self.until(lambda: self.spot["state"] in ("ready", "ended"), 5000)
        assert bool(self.spot["mode"]) == (self.spot["state"] == "ready")
        return str(self.spot["reason"])

    def goes(self) -> None:
        """There, on the way."""
        assert self.looks_there() == ""
        self.go()
        self.until(lambda: not self.neutral(), PATH_MS + PLAN_MS)


@pytest.fixture
def chair(tmp_path: Path) -> OnFloor:
    return OnFloor(tmp_path)


def test_a_look_shows_the_way_and_ga_goes_there_by_the_truth(chair: OnFloor) -> None:
    assert chair.looks_there() == ""
    chair.stays_still(1000)  # a look starts nothing
    u, v = chair.view.eye.pixel(*SPOT)
    end = chair.spot["px"][-1]
    assert math.dist(end, (u / 320, v / 240)) < 0.03
    shown = chair.spot
    assert shown["goal"]["map"] == "home"
    assert math.dist((shown["goal"]["x"], shown["goal"]["y"]), SPOT) < 0.05
    assert math.dist(shown["way"][-1], SPOT) < 0.05
    chair.go()
    chair.until(lambda: chair.news["state"] == "drives", PATH_MS + PLAN_MS)
    assert chair.news["goal"]["map"] == "home"
    assert chair.news["left_m"] > 1.0
    chair.until(lambda: chair.news["state"] == "arrived", 30_000)
    chair.until(chair.neutral, PAGE_MS)
    chair.comes_to_rest()
    one = chair.world.chair
    assert math.dist((one.x_m, one.y_m), SPOT) < 0.15
    assert chair.world.collisions == 0
    chair.until(lambda: not chair.spot["mode"], 400)
    chair.stays_still(300)


def test_what_ends_it_ends_it_in_time_and_going_on_needs_a_press(chair: OnFloor) -> None:
    chair.goes()
    chair.page.say(k="stop")
    ms = chair.until(chair.neutral, PAGE_MS)
    measured(END_TO_END, "P20", "Stop on the way to a spot", ms, PAGE_MS)
    chair.stays_still(500)
    assert chair.news["reason"] == "going_stopped"
    chair.until(lambda: bool(chair.spot["mode"]), 300)
    chair.go()
    chair.until(lambda: not chair.neutral(), PATH_MS + PLAN_MS)
    assert chair.host is not None
    chair.host.lidar_child = False
    ms = chair.until(chair.neutral, POSE_LOST_MS)
    measured(END_TO_END, "P20", "the place is lost on the way to a spot", ms, POSE_LOST_MS)
    chair.run(PATH_MS)
    assert chair.news["state"] == "ended"
    chair.stays_still(500)


def test_while_its_pose_is_late_it_stands_and_then_goes_on_by_itself(chair: OnFloor) -> None:
    chair.goes()
    chair.run(500)
    chair.measured = False
    chair.until(lambda: chair.news["reason"] == "going_pose_doubted", 500)
    chair.measured = True
    chair.until(chair.neutral, 100)
    chair.until(lambda: not chair.neutral(), 700)
    chair.until(lambda: chair.news["state"] == "arrived", 30_000)


def test_another_look_on_the_way_ends_it_and_drives_nowhere(chair: OnFloor) -> None:
    chair.goes()
    mode = chair.spot["mode"]
    chair.looks_at(1.6, -0.4)
    chair.until(chair.neutral, PATH_MS)
    chair.until(lambda: chair.news["reason"] == "going_stopped", PATH_MS)
    chair.until(lambda: bool(chair.spot["mode"]), 5000)
    assert chair.spot["mode"] != mode
    chair.page.choose(mode)  # for the spot before
    chair.run(PATH_MS)
    assert chair.host is not None
    assert chair.host.refusals[-1] == "no_answer"
    chair.stays_still(500)


@pytest.mark.parametrize("how", ["killed", "hung"])
def test_p17_its_process_ends_or_hangs(chair: OnFloor, how: str) -> None:
    chair.goes()
    chair.run(400)
    chair.until(lambda: chair.now_ms % STEP_MS == 1 and not chair.neutral(), 2000)
    chair.child_fails(how)
    ms = chair.until(chair.neutral, limits.AUTO_TTL_MS + PATH_MS)
    measured(END_TO_END, "P17", f"to a spot the producer is {how}", ms, limits.AUTO_TTL_MS)
    chair.run(300)
    assert chair.news["reason"] == "going_failed"
    chair.stopped = False
    chair.stays_still(600)


def test_what_cannot_be_gone_to_is_refused_with_its_reason(chair: OnFloor) -> None:
    assert chair.looks_there(5.6, 0.0) == "look_too_far"
    assert chair.looks_there(4.8, 0.0) == "going_goal_blocked"  # by the wall
    chair.sees = False
    chair._coming.clear()
    assert chair.looks_there() == "look_no_picture"
    chair.sees = True
    wide = Calibration(
        CAMERA.__class__(320, 180, CAMERA.focal_px, 1.15, CAMERA.pitch_rad, x_m=0.3), 0.01, 0.01
    )
    chair.floor.keep(wide)  # of a camera with another picture
    assert chair.looks_there() in ("camera_uncalibrated", "look_outside")
    chair.floor._file.path.unlink()
    chair.run(600)
    assert not chair.service.rows()  # no tile without a calibration
    chair.looks_at(*SPOT)
    chair.run(PATH_MS)
    assert chair.host is not None
    assert chair.host.refusals[-1] == "no_answer"
    assert chair.harmless()


@pytest.mark.parametrize("area", [AROUND_SPOT, ACROSS])
def test_no_path_enters_a_no_go_area_of_the_map(chair: OnFloor, area: list[list[float]]) -> None:
    chair.store.draw("home", "no_go", area)
    assert chair.looks_there() in ("going_goal_blocked", "going_no_way")
    chair.store.draw("home", "remove_no_go", 1)
    assert chair.looks_there() == ""


def test_an_area_that_is_drawn_ends_a_path_through_it_before_and_after_ga(chair: OnFloor) -> None:
    assert chair.looks_there() == ""
    chair.store.draw("home", "no_go", ACROSS)
    chair.until(lambda: not chair.spot["mode"], 600)
    assert chair.spot["reason"] == "going_changed"
    chair.stays_still(300)
    chair.store.draw("home", "remove_no_go", 1)
    chair.goes()
    chair.store.draw("home", "no_go", ACROSS)
    chair.until(chair.neutral, 300 + PAGE_MS)
    chair.run(PATH_MS)
    assert chair.news["reason"] == "going_changed"
    chair.stays_still(300)


def test_areas_count_once_the_chair_knows_where_it_is(chair: OnFloor) -> None:
    chair.store.draw("home", "no_go", ACROSS)
    chair.located = False
    chair.run(500)
    assert chair.looks_there() == ""  # it does not know that an area is there
    chair.located = True
    chair.until(lambda: not chair.spot["mode"], 600)
    assert chair.spot["reason"] == "going_changed"


class InVastHall(OnFloor):
    """No wall is near enough for the lidars' view to become a map."""

    room = VAST


def test_where_the_lidars_see_nothing_a_spot_is_refused(tmp_path: Path) -> None:
    assert InVastHall(tmp_path).looks_there() == "look_unseen"
