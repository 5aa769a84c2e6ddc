"""Since when an alert waits, also after a restart: from the diary's rows, by the wall clock."""

from __future__ import annotations

from gazechair.alerts.book import Book, Route
from gazechair.alerts.reasons import HELP_WANTED, PART

FIRST = Route("first")
SECOND = Route("second", 120.0)
THIRD = Route("third", 300.0)


def test_an_alert_that_opens_again_has_its_own_time_also_for_the_next_route() -> None:
    book = Book([FIRST, THIRD])
    book.raise_(HELP_WANTED, 0.0, 0.0)
    book.acknowledge(1, "Anna", 0.0)
    book.raise_(HELP_WANTED, 480.0, 480.0)
    assert book.as_json()[0]["at"] == 480
    again = Book([FIRST, THIRD])
    again.restore(book.as_json(), 540.0, 540.0)
    for now_s, names in ((540.0, ["first"]), (779.0, []), (780.0, ["third"])):
        assert [route.name for _, route in again.due(now_s)] == names
        again.result(1, "first", "", now_s)


def test_who_repeats_a_call_that_nobody_answered_has_waited_since_the_first() -> None:
    book = Book([SECOND])
    book.raise_(HELP_WANTED, 0.0, 0.0)
    book.end(HELP_WANTED, 50.0)
    book.raise_(HELP_WANTED, 60.0, 60.0)
    assert book.due(119.0) == []
    again = Book([SECOND])
    again.restore(book.as_json(), 119.0, 119.0)
    assert [route.name for _, route in again.due(120.0)] == ["second"]


def test_an_alert_of_a_clock_that_was_ahead_escalates_however_often_the_host_restarts() -> None:
    book, ahead_s = Book([FIRST, SECOND]), 4e8
    book.raise_(HELP_WANTED, 0.0, ahead_s)
    for now_s in (100.0, 190.0):  # the clock has been set right before the first restart
        rows = book.as_json()
        book = Book([FIRST, SECOND])
        book.restore(rows, now_s, now_s)
        assert [route.name for _, route in book.due(now_s)] == ["first"]
    assert [route.name for _, route in book.due(219.0)] == []
    assert [route.name for _, route in book.due(220.0)] == ["second"]


def test_another_part_is_told_with_its_time_and_nobody_has_answered_since_the_first() -> None:
    route = Route("bert", 1800.0)
    book = Book([route])
    book.raise_(PART, 0.0, 0.0, detail="log: gone")
    book.raise_(PART, 1700.0, 1700.0, detail="log: gone; map: gone", another=True)
    again = Book([route])
    again.restore(book.as_json(), 1750.0, 1750.0)
    for one in (book, again):
        assert one.as_json()[0]["at"] == 1700
        assert one.alerts()[0].deliveries["bert"].due_s == 1800.0


def test_a_diary_that_does_not_say_since_when_nobody_has_answered_is_read() -> None:
    book = Book([SECOND])
    book.raise_(HELP_WANTED, 0.0, 0.0)
    (row,) = book.as_json()
    del row["since"]
    again = Book([SECOND])
    again.restore([row], 100.0, 100.0)
    assert again.due(119.0) == []
    assert [route.name for _, route in again.due(120.0)] == ["second"]
