"""Alerts on the caretaker's page: vibration, failed deliveries, acknowledging, testing."""

import pytest

from patience import wait_until
from webperson import ALERT, CARETAKER, Driver

pytestmark = pytest.mark.browser


@pytest.fixture
def page(page):
    """Records vibrations and notifications."""
    page.add_init_script(
        "window.shaken = 0; navigator.vibrate = () => (shaken += 1); window.notes = [];"
        "window.Notification = class { static permission = 'granted';"
        "static requestPermission() { notes.push('asked'); }"
        "constructor(title, { body }) { notes.push(title, body); } };"
    )
    return page


def open_alerts(caretaker):
    caretaker.state(alerts=1)
    wait_until(lambda: caretaker.page.locator("#alerts li").count(), "the alerts")
    caretaker.page.locator("#tab-alarms").click()


def test_an_alert_is_felt_told_and_shown_with_what_did_not_arrive(caretaker, artefact):
    caretaker.state(alerts=1)
    wait_until(lambda: caretaker.data("alerts") == "true", "the mark")
    caretaker.advance(4500)
    assert caretaker.page.evaluate("shaken") >= 2
    assert caretaker.page.evaluate("notes") == [
        "De rolstoel kan niet verder",
        "Ik zit vast in het park",
    ]
    caretaker.page.locator("#tab-alarms").click()
    artefact("caretaker-alerts")
    text = caretaker.text("#alerts li")
    for words in ("kan niet verder", "nog niemand", "park", "anna: niet bezorgd: no network"):
        assert words in text
    before = caretaker.page.evaluate("shaken")
    caretaker.advance(5000)  # seen
    assert caretaker.page.evaluate("shaken") == before


def test_it_is_acknowledged_by_a_press(caretaker, host):
    open_alerts(caretaker)
    caretaker.page.locator("#alerts li button").click()
    wait_until(lambda: "opgepakt" in caretaker.text("#alerts li"), "the answer")
    assert host.posted == [("/alerts", {"acknowledge": 3})]
    assert caretaker.data("alerts") == "false"


def test_an_open_alert_is_shown_behind_any_number_of_newer_ones(caretaker, host):
    later = [{**ALERT, "number": number, "state": "over"} for number in range(4, 18)]
    answer = {"revision": 1, "routes": [], "alerts": [ALERT, *later]}
    host.replies["GET /alerts"] = 200, answer
    open_alerts(caretaker)
    rows = caretaker.page.locator("#alerts li")
    assert rows.count() == 13
    rows.last.locator("button").click()
    wait_until(lambda: host.posted, "the answer")
    assert host.posted == [("/alerts", {"acknowledge": 3})]


def test_an_answer_to_a_call_names_who_answers(caretaker, host):
    help_ = {**ALERT, "kind": "help", "key": "alert_help"}
    host.replies["GET /alerts"] = 200, {"revision": 1, "routes": [], "alerts": [help_]}
    caretaker.state(alerts=1, call=True)
    wait_until(lambda: caretaker.page.locator("#alerts li").count(), "the alerts")
    caretaker.page.locator("#answer").click()
    wait_until(lambda: host.posted, "the name")
    assert host.posted == [("/alerts", {"acknowledge": 3})]
    assert caretaker.received("call") == [{"k": "call", "on": False, "there": False}]


def test_a_press_tests_every_route(caretaker, host):
    open_alerts(caretaker)
    caretaker.page.locator("#alerts > button").click()
    wait_until(lambda: host.posted, "the test")
    assert host.posted == [("/alerts", {"test": True})]
    assert "asked" in caretaker.page.evaluate("notes")


def test_a_host_that_does_not_answer_is_asked_again(caretaker, host):
    host.replies["GET /alerts"] = 500, {"reason": "bad_message"}
    caretaker.state(alerts=1)
    caretaker.run_for(100)
    host.replies["GET /alerts"] = CARETAKER["GET /alerts"]

    def shown():
        caretaker.run_for(500)
        caretaker.host.say_state()
        return caretaker.page.locator("#alerts li").count()

    wait_until(shown, "the alerts")


@pytest.mark.parametrize("newer", ["another list", "an answer to a press"])
def test_an_answer_that_was_overtaken_is_not_shown(caretaker, host, newer):
    open_alerts(caretaker)
    held = []
    caretaker.page.route("**/alerts", lambda route: held.append(route))
    caretaker.state(alerts=2)
    caretaker.wait_until(lambda: len(held) == 1, "the older request")
    if newer == "another list":
        caretaker.state(alerts=3)
    else:
        caretaker.page.locator("#alerts li button").click()
    caretaker.wait_until(lambda: len(held) == 2, "the newer request")
    older, newest = held
    taken = {**ALERT, "state": "acknowledged", "by": "Anna"}
    newest.fulfill(json={"revision": 3, "routes": ["anna"], "alerts": [taken]})
    caretaker.wait_until(lambda: "Anna" in caretaker.text("#alerts li"), "the newer list")
    with caretaker.page.expect_response("**/alerts"):
        older.fulfill(json={"revision": 2, "routes": ["anna"], "alerts": [ALERT]})
    caretaker.page.evaluate("fetch('/me').then((answer) => answer.text())")
    assert "Anna" in caretaker.text("#alerts li")
    assert caretaker.data("alerts") == "false"


def test_a_viewer_asks_for_none(page, host):
    host.welcome["role"] = "viewer"
    host.replies["GET /alerts"] = CARETAKER["GET /alerts"]
    viewer = Driver(page, host)
    viewer.open("caretaker")
    viewer.state(alerts=1)
    viewer.advance(500)
    assert page.locator("#alerts li").count() == 0
