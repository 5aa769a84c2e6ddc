"""Which alert a reason that is back belongs to, and whether its answer still holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from gazechair.alerts.book import ACKNOWLEDGED, AGAIN_S, OPEN, OVER, Book, Route
from gazechair.alerts.reasons import PART
from gazechair.alerts.watch import EVENT_S, STARTING_S, Situation, Watch, named_in

QUIET = Situation()
STUCK_S = 60.0
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


def test_a_part_that_returns_after_a_minute_calls_again_though_it_was_answered() -> None:
    book = Book([Route("anna")])
    see = watched(Watch(STUCK_S), book)
    assert during(see, LOG, 0, 400) == ["anna"]
    book.acknowledge(1, "Anna", 0.0)
    assert during(see, QUIET, 400, 400 + int(AGAIN_S)) == []
    assert during(see, LOG, 460, 800) == ["anna"]


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
