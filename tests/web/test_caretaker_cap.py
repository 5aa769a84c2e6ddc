"""The cap's slider under a hand that takes its time: it keeps its place until it is released."""

import pytest

pytestmark = pytest.mark.browser


def at(caretaker, share):
    """A place on the slider, 0..1 of its width (px)."""
    box = caretaker.page.locator("#cap").bounding_box()
    return box["x"] + box["width"] * share, box["y"] + box["height"] / 2


def in_view(caretaker):
    """Scrolls the slider to the middle of the screen, away from the bar with Stop."""
    caretaker.page.evaluate("document.getElementById('cap').scrollIntoView({ block: 'center' })")
    caretaker.advance(100)


@pytest.fixture
def held(caretaker):
    """The slider is dragged to about the middle, and held there."""
    in_view(caretaker)
    caretaker.page.mouse.move(*at(caretaker, 0.98))
    caretaker.page.mouse.down()
    caretaker.page.mouse.move(*at(caretaker, 0.5))
    caretaker.advance(100)
    return caretaker


def value(caretaker):
    return int(caretaker.page.locator("#cap").input_value())


def test_a_slider_that_is_held_still_keeps_its_place(held):
    wanted = value(held)
    assert 500 <= wanted <= 600
    held.advance(3000)
    assert value(held) == wanted
    assert held.text("#cap-word") == f"{wanted / 10:g} %"
    held.page.mouse.up()
    assert held.received("cap") == [{"k": "cap", "permille": wanted}]
    held.advance(500)  # the host has not confirmed it yet
    assert value(held) == wanted


def test_a_slider_that_was_released_shows_the_cap_in_force(held):
    held.page.mouse.up()
    held.advance(1200)  # nobody confirmed it
    assert value(held) == 1000
    held.state(cap_permille=350)
    assert value(held) == 350


def test_a_touch_of_the_slider_that_was_cancelled_shows_the_cap_in_force(held):
    held.page.evaluate(
        "document.getElementById('cap').dispatchEvent("
        "new PointerEvent('pointercancel', { bubbles: true }))"
    )
    held.advance(1200)
    assert value(held) == 1000
    held.page.mouse.up()


def test_another_caretakers_cap_is_shown_after_a_touch_that_moved_nothing(caretaker):
    in_view(caretaker)
    caretaker.page.mouse.move(*at(caretaker, 0.99))
    caretaker.page.mouse.down()
    caretaker.page.mouse.up()
    caretaker.advance(1200)
    caretaker.state(cap_permille=350)
    assert value(caretaker) == 350
