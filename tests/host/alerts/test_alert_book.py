"""The book of alerts: grouping, escalation, acknowledgement, failures; in virtual time."""

from __future__ import annotations

from collections import defaultdict

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from gazechair.alerts.book import (
    AGAIN_S,
    ANSWER_S,
    MOST_ALERTS,
    MOST_PER_MINUTE,
    OPEN,
    RETRIES_S,
    Book,
    Route,
)
from gazechair.alerts.reasons import HELP_WANTED, KINDS, REASONS, TRIED
from gazelink import codes

FIRST = Route("first")
SECOND = Route("second", 120.0)
THIRD = Route("third", 300.0)
KEYS = [HELP_WANTED, "tilt", "lidar_lost", "camera_lost"]


class Scene:
    """A book whose routes deliver unless told otherwise, looked at each half second."""

    def __init__(self, *routes: Route) -> None:
        self.book = Book(routes or (FIRST, SECOND, THIRD))
        self.now_s = 1000.0
        self.sent: list[tuple[float, str, str]] = []
        """(seconds since the beginning, route, key)."""
        self.problem = ""
        self.answers = True

    def raise_(self, key: str = HELP_WANTED) -> None:
        self.book.raise_(key, self.now_s, self.now_s + 1e9, "Ik zit vast in het park")

    def wait(self, seconds: float) -> None:
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            self.look()
            self.now_s += 0.5

    def look(self) -> None:
        for alert, route in self.book.due(self.now_s):
            self.sent.append((self.now_s - 1000.0, route.name, alert.key))
            if self.answers:
                self.book.result(alert.number, route.name, self.problem, self.now_s)

    def routes(self) -> list[tuple[float, str]]:
        return [(at_s, route) for at_s, route, _ in self.sent]


def test_every_fault_that_is_an_error_is_worth_an_alert() -> None:
    errors = {name for _, name, severity, _ in codes.FAULTS if severity == codes.ERROR}
    assert errors - set(REASONS) == {"simulated_source"}
    assert {reason.kind for reason in REASONS.values()} == set(KINDS)


def test_an_alert_goes_from_route_to_route_until_somebody_answers() -> None:
    scene = Scene()
    scene.raise_()
    scene.wait(1000)
    assert scene.routes() == [(0, "first"), (120, "second"), (300, "third")]


@pytest.mark.parametrize("act", ["acknowledge", "end"])
def test_an_answer_or_the_end_of_the_reason_ends_it(act: str) -> None:
    scene = Scene()
    scene.raise_()
    scene.wait(100)
    if act == "end":
        scene.book.end(HELP_WANTED, scene.now_s)
    else:
        assert scene.book.acknowledge(1, "Anna", 0.0)
        assert not scene.book.acknowledge(1, "Bert", 0.0)
        assert scene.book.as_json()[0]["by"] == "Anna"
    scene.wait(1000)
    assert scene.routes() == [(0, "first")]


def test_ten_a_second_for_a_minute_are_one_alert_and_two_deliveries() -> None:
    scene = Scene()
    for _ in range(600):
        scene.raise_()
        scene.look()
        scene.book.end(HELP_WANTED, scene.now_s)
        scene.now_s += 0.1
    scene.raise_()
    scene.wait(1)
    (row,) = scene.book.as_json()
    assert row["count"] == 601
    assert [route for _, route in scene.routes()] == ["first"] * 2


def test_a_person_who_asks_again_after_an_answer_is_heard_again_and_a_part_is_known() -> None:
    scene = Scene()
    for key in ("lidar_lost", HELP_WANTED):
        scene.raise_(key)
        scene.wait(1)
        scene.book.acknowledge(scene.book.as_json()[-1]["number"], "Anna", 0.0)
        scene.raise_(key)
    scene.wait(AGAIN_S + 1)
    assert [key for *_, key in scene.sent] == ["lidar_lost", HELP_WANTED, HELP_WANTED]


@pytest.mark.parametrize("by", ["Anna", ""])
@pytest.mark.parametrize("second_fails", [False, True])
def test_who_asks_again_after_an_answer_gives_the_next_route_its_whole_time_again(
    second_fails: bool, by: str
) -> None:
    scene = Scene(FIRST, SECOND)
    scene.raise_()
    scene.wait(10)
    if second_fails:
        scene.wait(110)
        scene.problem = "no network"
        scene.wait(1)
    scene.problem = ""
    assert scene.book.acknowledge(1, by, 0.0)
    scene.wait(290)
    scene.sent.clear()
    scene.raise_()
    scene.wait(119)
    assert [route for _, route in scene.routes()] == ["first"]
    scene.wait(2)
    assert [route for _, route in scene.routes()] == ["first", "second"]


def test_what_returns_later_is_another_alert() -> None:
    scene = Scene(FIRST)
    scene.raise_()
    scene.wait(1)
    scene.book.end(HELP_WANTED, scene.now_s)
    scene.wait(AGAIN_S)
    scene.raise_()
    scene.wait(1)
    assert [row["number"] for row in scene.book.as_json()] == [1, 2]


def test_what_could_not_be_delivered_is_kept_with_the_reason_and_tried_again() -> None:
    scene = Scene(FIRST)
    scene.problem = "no network"
    scene.raise_()
    scene.wait(1)
    (row,) = scene.book.as_json()
    assert row["deliveries"]["first"] == {"state": "failed", "detail": "no network"}
    scene.wait(RETRIES_S[0] + RETRIES_S[1])
    assert [at_s for at_s, _ in scene.routes()] == [0, 10, 30]
    scene.problem = ""
    scene.wait(120)
    assert scene.book.as_json()[0]["deliveries"]["first"] == {"state": "sent", "detail": ""}
    assert len(scene.sent) == 4


def test_an_attempt_without_a_result_has_failed() -> None:
    scene = Scene(FIRST)
    scene.answers = False
    scene.raise_()
    scene.wait(ANSWER_S + 1)
    assert scene.book.as_json()[0]["deliveries"]["first"]["state"] == "failed"
    scene.book.result(1, "first", "", scene.now_s)  # too late, or for no alert
    scene.book.result(9, "first", "", scene.now_s)
    assert scene.book.as_json()[0]["deliveries"]["first"]["state"] == "failed"


def test_help_goes_before_the_rest_and_a_route_takes_only_its_kinds() -> None:
    scene = Scene(Route("all"), Route("help", kinds=("help",)))
    for key in ("camera_lost", "lidar_lost", "tilt", HELP_WANTED):
        scene.raise_(key)
    scene.look()
    assert [(route, key) for _, route, key in scene.sent] == [
        ("all", HELP_WANTED),
        ("help", HELP_WANTED),
        ("all", "tilt"),
        ("all", "lidar_lost"),
        ("all", "camera_lost"),
    ]


def test_a_test_goes_over_every_route_at_once_and_only_once() -> None:
    scene = Scene(FIRST, SECOND, Route("help", kinds=("help",)))
    scene.problem = "refused"
    scene.raise_(TRIED)
    scene.book.acknowledge(1, "Anna", 0.0)
    scene.book.end(TRIED, scene.now_s)
    scene.wait(30)
    assert sorted(scene.routes()) == [(0, "first"), (0, "help"), (0, "second")]
    scene.raise_(TRIED)  # a failed test is retried
    scene.problem = ""
    scene.wait(20)
    assert len(scene.sent) == 6
    scene.raise_(TRIED)  # nothing has failed
    scene.wait(20)
    assert len(scene.sent) == 6
    scene.raise_(TRIED)  # another test
    scene.book.end(TRIED, scene.now_s)
    scene.wait(20)
    assert len(scene.sent) == 9
    again = Scene(FIRST)
    again.book.restore(scene.book.as_json(), again.now_s, again.now_s + 1e9)
    again.wait(10)
    assert again.sent == []
    again.raise_(TRIED)
    again.wait(1)
    assert again.routes() == [(10, "first")]


def test_a_host_that_restarts_continues_where_it_was() -> None:
    scene = Scene()
    scene.raise_()
    scene.wait(100)
    rows = scene.book.as_json()
    again = Scene()
    again.now_s = 7.0
    again.book.restore(
        [*rows, {}, {**rows[0], "deliveries": 3}, {**rows[0], "at": 1e300}], 7.0, 1000.0 + 1e9 + 100
    )
    again.wait(210)
    assert [(at_s + 993.0, route) for at_s, route in again.routes()] == [
        (20, "second"),
        (200, "third"),
    ]
    again.raise_("tilt")
    assert again.book.as_json()[-1]["number"] == 2
    assert again.book.open_keys() == {HELP_WANTED, "tilt"}


def test_what_was_over_before_a_restart_does_not_return_with_its_old_date() -> None:
    week_s = 7 * 24 * 3600.0
    scene = Scene()
    scene.raise_()
    scene.wait(1)
    scene.book.end(HELP_WANTED, scene.now_s)
    again = Scene(FIRST, SECOND)
    again.book.restore(scene.book.as_json(), again.now_s, again.now_s + 1e9 + week_s)
    again.wait(10)
    again.raise_()
    again.wait(200)
    before, now = again.book.as_json()
    assert [(row["number"], row["state"], row["count"]) for row in (before, now)] == [
        (1, "over", 1),
        (2, "open", 1),
    ]
    assert now["at"] == 1000 + 1e9 + 10
    assert again.routes() == [(10, "first"), (130, "second")]


def test_old_alerts_go_and_open_ones_stay() -> None:
    scene = Scene()
    scene.raise_()
    for _ in range(2 * MOST_ALERTS):
        scene.raise_("lidar_lost")
        scene.book.end("lidar_lost", scene.now_s)
        scene.now_s += AGAIN_S
    rows = scene.book.as_json()
    assert len(rows) == MOST_ALERTS
    assert (rows[0]["key"], rows[0]["state"]) == (HELP_WANTED, OPEN)


class AnyOrder(RuleBasedStateMachine):
    """Whatever happens: bounded deliveries, everyone reached on time, silence after an answer."""

    def __init__(self) -> None:
        super().__init__()
        self.scene = Scene()
        self.since_s: dict[str, float] = {}  # open, unanswered and never interrupted, by key
        self.before_s: dict[int, float] = {}  # the same of alerts that ended unanswered, by number

    @rule(key=st.sampled_from(KEYS), times=st.integers(1, 20))
    def repeat(self, key: str, times: int) -> None:
        alert = self.scene.book.of(key)
        if alert is None or alert.state != OPEN:
            self.since_s.pop(key, None)
        for _ in range(times):
            self.scene.raise_(key)
        alert = self.scene.book.of(key)
        if alert is not None and alert.state == OPEN:
            # A part that is back within the minute goes on with its alert, help begins again.
            known_s = self.before_s.get(alert.number, self.scene.now_s)
            self.since_s.setdefault(key, self.scene.now_s if key == HELP_WANTED else known_s)

    @precondition(lambda self: self.since_s)
    @rule(data=st.data(), by=st.sampled_from(["Anna", "Bert"]))
    def answer(self, data: st.DataObject, by: str) -> None:
        key = data.draw(st.sampled_from(sorted(self.since_s)))
        alert = self.scene.book.of(key)
        assert alert is not None
        assert self.scene.book.acknowledge(alert.number, by, 0.0)
        self._silent(key)

    @precondition(lambda self: self.since_s)
    @rule(data=st.data())
    def end(self, data: st.DataObject) -> None:
        key = data.draw(st.sampled_from(sorted(self.since_s)))
        alert = self.scene.book.of(key)
        assert alert is not None
        self.before_s[alert.number] = self.since_s[key]
        self.scene.book.end(key, self.scene.now_s)
        self._silent(key)

    def _silent(self, key: str) -> None:
        del self.since_s[key]
        before = len(self.scene.sent)
        self.scene.wait(5)
        assert key not in [sent[2] for sent in self.scene.sent[before:]]

    @rule(seconds=st.sampled_from([1, 15, 61, 130]))
    def wait(self, seconds: int) -> None:
        self.scene.wait(seconds)

    @rule(problem=st.sampled_from(["", "no network"]))
    def network(self, problem: str) -> None:
        self.scene.problem = problem

    @invariant()
    def bounded(self) -> None:
        times: dict[str, list[float]] = defaultdict(list)
        for at_s, route, _ in self.scene.sent:
            times[route].append(at_s)
        for used in times.values():
            late = zip(used, used[MOST_PER_MINUTE:], strict=False)
            assert all(after - before >= 60.0 for before, after in late)

    @invariant()
    def on_time(self) -> None:
        sent = self.scene.sent
        for key, since_s in self.since_s.items():
            for route in (FIRST, SECOND, THIRD):
                # Reopened within the minute, an alert does not go over the same route again yet.
                if self.scene.now_s - since_s > route.after_s + AGAIN_S + 1:
                    after_s = since_s - 1000.0 - AGAIN_S
                    assert any(s[0] >= after_s and s[1:] == (route.name, key) for s in sent)


TestAnyOrder = AnyOrder.TestCase
TestAnyOrder.settings = settings(max_examples=30, stateful_step_count=25, deadline=None)
