"""The caretaker's joystick under a finger: only the finger changes its value, never the page."""

import pytest

from fingers import Fingers
from patience import wait_until
from webperson import CARETAKER, Driver

pytestmark = pytest.mark.browser

PHONE = {"width": 390, "height": 844}
# Pushes everything below the page's head down, as a banner that appears would.
SHOVE = "px => { document.querySelector('header').style.paddingBottom = `${px}px`; }"


@pytest.fixture
def driving(page, host):
    """A phone with the caretaker's page, which has taken over."""
    page.set_viewport_size(PHONE)
    host.welcome["role"] = "caretaker"
    host.replies.update(CARETAKER)
    host.state.update(you=True, owner="caretaker")
    person = Driver(page, host)
    person.open("caretaker")
    person.advance(100)
    page.locator("#pad").scroll_into_view_if_needed()
    return person


@pytest.fixture
def fingers(driving):
    return Fingers(driving)


def place(driving, right, forward):
    """A place on the pad, -1..1 each (px)."""
    box = driving.page.locator("#pad").bounding_box()
    x = box["x"] + box["width"] * (1 + right) / 2
    return x, box["y"] + box["height"] * (1 - forward) / 2


def sent(driving):
    """The newest `drive` request, (linear, turn); older ones are discarded."""
    driving.forget()
    driving.advance(100)
    requests = driving.received("drive")
    return (requests[-1]["linear"], requests[-1]["turn"]) if requests else None


@pytest.mark.parametrize("px", [-20, 49, 110])
def test_a_page_that_moves_under_the_finger_changes_nothing(driving, fingers, px):
    x, y = place(driving, 0, 0.19)
    fingers.touch(1, x, y)
    assert sent(driving) == (pytest.approx(100, abs=10), 0)
    driving.page.evaluate(SHOVE, max(0, px))
    if px < 0:
        driving.page.mouse.wheel(0, px)
    fingers.touch(1, x, y + 1)
    assert sent(driving) == (pytest.approx(90, abs=10), 0)


def test_a_pad_that_changes_its_size_changes_nothing(driving, fingers):
    x, y = place(driving, 0.3, 0.3)
    fingers.touch(1, x, y)
    before = sent(driving)
    driving.page.evaluate("document.getElementById('pad').style.width = '60px'")
    fingers.touch(1, x, y + 0.5)
    assert sent(driving) == pytest.approx(before, abs=10)


def test_a_second_finger_neither_drives_nor_helps(driving, fingers):
    x, y = place(driving, 0, 0.3)
    fingers.touch(1, x, y)
    before = sent(driving)
    fingers.touch(2, *place(driving, 0, 0.95))
    assert sent(driving) == before
    fingers.touch(2, *place(driving, 0.95, 0))
    assert sent(driving) == before
    fingers.lift(1)
    assert sent(driving) is None
    fingers.touch(2, *place(driving, 0, 0.9))
    assert sent(driving) is None


def test_a_second_finger_on_stop_ends_the_grab(driving, fingers):
    fingers.touch(1, *place(driving, 0, 0.5))
    assert sent(driving)
    driving.forget()
    fingers.touch(2, *driving.spot("stop"))
    assert driving.received("stop")
    assert sent(driving) is None
    fingers.touch(1, *place(driving, 0, 0.6))
    assert sent(driving) is None


def test_a_second_finger_on_the_emergency_stop_counts(driving, fingers):
    fingers.touch(1, *place(driving, 0, 0.5))
    assert sent(driving)
    driving.forget()
    fingers.touch(2, *driving.spot("emergency"))
    fingers.lift(2)
    assert driving.received("emergency")
    assert sent(driving) is None


def test_a_second_finger_pauses_a_ride_that_the_first_one_watches(driving, fingers):
    going = {"mode": "go", "kind": "place", "name": "Bed", "state": "drives", "goal": {}}
    driving.state(auto=["go", ""], going={**going, "reason": ""}, you=False, owner="driver")
    pause = "#going button"
    driving.wait_until(lambda: driving.page.locator(pause).count(), "its part")
    driving.state()
    driving.page.locator("#going").scroll_into_view_if_needed()
    fingers.touch(1, *driving.spot("watch"))
    driving.advance(200)
    assert driving.received("watch")
    driving.forget()
    box = driving.page.locator(pause).bounding_box()
    fingers.touch(2, box["x"] + 9, box["y"] + 9)
    fingers.lift(2)
    assert driving.received("stop")


def test_a_touch_taken_away_by_the_system_stops(driving, fingers):
    fingers.touch(1, *place(driving, 0, 0.5))
    driving.advance(100)
    fingers.cancel()
    assert driving.received("drive", "stop")[-1] == {"k": "stop"}
    assert sent(driving) is None


def test_a_finger_beyond_the_pad_asks_full_in_its_direction_and_no_more(driving, fingers):
    fingers.touch(1, *place(driving, 0, 0.5))
    for right, forward, request in (
        (0, 1.4, (1000, 0)),
        (-1.4, 0, (0, 1000)),
        (1.2, 1.2, (707, -707)),
    ):
        fingers.touch(1, *place(driving, right, forward))
        assert sent(driving) == pytest.approx(request, abs=12)


def rotate(page):
    page.evaluate("() => { window.turns = 0; addEventListener('resize', () => turns++); }")
    page.set_viewport_size({"width": 844, "height": 390})
    wait_until(lambda: page.evaluate("turns"), "the page to hear of it, with its next frame")


TURNED = {
    "rotated": rotate,
    "zoomed": lambda page: page.evaluate("visualViewport.dispatchEvent(new Event('resize'))"),
    "a page that moved on": lambda page: page.evaluate(
        "document.dispatchEvent(new Event('freeze'))"
    ),
}


@pytest.mark.parametrize("how", TURNED)
def test_a_screen_that_turns_under_the_finger_ends_the_grab(driving, fingers, how):
    fingers.touch(1, *place(driving, 0, 0.5))
    assert sent(driving)
    driving.forget()
    TURNED[how](driving.page)
    driving.advance(100)
    assert driving.received("stop")
    assert driving.received("drive")[2:] == []
    fingers.touch(1, 200, 200)
    assert sent(driving) is None


def test_a_page_that_scrolls_under_the_finger_changes_nothing(driving, fingers):
    x, y = place(driving, 0, 0.3)
    fingers.touch(1, x, y)
    before = sent(driving)
    driving.page.evaluate("scrollBy(0, -60)")
    fingers.touch(1, x + 0.5, y)
    assert sent(driving) == pytest.approx(before, abs=6)


def test_a_release_that_nobody_told_ends_the_grab_at_the_next_move(driving):
    """A mouse whose button came up elsewhere moves with no button down."""
    driving.page.mouse.move(*place(driving, 0, 0.5))
    driving.page.mouse.down()
    assert sent(driving)
    driving.page.evaluate(
        "document.getElementById('pad').dispatchEvent(new PointerEvent('pointermove',"
        "{pointerId: 1, pointerType: 'mouse', buttons: 0, clientX: 200, clientY: 400}))"
    )
    assert driving.received("drive", "stop")[-1] == {"k": "stop"}
    assert sent(driving) is None


def test_the_left_button_comes_up_while_another_one_is_down(driving):
    mouse = driving.page.mouse
    mouse.move(*place(driving, 0, 0.5))
    mouse.down()
    mouse.down(button="right")
    assert sent(driving)
    mouse.up()
    assert driving.received("drive", "stop")[-1] == {"k": "stop"}
    assert sent(driving) is None
    mouse.up(button="right")
    driving.page.evaluate("document.getElementById('bypass').scrollIntoView({block: 'center'})")
    mouse.move(*driving.spot("bypass"))
    mouse.down()
    mouse.down(button="right")
    driving.advance(100)
    mouse.up()
    assert driving.received("bypass")[-1] == {"k": "bypass", "held": False}
    driving.forget()
    driving.advance(200)
    assert driving.received("bypass") == []
    mouse.up(button="right")
