"""When the host calls somebody: help, a stuck chair, faults and lost parts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from gazechair.alerts.book import ACKNOWLEDGED, AGAIN_S, OPEN, OVER, Book, Route
from gazechair.alerts.reasons import HELP_WANTED, OVERRULED, PART, REASONS, STANDS
from gazechair.alerts.watch import (
    EVENT_S,
    GAVE_UP_S,
    MOVED_S,
    STARTING_S,
    Situation,
    Watch,
    named_in,
)

QUIET = Situation()
STUCK_S = 60.0


class Scene:
    """A watch that looks five times a second; each change is noted with its second."""

    def __init__(self, help_wanted: bool = False, stuck_s: float = STUCK_S) -> None:
        self.watch = Watch(stuck_s, help_wanted)
        self.now_s = 0.0
        self.open: set[str] = {HELP_WANTED} if help_wanted else set()
        self.seen: list[tuple[float, str, bool]] = []
        self.details: list[str] = []

    def see(self, situation: Situation, seconds: float) -> None:
        end_s = self.now_s + seconds
        while self.now_s < end_s - 1e-6:
            for change in self.watch.look(situation, self.open, self.now_s):
                self.seen.append((round(self.now_s, 1), change.key, change.begins))
                self.details.append(change.detail)
                (self.open.add if change.begins else self.open.discard)(change.key)
            self.now_s = round(self.now_s + 0.2, 1)


@pytest.fixture
def scene() -> Scene:
    return Scene()


def test_help_is_wanted_at_once_until_somebody_has_come(scene: Scene) -> None:
    scene.see(QUIET, 1)
    scene.see(replace(QUIET, call=True), 5)
    scene.see(replace(QUIET, coming=True), 5)
    scene.see(QUIET, 5)
    assert scene.seen == [(1.0, HELP_WANTED, True), (11.0, HELP_WANTED, False)]


def test_help_of_before_a_restart_is_not_asked_twice() -> None:
    scene = Scene(help_wanted=True)
    scene.see(replace(QUIET, call=True), 1)
    assert scene.seen == []
    scene.see(QUIET, 1)
    assert scene.seen == [(1.0, HELP_WANTED, False)]


@pytest.mark.parametrize(
    ("key", "after_s"),
    [("tilt", 5.0), ("wiper", 10.0), ("board_lost", 60.0), ("lidar_lost", 60.0)],
)
def test_what_lasts_is_an_alert_and_what_passes_is_none(
    scene: Scene, key: str, after_s: float
) -> None:
    trouble = replace(QUIET, problems={key, "obstacle_left", "lidar_starting"})
    scene.see(trouble, after_s - 1)
    scene.see(QUIET, after_s)
    assert scene.seen == []
    scene.see(trouble, 200)
    scene.see(QUIET, 1)
    begins_s, ends_s = 3 * after_s - 1, 2 * after_s + 199
    assert scene.seen == [(begins_s, key, True), (ends_s, key, False)]
    assert REASONS[key].lasts_s == after_s


@pytest.mark.parametrize(("key", "fails_s", "works_s"), [("lidar_lost", 55, 1), ("", 10, 0.4)])
def test_what_keeps_failing_and_works_for_moments_is_an_alert(
    scene: Scene, key: str, fails_s: float, works_s: float
) -> None:
    lost = {} if key else {"input gamepad": "gone"}
    while scene.now_s < 900.0:
        scene.see(replace(QUIET, problems={key} - {""}, lost=lost), fails_s)
        scene.see(QUIET, works_s)
    assert any(begins for _, _, begins in scene.seen)


def test_short_failures_a_second_apart_are_none(scene: Scene) -> None:
    trouble = replace(QUIET, problems={"lidar_lost"}, lost={"input gamepad": "gone"})
    while scene.now_s < 1800.0:
        scene.see(trouble, 5.0)
        scene.see(QUIET, 1.0)
    assert scene.seen == []


def test_other_parts_are_named(scene: Scene) -> None:
    scene.see(replace(QUIET, lost={"log": "disk is full", "input gamepad": "gone"}), 400)
    assert scene.seen == [(300.0, PART, True)]
    assert scene.details == ["input gamepad: gone; log: disk is full"]


def test_each_part_is_lost_for_five_minutes_of_its_own(scene: Scene) -> None:
    scene.see(replace(QUIET, lost={"map": "gone"}), 150)
    scene.see(replace(QUIET, lost={"map": "gone", "odometry": "gone"}), 50)
    scene.see(replace(QUIET, lost={"odometry": "gone"}), 300)
    assert scene.seen == [(450.0, PART, True)]
    assert scene.details == ["odometry: gone"]


def test_a_lost_camera_is_not_told_with_the_parts_that_are_lost_too(scene: Scene) -> None:
    scene.see(replace(QUIET, problems={"camera_lost"}, lost={"log": "disk is full"}), 400)
    assert dict(zip((key for _, key, _ in scene.seen), scene.details, strict=True)) == {
        "camera_lost": "",
        PART: "log: disk is full",
    }


def tries(scene: Scene, times: int, every_s: float, first: int = 1) -> None:
    """Press after press, each overruled at once."""
    for press in range(first, first + times):
        scene.see(replace(QUIET, press=press, wants=True, overruled=True), 0.4)
        scene.see(replace(QUIET, press=press, overruled=True), every_s - 0.4)


def test_a_driver_who_presses_in_vain_for_long_is_stuck(scene: Scene) -> None:
    tries(scene, 6, 10.0)
    assert scene.seen == []
    tries(scene, 1, 1.0, 7)
    assert scene.seen == [(60.0, OVERRULED, True)]
    scene.see(replace(QUIET, press=8, wants=True, moving=True), MOVED_S + 0.4)
    assert scene.seen[1:] == [(63.0, OVERRULED, False)]


def test_a_chair_that_moves_in_between_or_a_driver_who_waits_is_not_stuck(scene: Scene) -> None:
    for press in range(1, 60, 10):
        tries(scene, 3, 10.0, press)
        scene.see(replace(QUIET, press=press + 5, wants=True, moving=True), MOVED_S + 0.4)
    tries(scene, 1, 10.0, 100)
    scene.see(replace(QUIET, press=100, overruled=True), GAVE_UP_S + 60.0)
    tries(scene, 5, 10.0, 101)
    assert scene.seen == []


def test_one_attempt_is_never_stuck_however_short_the_time() -> None:
    scene = Scene(stuck_s=10.0)
    tries(scene, 1, GAVE_UP_S + 60.0)
    assert scene.seen == []
    tries(scene, 2, 11.0, 2)
    assert [(key, begins) for _, key, begins in scene.seen] == [(OVERRULED, True)]


def test_what_odometry_measures_counts_whatever_the_board_puts_out(scene: Scene) -> None:
    held = replace(QUIET, wants=True, moving=True, problems={STANDS})
    scene.see(replace(QUIET, moving=True, problems={"motion_uncommanded"}), 1)
    assert scene.seen == [(0.0, "motion_uncommanded", True)]
    scene.seen.clear()
    for press in range(20):  # each try lasts 4 s: no alert alone, but together the chair is stuck
        scene.see(replace(held, press=press), 4)
        scene.see(replace(QUIET, press=press), 1)
    assert [key for _, key, _ in scene.seen] == [OVERRULED]
    scene.seen.clear()
    scene.see(held, 6)
    assert [key for _, key, _ in scene.seen] == [STANDS]


MOVES = replace(QUIET, moving=True, problems={"motion_uncommanded"})


def watched(watch: Watch, book: Book) -> Callable[[Situation, float], list[str]]:
    """Has both see a situation at a time; returns the routes that are used then."""

    def see(situation: Situation, now_s: float) -> list[str]:
        for change in watch.look(situation, book.open_keys(), now_s):
            if change.begins:
                about = change.detail, change.since_s, change.another
                book.raise_(change.key, now_s, now_s, "", *about)
            else:
                book.end(change.key, now_s)
        due = book.due(now_s)
        for alert, route in due:
            book.result(alert.number, route.name, "", now_s)
        return [route.name for _, route in due]

    return see


def during(
    see: Callable[[Situation, float], list[str]], situation: Situation, from_s: int, till_s: int
) -> list[str]:
    """Has both see it once a second; returns the routes that are used."""
    return [route for at_s in range(from_s, till_s) for route in see(situation, float(at_s))]


LOST = replace(QUIET, problems={"lidar_lost"})
STARTS = replace(QUIET, starting=True)
LOG = replace(QUIET, lost={"log": "disk is full"})
BOTH = replace(QUIET, lost={"log": "disk is full", "odometry": "gone"})


def test_another_part_calls_again_though_the_first_was_answered() -> None:
    book = Book([Route("anna")])
    see = watched(Watch(STUCK_S), book)
    assert during(see, LOG, 0, 400) == ["anna"]
    book.acknowledge(1, "Anna", 0.0)
    assert during(see, BOTH, 400, 700) == []
    assert during(see, BOTH, 700, 800) == ["anna"]
    (alert,) = book.alerts()
    assert (alert.state, alert.count, alert.detail) == (
        OPEN,
        2,
        "log: disk is full; odometry: gone",
    )


def test_a_part_that_returns_within_a_minute_is_no_other_part() -> None:
    book = Book([Route("anna")])
    see = watched(Watch(STUCK_S), book)
    assert during(see, BOTH, 0, 400) == ["anna"]
    book.acknowledge(1, "Anna", 0.0)
    assert during(see, LOG, 400, 410) + during(see, BOTH, 410, 800) == []
    assert during(see, QUIET, 800, 810) + during(see, BOTH, 810, 1200) == []
    assert [alert.state for alert in book.alerts()] == [ACKNOWLEDGED]
    assert during(see, LOG, 1200, 1200 + int(AGAIN_S)) == []
    assert during(see, BOTH, 1260, 1561) == ["anna"], "it was there for a minute"


def test_a_part_that_the_host_of_before_named_is_no_other_part() -> None:
    for named, used in (("log: disk is full", ["anna"]), ("log: disk; odometry: gone", [])):
        book = Book([Route("anna")])
        book.raise_(PART, 0.0, 0.0, detail=named)
        book.acknowledge(1, "Anna", 0.0)
        see = watched(Watch(STUCK_S, named=named_in(named)), book)
        assert during(see, STARTS, 0, 5) + during(see, BOTH, 5, 400) == used


def test_an_alert_that_is_back_names_the_parts_that_are_lost_now() -> None:
    book = Book([Route("anna"), Route("bert", 600.0)])
    see = watched(Watch(STUCK_S), book)
    odometry = replace(QUIET, lost={"odometry": "gone"})
    assert during(see, BOTH, 0, 400) + during(see, QUIET, 400, 410) == ["anna"]
    during(see, odometry, 410, 720)
    (alert,) = book.alerts()
    assert (alert.state, alert.detail) == (OPEN, "odometry: gone")


def test_an_alert_that_is_back_names_a_part_that_returned_a_little_later_too() -> None:
    book = Book([Route("anna")])
    see = watched(Watch(STUCK_S), book)
    during(see, BOTH, 0, 400)
    during(see, QUIET, 400, 410)
    during(see, LOG, 410, 440)
    during(see, BOTH, 440, 1000)
    (alert,) = book.alerts()
    assert alert.detail == "log: disk is full; odometry: gone"


def test_what_flaps_within_a_minute_is_the_same_alert_and_its_answer_holds() -> None:
    book = Book([Route("anna"), Route("bert", 120.0)])
    see = watched(Watch(STUCK_S), book)
    assert during(see, LOST, 0, 100) == ["anna"]
    book.acknowledge(1, "Anna", 0.0)
    assert during(see, LOST, 100, 200) + see(QUIET, 200.0) + during(see, LOST, 201, 400) == []
    assert [(alert.state, alert.by) for alert in book.alerts()] == [(ACKNOWLEDGED, "Anna")]
    assert during(see, QUIET, 400, 400 + int(AGAIN_S)) == []
    assert during(see, LOST, 460, 521) == ["anna"], "it was there for a minute"
    assert [alert.state for alert in book.alerts()] == [OVER, OPEN]


def test_what_flaps_and_nobody_answered_goes_to_the_next_route_on_time() -> None:
    book = Book([Route("anna"), Route("bert", 200.0)])
    see = watched(Watch(STUCK_S), book)
    assert during(see, LOST, 0, 100) + see(QUIET, 100.0) + during(see, LOST, 101, 259) == ["anna"]
    assert see(LOST, 259.0) == []
    assert see(LOST, 260.0) == ["bert"]
    assert [alert.state for alert in book.alerts()] == [OPEN]


@pytest.mark.parametrize("first", [STARTS, QUIET])
@pytest.mark.parametrize("key", ["lidar_lost", "wiper"])
def test_an_answer_survives_a_restart(key: str, first: Situation) -> None:
    lost = replace(QUIET, problems={key})
    before = Book([Route("anna")])
    assert during(watched(Watch(STUCK_S), before), lost, 0, 200) == ["anna"]
    before.acknowledge(1, "Anna", 0.0)
    book = Book([Route("anna")])
    book.restore(before.as_json(), 0.0, 200.0)
    see = watched(Watch(STUCK_S), book)
    assert see(first, 0.0) + during(see, lost, 1, 200) == []
    assert [(alert.state, alert.by) for alert in book.alerts()] == [(ACKNOWLEDGED, "Anna")]


def test_a_host_that_restarts_often_reaches_the_next_route_all_the_same() -> None:
    book = Book([Route("anna"), Route("bert", 120.0)])
    used = during(watched(Watch(STUCK_S), book), LOST, 0, 61)
    for start_s in range(61, 301, 30):
        rows, book = book.as_json(), Book([Route("anna"), Route("bert", 120.0)])
        book.restore(rows, float(start_s), float(start_s))
        see = watched(Watch(STUCK_S), book)
        used += during(see, STARTS, start_s, start_s + 10)
        used += during(see, LOST, start_s + 10, start_s + 30)
    assert used == ["anna", "bert"]


def test_what_is_gone_after_a_restart_is_over_once_every_part_has_reported() -> None:
    book = Book([])
    book.raise_("lidar_lost", 0.0, 0.0)
    see = watched(Watch(STUCK_S), book)
    during(see, STARTS, 0, 10)
    assert [alert.state for alert in book.alerts()] == [OPEN]
    see(QUIET, 10.0)
    assert [alert.state for alert in book.alerts()] == [OVER]


def test_a_part_that_starts_for_ever_does_not_keep_an_alert_open() -> None:
    book = Book([])
    book.raise_("lidar_lost", 0.0, 0.0)
    see = watched(Watch(STUCK_S), book)
    during(see, STARTS, 0, int(STARTING_S))
    assert [alert.state for alert in book.alerts()] == [OPEN]
    see(STARTS, STARTING_S)
    assert [alert.state for alert in book.alerts()] == [OVER]


@pytest.mark.parametrize("acknowledged", [True, False])
def test_an_event_stays_for_ten_minutes_and_a_later_one_calls_again(acknowledged: bool) -> None:
    book = Book([])
    see = watched(Watch(STUCK_S), book)
    see(MOVES, 0.0)
    see(QUIET, 1.0)
    if acknowledged:
        book.acknowledge(1, "Anna", 0.0)
    see(QUIET, EVENT_S)
    state = ACKNOWLEDGED if acknowledged else OPEN
    assert [alert.state for alert in book.alerts()] == [state]
    see(QUIET, EVENT_S + 1.0)
    see(MOVES, EVENT_S + 100.0)
    assert [(alert.state, alert.count) for alert in book.alerts()] == [(OVER, 1), (OPEN, 1)]


def test_another_event_within_the_ten_minutes_calls_again_though_the_first_was_answered() -> None:
    book = Book([Route("anna")])
    see = watched(Watch(STUCK_S), book)
    assert see(MOVES, 0.0) == ["anna"]
    book.acknowledge(1, "Anna", 0.0)
    see(QUIET, 5.0)
    assert see(QUIET, 299.0) == []
    assert see(MOVES, 300.0) == ["anna"]
    (alert,) = book.alerts()
    assert (alert.state, alert.by, alert.count) == (OPEN, "", 2)


def test_another_event_right_after_the_ten_minutes_calls_again_too() -> None:
    book = Book([Route("anna")])
    see = watched(Watch(STUCK_S), book)
    assert see(MOVES, 0.0) == ["anna"]
    book.acknowledge(1, "Anna", 0.0)
    assert see(QUIET, 1.0) + see(QUIET, EVENT_S + 1.0) + see(QUIET, EVENT_S + 2.0) == []
    assert [alert.state for alert in book.alerts()] == [OVER]
    assert see(MOVES, EVENT_S + 20.0) == ["anna"]
    assert [alert.state for alert in book.alerts()] == [OPEN]


def test_an_answer_holds_while_the_same_event_lasts_or_returns_within_a_minute() -> None:
    book = Book([Route("anna")])
    see = watched(Watch(STUCK_S), book)
    assert see(MOVES, 0.0) == ["anna"]
    book.acknowledge(1, "Anna", 0.0)
    times = [see(MOVES, float(at_s)) for at_s in range(1, 400)]
    times.append(see(QUIET, 400.0))
    times.append(see(MOVES, 399.0 + AGAIN_S))
    see = watched(Watch(STUCK_S), book)  # the host begins again in the middle of it
    times += [see(MOVES, 500.0), see(QUIET, 501.0), see(MOVES, 502.0)]
    assert not any(times)
    assert [alert.state for alert in book.alerts()] == [ACKNOWLEDGED]


@pytest.mark.parametrize(("started_s", "moves_s"), [(11, 40), (60, 100)])
def test_another_event_after_a_restart_calls_again_though_the_first_was_answered(
    started_s: int, moves_s: int
) -> None:
    before = Book([Route("anna")])
    assert watched(Watch(STUCK_S), before)(MOVES, 0.0) == ["anna"]
    before.acknowledge(1, "Anna", 0.0)
    book = Book([Route("anna")])
    book.restore(before.as_json(), 0.0, 24 * 3600.0)
    see = watched(Watch(STUCK_S), book)
    assert during(see, STARTS, 0, started_s) + during(see, QUIET, started_s, moves_s) == []
    assert see(MOVES, float(moves_s)) == ["anna"]
    (alert,) = book.alerts()
    assert (alert.state, alert.by, alert.count) == (OPEN, "", 2)
    book.acknowledge(1, "Anna", 0.0)
    assert during(see, QUIET, 101, 130) + see(MOVES, 130.0) == [], "the same one again"
