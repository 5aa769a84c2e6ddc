"""When the host calls somebody: help, a stuck chair, faults and lost parts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from gazechair.alerts.book import ACKNOWLEDGED, AGAIN_S, OPEN, OVER, Book, Route
from gazechair.alerts.reasons import HELP_WANTED, OVERRULED, PART, REASONS, STANDS
from gazechair.alerts.watch import EVENT_S, GAVE_UP_S, MOVED_S, Situation, Watch

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
    scene.see(QUIET, 1)
    assert scene.seen == []
    scene.see(trouble, 200)
    scene.see(QUIET, 1)
    assert scene.seen == [(2 * after_s, key, True), (after_s + 200, key, False)]
    assert REASONS[key].lasts_s == after_s


def test_other_parts_are_named(scene: Scene) -> None:
    scene.see(replace(QUIET, lost={"log": "disk is full", "input gamepad": "gone"}), 400)
    assert scene.seen == [(300.0, PART, True)]
    assert scene.details == ["input gamepad: gone; log: disk is full"]


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
                book.raise_(change.key, now_s, now_s)
            else:
                book.end(change.key, now_s)
        due = book.due(now_s)
        for alert, route in due:
            book.result(alert.number, route.name, "", now_s)
        return [route.name for _, route in due]

    return see


@pytest.mark.parametrize("acknowledged", [True, False])
def test_an_event_stays_for_ten_minutes_and_a_later_one_calls_again(acknowledged: bool) -> None:
    book = Book([])
    see = watched(Watch(STUCK_S), book)
    see(MOVES, 0.0)
    see(QUIET, 1.0)
    if acknowledged:
        book.acknowledge(1, "Anna")
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
    book.acknowledge(1, "Anna")
    see(QUIET, 5.0)
    assert see(QUIET, 299.0) == []
    assert see(MOVES, 300.0) == ["anna"]
    (alert,) = book.alerts()
    assert (alert.state, alert.by, alert.count) == (OPEN, "", 2)


def test_an_answer_holds_while_the_same_event_lasts_or_returns_within_a_minute() -> None:
    book = Book([Route("anna")])
    see = watched(Watch(STUCK_S), book)
    assert see(MOVES, 0.0) == ["anna"]
    book.acknowledge(1, "Anna")
    times = [see(MOVES, float(at_s)) for at_s in range(1, 400)]
    times.append(see(QUIET, 400.0))
    times.append(see(MOVES, 399.0 + AGAIN_S))
    see = watched(Watch(STUCK_S), book)  # the host begins again in the middle of it
    times += [see(MOVES, 500.0), see(QUIET, 501.0), see(MOVES, 502.0)]
    assert not any(times)
    assert [alert.state for alert in book.alerts()] == [ACKNOWLEDGED]
