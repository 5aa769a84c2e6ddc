"""A STOP that no host has received is never shown as seen, on either page."""

import pytest

pytestmark = pytest.mark.browser


@pytest.fixture(params=["driver", "caretaker"])
def person(request):
    return request.getfixturevalue(request.param)


def seen(person):
    return person.page.locator("#stop").get_attribute("data-seen")


def back(person, stops):
    """The host is there again, and has followed that many stops of the new connection."""
    person.host.accepting = True
    person.connect()
    person.state(stops=stops)
    person.advance(1200)


def test_a_stop_pressed_while_there_is_no_connection_stays_not_confirmed(person):
    person.state(stops=0)
    person.host.cut()
    person.run_for(600)
    person.page.keyboard.press("Escape")
    assert seen(person) == "sent"
    person.run_for(1100)
    assert seen(person) == "late"
    back(person, stops=0)
    assert seen(person) == "late"
    person.state(stops=7)
    assert seen(person) == "late"


@pytest.mark.parametrize("silent_ms", [0, 700])
def test_a_stop_of_a_connection_that_ended_is_not_confirmed_by_the_next(person, silent_ms):
    person.state(stops=0)
    person.run_for(silent_ms)  # the link counts as lost, but the socket is open
    person.page.keyboard.press("Escape")
    assert person.received("stop")
    person.host.cut()
    person.run_for(100)
    back(person, stops=1)
    assert seen(person) == "late"
    person.page.keyboard.press("Escape")
    assert seen(person) == "sent"
    person.state(stops=1)
    assert seen(person) == "seen"
