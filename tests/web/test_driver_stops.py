"""Everything that must stop the chair without the driver: page hidden, link lost."""

from itertools import product

import pytest

from fakehost import OFF
from patience import wait_until

pytestmark = pytest.mark.browser


HIDE = {
    "blur": "dispatchEvent(new Event('blur'))",
    "pagehide": "dispatchEvent(new Event('pagehide'))",
    "freeze": "document.dispatchEvent(new Event('freeze'))",
    "hidden": "Object.defineProperty(document, 'hidden', {value: true, configurable: true});"
    "document.dispatchEvent(new Event('visibilitychange'))",
    "leaving the document": "document.documentElement.dispatchEvent("
    "new PointerEvent('pointerleave', {pointerType: 'mouse'}))",
    "pointer cancelled": "document.body.dispatchEvent("
    "new PointerEvent('pointercancel', {bubbles: true}))",
}


def hold(driver, by):
    """Begins to drive forward by gaze, mouse button or key."""
    if by == "gaze":
        driver.hover("forward")
    elif by == "press":
        driver.look("forward")
        driver.page.mouse.down()
    else:
        driver.page.keyboard.down("ArrowUp")
    driver.advance(100, look="forward" if by == "gaze" else None)
    assert driver.newest()["k"] == "cmd"


def test_hiding_the_page_in_any_way_stops_at_once(driver):
    for by, (how, event) in product(("gaze", "press", "key"), HIDE.items()):
        hold(driver, by)
        driver.forget()
        driver.page.evaluate(event)
        assert driver.received("cmd", "stop") == [{"k": "stop"}], how
        driver.advance(300, look="forward" if by == "gaze" else None)
        assert driver.received("cmd") == [], how
        driver.page.mouse.up()
        driver.page.keyboard.up("ArrowUp")


AWAY = [how for how in HIDE if how not in ("leaving the document", "pointer cancelled")]


def test_a_page_without_its_person_switches_driving_off(driver):
    for how in AWAY:
        driver.forget()
        driver.page.evaluate(HIDE[how])
        assert driver.received("stop", "disarm") == [{"k": "stop"}, {"k": "disarm"}], how


@pytest.mark.parametrize("how", AWAY)
def test_a_page_without_its_person_takes_back_that_driving_was_asked_for(driver, how):
    driver.state(**OFF)
    driver.advance(500)
    driver.page.locator("#arm").click()
    driver.page.evaluate(HIDE[how])
    assert [m["k"] for m in driver.received("arm", "disarm")] == ["arm", "disarm"]


@pytest.mark.parametrize("answer", ["refused", "not armed", "another drives"])
def test_what_was_not_granted_is_not_taken_back_from_who_drives(driver, host, answer):
    driver.state(**OFF)
    driver.advance(500)
    driver.page.locator("#arm").click()
    if answer == "refused":
        refusal = {"what": "arm", "reason": "not_owner", "detail": "another page drives"}
        host.say({"k": "refused", **refusal})
        driver.state()  # it comes after that
    elif answer == "not armed":
        driver.advance(700)
    else:
        driver.state(state="armed", owner="caretaker")
    driver.page.evaluate(HIDE["blur"])
    assert [m["k"] for m in driver.received("arm", "disarm")] == ["arm"]


def test_what_was_never_sent_is_not_taken_back_either(driver):
    driver.state(**OFF)
    driver.advance(500)
    driver.run_for(700)  # no word from the host, and soon somebody else drives
    driver.page.locator("#arm").click()
    driver.page.evaluate(HIDE["blur"])
    assert driver.received("arm", "disarm") == []


def test_looking_away_from_a_page_that_does_not_drive_stops_nobody(driver):
    driver.state(you=False, owner="caretaker")
    driver.forget()
    for event in HIDE.values():
        driver.page.evaluate(event)
    assert driver.received("stop", "disarm") == []
    driver.look("stop")
    assert driver.received("stop") == [{"k": "stop"}]


@pytest.mark.parametrize("by", ["gaze", "press", "key"])
def test_a_tablet_that_slept_has_stopped_and_is_off(driver, by):
    hold(driver, by)
    driver.forget()
    # No tick of the page in between.
    driver.page.evaluate("__pwClock.controller.fastForward(3000)")
    driver.host.now_ms += 3000
    driver.connect()
    sent = [message["k"] for message in driver.received("cmd", "stop", "disarm")]
    assert sent[:1] == ["stop"]
    assert "disarm" in sent
    assert "cmd" not in sent
    driver.forget()
    driver.advance(1000, look="forward" if by == "gaze" else None)
    assert driver.received("cmd") == []


def test_a_jump_of_the_time_of_day_alone_stops_too(driver):
    hold(driver, "key")
    driver.forget()
    driver.page.evaluate("() => { const day = Date.now; Date.now = () => day() + 60_000; }")
    driver.advance(50)
    assert [m["k"] for m in driver.received("stop", "disarm")] == ["stop", "disarm"]


def test_going_to_another_page_says_stop(driver, host):
    driver.page.keyboard.down("ArrowUp")
    driver.forget()
    driver.page.goto("about:blank")
    wait_until(lambda: {"k": "stop"} in host.received, "the stop of a page that goes")


def test_a_silent_host_ends_the_hold_and_is_shown(driver):
    driver.page.keyboard.down("ArrowUp")
    driver.advance(200)
    assert not driver.page.locator("#lost").is_visible()
    driver.run_for(700)  # and the host sends nothing
    assert driver.page.locator("#lost").is_visible()
    assert driver.newest()["k"] == "stop"
    driver.state()
    assert not driver.page.locator("#lost").is_visible()
    driver.forget()
    driver.advance(500)
    assert driver.received("cmd") == []  # the key is still down: a new press is needed
    driver.page.keyboard.up("ArrowUp")
    driver.page.keyboard.down("ArrowUp")
    assert driver.newest()["edge"] == 2


def test_the_page_comes_back_by_itself_after_the_host_died(driver, host):
    driver.hover("forward")
    host.cut()
    wait_until(lambda: driver.data("link") == "lost", "the page to notice")
    driver.run_for(20_000)  # tries in vain for a while
    host.accepting = True
    host.received.clear()
    driver.connect()
    driver.advance(1000, look="forward")
    assert driver.received("cmd") == []  # the gaze never left: nothing starts by itself
    driver.hover("forward")
    assert driver.newest()["edge"] == 2


def sockets(driver, more="true") -> int:
    """Number of the page's control sockets for which this is true."""
    each = f"s => s.url.endsWith('control') && {more}"
    return driver.page.evaluate(f"spied.sockets.filter({each}).length")


def test_a_host_that_died_is_looked_for_every_half_second(driver, host):
    host.cut()
    for nth in range(1, 8):
        wait_until(
            lambda n=nth: sockets(driver, "s.readyState === 3") == n, f"attempt {nth} to fail"
        )
        driver.run_for(550)


def test_a_silent_connection_is_made_anew(driver):
    driver.run_for(3000)
    wait_until(lambda: sockets(driver, "s.readyState === 1"), "the new connection")  # in no time
    driver.connect()
    assert sockets(driver) == 2


def test_commands_are_dropped_not_queued_when_the_network_is_stuck(driver):
    driver.page.evaluate(
        "for (const s of spied.sockets) Object.defineProperty(s, 'bufferedAmount', {value: 9999})"
    )
    driver.forget()
    driver.page.keyboard.down("ArrowUp")
    driver.advance(300)
    driver.page.keyboard.up("ArrowUp")
    assert [m["k"] for m in driver.received("cmd", "hb", "stop")] == ["stop"]
