"""A to B end to end in virtual time: it arrives, and whatever ends it does so in time, for good."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from e2e.going_chair import PATH_MS, POSE_LOST_MS, WHERE_MS, GoingChair
from gazeboard.core import limits
from gazechair.sensing.mapping.stored.places import Drawn
from gazesim.lockstep_page import Page
from promises import END_TO_END, measured

pytestmark = pytest.mark.costly

KITCHEN, BED = (0.9, 0.1, 10.0), (1.0, -0.3, -10.0)
PAGE_MS = 20  # from a page to the wheels, in an idle network
PLAN_MS = 3000
HEARS_MS = 40  # after neutral, until the host knows that the motion has ended
SUPERVISION_MS = 3000  # the setting


def drawn() -> Drawn:
    """Two places."""
    made = Drawn()
    for name, icon, (x, y, heading) in (("Keuken", "kitchen", KITCHEN), ("Bed", "bed", BED)):
        made = made.with_place({"name": name, "icon": icon, "x": x, "y": y, "heading": heading})
    return made


@pytest.fixture
def chair(tmp_path: Path) -> GoingChair:
    made = GoingChair(tmp_path, drawn())
    made.until(lambda: "Keuken" in made.tiles, 600)
    return made


def go(chair: GoingChair, name: str = "Keuken") -> None:
    """One look at its tile."""
    chair.page.choose(chair.tiles[name])
    chair.until(lambda: not chair.neutral(), PATH_MS + PLAN_MS)


def test_it_arrives_by_the_truth_and_everybody_is_told(chair: GoingChair) -> None:
    assert chair.host is not None
    caretaker = Page(chair.host, "caretaker")
    go(chair)
    assert chair.news["state"] == "drives"
    assert chair.news["way"][-1] == list(KITCHEN[:2])
    assert chair.news["left_m"] > 0.7
    chair.until(lambda: chair.news["state"] == "arrived", 30_000)
    chair.comes_to_rest()
    far_m, far_deg = chair.off(*KITCHEN)
    assert far_m < 0.15
    assert far_deg < 5.0
    assert chair.world.collisions == 0
    chair.stays_still(200)
    for page in (chair.page, caretaker):
        assert chair.host.look(page.client)["auto"] == ["", ""]
    assert (chair.news["name"], chair.news["reason"]) == ("Keuken", "")


def ends(
    chair: GoingChair, promise: str, cause: str, limit_ms: int, reason: str, goes_on: bool = True
) -> None:
    """Neutral and over in time, and the chair stays there until its tile is pressed anew."""
    ms = chair.until(chair.neutral, limit_ms + 100)
    measured(END_TO_END, promise, cause, ms, limit_ms)
    # The host hears of it before its cause is gone; a pose is lost after half a second.
    chair.stays_still(HEARS_MS if chair.located else max(HEARS_MS, POSE_LOST_MS - ms))
    chair.alive, chair.stopped, chair.located, chair.looks = True, False, True, True
    chair.stays_still(400)
    assert chair.news["reason"] == reason
    assert chair.host is not None
    assert chair.host.look(chair.page.client)["auto"] == ["", chair.tiles["Keuken"]]
    if goes_on:
        go(chair)
        chair.run(100)


def test_a_speed_cap_too_low_to_turn_is_said_until_it_is_raised(chair: GoingChair) -> None:
    caretaker = chair.another_page("caretaker")
    chair.run(100)
    caretaker.say(k="cap", permille=200)
    chair.run(100)
    chair.page.choose(chair.tiles["Keuken"])
    chair.until(lambda: chair.news is not None and chair.news["reason"] == "going_limit", 3000)
    assert chair.news["state"] == "blocked"
    chair.stays_still(3000)
    assert chair.news["reason"] == "going_limit"
    caretaker.say(k="cap", permille=1000)
    chair.until(lambda: chair.news["state"] == "arrived", 40_000)


def test_its_process_fails_its_pose_is_lost_and_nobody_looks(chair: GoingChair) -> None:
    assert chair.host is not None
    go(chair)
    chair.child_fails("hung")
    ends(chair, "P17", "the producer is stopped (SIGSTOP)", limits.AUTO_TTL_MS, "going_failed")
    chair.child_fails()
    ms = chair.until(chair.neutral, PAGE_MS)
    measured(END_TO_END, "P17", "the producer is killed", ms, limits.AUTO_TTL_MS)
    assert chair.tiles == {}  # shown with the reason, not to be pressed
    chair.begin_child()
    chair.until(lambda: chair.tiles != {}, 600)
    chair.stays_still(100)
    assert chair.news["reason"] == "going_failed"
    assert chair.host.look(chair.page.client)["auto"] == ["", chair.tiles["Keuken"]]
    go(chair)
    chair.located = False
    ends(chair, "P20", "the place is lost", POSE_LOST_MS, "going_pose_lost")
    chair.until(lambda: chair.now_ms % 250 == 1, 250)
    chair.looks = False
    cause = f"nobody looks on a way to a place, {SUPERVISION_MS} ms set"
    ends(chair, "P18", cause, SUPERVISION_MS + 1, "supervision_lost", goes_on=False)


@pytest.mark.parametrize("what", ["located", "measured"])
def test_while_its_pose_is_late_it_stands_and_then_goes_on_by_itself(
    chair: GoingChair, what: str
) -> None:
    """Without another press, as it is not lost yet; its path is not searched for again."""
    go(chair)
    mission = chair._runner._producer._mission.result()  # type: ignore[attr-defined]
    for _ in range(3):
        chair.run(800)
        setattr(chair, what, False)
        chair.until(lambda: chair.news["reason"] == "going_pose_doubted", POSE_LOST_MS)
        setattr(chair, what, True)
        chair.until(chair.neutral, 100)
        assert chair.news["state"] == "waits"
        chair.until(lambda: not chair.neutral(), 700)
    chair.until(lambda: chair.news["state"] == "arrived", 40_000)
    chair.comes_to_rest()
    far_m, far_deg = chair.off(*KITCHEN)
    assert far_m < 0.15
    assert far_deg < 5.0
    assert mission.plans == 1


def test_a_lidar_that_dies_is_the_reason_until_it_measures_again(chair: GoingChair) -> None:
    go(chair)
    lidar = chair.world.lidars[1]
    lidar.stalled = True
    chair.until(chair.neutral, limits.CLEARANCE_OLD_MS + PAGE_MS)
    chair.comes_to_rest()
    assert (chair.news["state"], chair.news["reason"]) == ("ended", "obstacle_data_old")
    chair.page.choose(chair.tiles["Keuken"])
    chair.stays_still(600)
    assert (chair.news["state"], chair.news["reason"]) == ("ended", "obstacle_data_old")
    lidar.stalled = False
    chair.stays_still(600)
    go(chair)
    chair.until(lambda: chair.news["state"] == "arrived", 40_000)


def test_people_end_it(chair: GoingChair) -> None:
    caretaker = chair.another_page("caretaker")
    go(chair)
    causes: dict[str, Callable[[], None]] = {
        "Stop on the way to a place": lambda: chair.page.say(k="stop"),
        "the caretaker's pause": lambda: caretaker.say(k="stop"),
        "Stop and a start within the same moment": lambda: (
            chair.page.choose(chair.tiles["Keuken"]),  # type: ignore[func-returns-value]
            caretaker.say(k="stop"),
        )[0],
    }
    for cause, act in causes.items():
        act()
        ends(chair, "P20", cause, PAGE_MS, "going_stopped")
    chair.page.press("left")
    ms = chair.until(lambda: chair.wipers()[0] == 170, PATH_MS)
    measured(END_TO_END, "P20", "another tile on the way to a place", ms, PAGE_MS)
    chair.until(lambda: chair.news["state"] == "ended", PATH_MS)
    chair.page.release()
    chair.until(chair.neutral, PATH_MS)
    chair.stays_still(300)


def test_what_it_was_pressed_for_is_taken_away(chair: GoingChair) -> None:
    fence = [[4.0, 4.0], [5.0, 4.0], [5.0, 5.0]]
    go(chair)
    changes: list[Callable[[], None]] = [
        lambda: chair.store.draw("home", "no_go", fence),
        lambda: setattr(chair, "map", "another"),
        lambda: setattr(chair, "allowed", False),
        lambda: chair.store.draw("home", "remove_place", 1),
    ]
    for change in changes:
        change()
        chair.until(chair.neutral, 300 + PAGE_MS)
        assert chair.news["reason"] in ("going_changed", "going_pose_lost")
        chair.stays_still(300)
        chair.map, chair.allowed = "home", True
        chair.until(lambda: "Bed" in chair.tiles, 600)
        chair.run(WHERE_MS)  # its process, too, knows in which map it is: it answers at once
        if change is not changes[-1]:
            go(chair)
    old = f"{chair.tiles['Bed'][:-1]}1"
    for foreign in (old, "to-00000000-1", "to-", "place", "😀" * 20):
        chair.page.choose(foreign)
        chair.run(PATH_MS)
        assert chair.host is not None
        assert chair.host.refusals[-1] in ("no_answer", "bad_message")
        assert chair.harmless()


def test_another_goal_on_the_way_two_in_one_moment_and_another_driver(chair: GoingChair) -> None:
    other = chair.another_page()
    go(chair)
    chair.page.choose(chair.tiles["Bed"])
    chair.until(lambda: chair.news["name"] == "Bed" and chair.news["state"] == "drives", 1000)
    chair.until(lambda: not chair.neutral(), 1000)
    chair.page.choose(chair.tiles["Bed"])
    chair.page.choose(chair.tiles["Keuken"])  # the later one counts
    chair.until(lambda: chair.news["name"] == "Keuken" and chair.news["state"] == "drives", 1000)
    chair.until(lambda: not chair.neutral(), 1000)
    other.choose(chair.tiles["Bed"])  # may not drive, but ends it
    chair.until(chair.neutral, PATH_MS)
    assert chair.host.refusals[-1] == "not_owner"
    chair.stays_still(300)
    assert chair.news["reason"] == "going_stopped"
