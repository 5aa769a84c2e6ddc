"""Kind "place": the map, however large, is prepared outside the steps, which take 20 s at most."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gazechair.base.footprint import Footprint
from gazechair.going.mission import DRIVING, WAITING
from gazechair.going.path import Abandoned
from gazechair.going.plan import Planner
from gazechair.producers import place
from gazechair.producers.contract import Press, Sensed, Setup
from gazechair.producers.pose_watch import AGAIN_S, ENDS_S, STANDS_S
from gazechair.producers.ride import POSE_DOUBTED
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.locating.whereabouts import Whereabouts
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.store import MapStore
from gazechair.sensing.odometry.estimate import Estimate
from gazelink.settings_table import TABLE

SETTINGS = {name: default for name, default, _, _ in TABLE}


class Later(Executor):
    """Computes when told to."""

    def __init__(self) -> None:
        self.todo: list[tuple[Future[Any], Callable[[], Any]]] = []

    def submit(self, work: Any, /, *args: Any, **more: Any) -> Future[Any]:
        made: Future[Any] = Future()
        self.todo.append((made, lambda: work(*args, **more)))
        return made

    def compute(self) -> None:
        for made, work in self.todo:
            if made.set_running_or_notify_cancel():
                made.set_result(work())
        self.todo.clear()


@pytest.fixture
def thinker() -> Later:
    return Later()


@pytest.fixture
def producer(tmp_path: Path, thinker: Later) -> place.PlaceProducer:
    hits = np.zeros((100, 100), dtype=np.uint16)
    hits[0] = 5
    passes = np.where(hits, 0, 5).astype(np.uint16)
    grid = OccupancyGrid(0.05, np.zeros(2), hits, passes)
    HomeMap("home", grid, "2026-11-22T20:00:00Z").save(tmp_path / "a.map")
    return place.PlaceProducer(Setup(Footprint(), tmp_path, thinker=thinker))


def press(
    number: int,
    map_: str = "a",
    may_reverse: bool = True,
    at_s: float = 10.0,
    settings: Mapping[str, int] = SETTINGS,
    **more: float,
) -> Press:
    target = {"map": map_, "x": 2.0, "y": 2.0, "heading": 0.0, "drawn": 0, **more}
    return Press(number, target, settings, may_reverse, at_s)


def here(at_s: float) -> Sensed:
    """What a chair that stands in the map "a" senses."""
    estimate = Estimate(at_s, 4.0, 2.0, 180.0, 0.0, 0.0, 0.0, 0.01, 0.01, 0.1, 0.01, 1.0, (), 1)
    where = Whereabouts(at_s, "a", 4.0, 2.0, 180.0, 0.01, 0.1, 1.0)
    return Sensed(estimates=[estimate], where=where)


def drive(producer: place.PlaceProducer, thinker: Later, since_s: float, steps: int = 4) -> float:
    """Step `steps` times; returns the time of the last one."""
    for n in range(steps):
        producer.step(here(since_s + 0.05 * n), since_s + 0.05 * n)
        thinker.compute()
    return since_s + 0.05 * (steps - 1)


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[Planner]:
    """The planners that were made."""
    found: list[Planner] = []

    def planner(*of: Any, **more: Any) -> Planner:
        found.append(Planner(*of, **more))
        return found[-1]

    monkeypatch.setattr(place, "Planner", planner)
    return found


def test_no_step_waits_for_the_map(
    producer: place.PlaceProducer, thinker: Later, made: list[Planner]
) -> None:
    producer.press(press(1))
    for at_s in (10.0, 40.0):
        sent = producer.step(Sensed(), at_s)
        assert (sent.stick, sent.state) == ((0, 0), "thinks")
    assert not made
    thinker.compute()
    assert len(made) == 1
    assert producer.step(Sensed(), 40.0).state == "thinks"  # the wait for a pose begins
    sent = producer.step(Sensed(), 40.1 + STANDS_S)
    assert (sent.stick, sent.reason) == (None, place.POSE_LOST)


def test_another_goal_does_not_wait_for_the_plan_of_a_chair_at_rest(
    producer: place.PlaceProducer, thinker: Later, made: list[Planner]
) -> None:
    producer.press(press(1))
    producer.step(here(10.0), 10.0)
    thinker.compute()
    producer.step(here(10.1), 10.1)
    _, plan = thinker.todo[0]
    producer.press(press(2, x=1.0))
    with pytest.raises(Abandoned):
        plan()
    thinker.todo.pop(0)
    thinker.compute()
    drive(producer, thinker, 10.2)
    assert producer.step(here(10.5), 10.5).state == "drives"


def test_where_no_lidar_sees_behind_it_says_so(
    producer: place.PlaceProducer, thinker: Later
) -> None:
    """The board would permit no turn, and nobody could clear a way."""
    producer.press(press(1, may_reverse=False))
    assert not thinker.todo
    sent = producer.step(Sensed(), 10.0)
    assert (sent.stick, sent.state, sent.reason) == (None, "ended", place.UNSEEN_BEHIND)
    producer.press(press(2))
    assert producer.step(Sensed(), 10.1).state == "thinks"


def test_another_press_does_not_wait_for_the_map_of_the_one_before(
    producer: place.PlaceProducer, thinker: Later
) -> None:
    producer.press(press(1))
    producer.press(press(2, "b"))
    assert thinker.todo[0][0].cancelled()
    thinker.compute()
    sent = producer.step(Sensed(), 10.0)
    assert (sent.stick, sent.reason) == (None, place.MAP_GONE)


def test_another_press_in_the_same_map_does_not_prepare_it_again(
    producer: place.PlaceProducer, thinker: Later, made: list[Planner], tmp_path: Path
) -> None:
    """After *Pauze*: what was seen of the map's surroundings stays, too."""
    missions = []
    for number in (1, 2):
        producer.press(press(number))
        thinker.compute()
        missions.append(producer._mission.result())
    first, second = missions
    assert first is not None
    assert second is not None
    assert first is not second  # nobody has driven meanwhile
    assert first.costmap is second.costmap
    assert len(made) == 1
    area = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]]
    MapStore(tmp_path).draw("a", "no_go", area)
    producer.press(press(3))
    thinker.compute()
    assert len(made) == 2
    mission = producer._mission.result()
    assert mission is not None
    assert mission.costmap is not second.costmap


def test_a_press_on_the_way_keeps_the_mission_and_changes_its_goal(
    producer: place.PlaceProducer, thinker: Later
) -> None:
    producer.press(press(1))
    now_s = drive(producer, thinker, 10.0)
    first = producer._mission.result()
    assert first is not None
    assert first.state == DRIVING
    path = first.path
    producer.press(press(2, at_s=now_s + 0.05, y=3.0))
    now_s = drive(producer, thinker, now_s + 0.05, 1)
    assert producer._mission.result() is first
    assert first.goal == (2.0, 3.0, 0.0)
    assert first.state == DRIVING
    assert first.path is path  # until the new one is known
    drive(producer, thinker, now_s + 0.05, 2)
    assert first.path is not None
    assert first.path.points_m[-1].tolist() == [2.0, 3.0]


@pytest.mark.parametrize(("y_m", "state"), [(3.0, "drives"), (0.05, "blocked")])
def test_the_old_goals_path_is_not_shown_as_the_new_goals(
    producer: place.PlaceProducer, thinker: Later, y_m: float, state: str
) -> None:
    """`blocked`: no way leads there, in the wall."""
    producer.press(press(1))
    now_s = drive(producer, thinker, 10.0)
    shown = producer.step(here(now_s), now_s).shown
    assert shown["way"][-1] == [2.0, 2.0]
    assert shown["left_m"] == pytest.approx(2.0, abs=0.1)
    now_s += 0.05
    producer.press(press(2, at_s=now_s, y=y_m))
    sent = producer.step(here(now_s), now_s)
    assert (sent.state, sent.shown) == ("drives", {"way": []})
    now_s = drive(producer, thinker, now_s + 0.05)
    sent = producer.step(here(now_s), now_s)
    assert sent.state == state
    if state == "blocked":
        assert sent.shown == {"way": []}
    else:
        assert sent.shown["way"][-1] == [2.0, 3.0]
        assert sent.shown["left_m"] > 2.0


@pytest.mark.parametrize(
    "another",
    [
        {"at_s": 10.5},  # paused
        {"drawn": 1},
        {"settings": {**SETTINGS, "profile": 1}},
    ],
)
def test_where_anything_else_has_changed_a_press_makes_a_new_mission(
    producer: place.PlaceProducer, thinker: Later, another: dict[str, Any]
) -> None:
    producer.press(press(1))
    now_s = drive(producer, thinker, 10.0)
    first = producer._mission.result()
    producer.press(press(2, **{"at_s": now_s + 0.05, **another}))
    thinker.compute()
    assert producer._mission.result() is not first


def test_a_chair_that_waits_or_has_lost_its_pose_begins_a_new_mission(
    producer: place.PlaceProducer, thinker: Later
) -> None:
    producer.press(press(1))
    now_s = drive(producer, thinker, 10.0)
    mission = producer._mission.result()
    assert mission is not None
    mission.state = WAITING
    producer.press(press(2, at_s=now_s + 0.05))
    thinker.compute()
    assert producer._mission.result() is not mission
    now_s = drive(producer, thinker, now_s + 0.05)
    mission = producer._mission.result()
    for n in range(1, 14):  # the last pose is too old from the ninth on
        producer.step(Sensed(), now_s + 0.05 * n)
    producer.press(press(3, at_s=now_s + 0.7))
    thinker.compute()
    assert producer._mission.result() is not mission


def test_a_late_pose_makes_it_stand_and_go_on_along_its_path(
    producer: place.PlaceProducer, thinker: Later
) -> None:
    producer.press(press(1))
    now_s = drive(producer, thinker, 10.0, 8)
    mission = producer._mission.result()
    assert mission is not None
    path, plans = mission.path, mission.plans
    sent = [producer.step(Sensed(), now_s + 0.05 * n) for n in range(1, round(ENDS_S / 0.05))]
    assert sent[0].stick != (0, 0)
    stands = next(n for n, one in enumerate(sent, 1) if one.reason == POSE_DOUBTED)
    assert {(one.stick, one.state) for one in sent[stands - 1 :]} == {((0, 0), "waits")}
    assert sent[-1].shown["way"]
    now_s += ENDS_S
    again = [producer.step(here(now_s + 0.05 * n), now_s + 0.05 * n) for n in range(12)]
    moves = next(n for n, one in enumerate(again) if one.stick != (0, 0))
    assert 0.05 * moves >= AGAIN_S
    assert again[-1].state == "drives"
    assert (mission.path, mission.plans, thinker.todo) == (path, plans, [])


def test_a_pose_that_stays_unknown_ends_it(producer: place.PlaceProducer, thinker: Later) -> None:
    producer.press(press(1))
    now_s = drive(producer, thinker, 10.0, 20)
    sent = [producer.step(Sensed(), now_s + 0.05 * n) for n in range(1, 80)]
    ends = next(n for n, one in enumerate(sent, 1) if one.stick is None)
    assert 0.05 * ends <= 0.5  # promise P20
    assert (sent[ends - 1].state, sent[ends - 1].reason) == ("ended", place.POSE_LOST)
    assert all(one.stick == (0, 0) for one in sent[6 : ends - 1])
    assert producer.step(here(now_s + 4.0), now_s + 4.0).stick is None  # without a new press


def test_a_chair_that_is_in_another_map_does_not_wait(
    producer: place.PlaceProducer, thinker: Later
) -> None:
    producer.press(press(1))
    now_s = drive(producer, thinker, 10.0, 8) + 0.05
    sensed = here(now_s)
    assert sensed.where is not None
    sensed.where = replace(sensed.where, map="b")
    sent = producer.step(sensed, now_s)
    assert (sent.stick, sent.state, sent.reason) == (None, "ended", place.POSE_LOST)


def test_a_large_map_is_not_kept_while_another_is_prepared(
    producer: place.PlaceProducer,
    thinker: Later,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    producer.press(press(1))
    thinker.compute()
    mission = producer._mission.result()
    assert mission is not None
    before, costmap_of = weakref.ref(mission.costmap), place.costmap_of
    del mission
    alive: list[bool] = []

    def noting(*given: Any) -> Any:
        gc.collect()
        alive.append(before() is not None)
        return costmap_of(*given)

    monkeypatch.setattr(place, "costmap_of", noting)
    MapStore(tmp_path).draw("a", "no_go", [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]])
    producer.press(press(2))
    thinker.compute()
    assert alive == [False]
