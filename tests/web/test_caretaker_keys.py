"""What a key holds on the caretaker's page ends when the key comes up, wherever the focus went."""

import pytest

pytestmark = pytest.mark.browser

MODIFIERS = ["Control", "Alt", "Meta"]


@pytest.fixture
def driving(caretaker):
    """The caretaker has taken over, and drives by the arrow key."""
    caretaker.state(you=True, owner="caretaker", state="armed")
    caretaker.page.keyboard.down("ArrowUp")
    caretaker.advance(100)
    assert caretaker.heard("drive")[-1]["linear"] == 500
    return caretaker


def released(driving):
    """Lets the arrow key come up: the chair is stopped, and stays so."""
    driving.page.keyboard.up("ArrowUp")
    assert driving.heard("drive", "stop")[-1] == {"k": "stop"}
    driving.forget()
    driving.advance(500)
    assert driving.heard("drive") == []


def test_an_arrow_key_that_comes_up_over_the_slider_stops(driving):
    slider = driving.page.locator("#cap")
    slider.focus()
    driving.page.keyboard.down("ArrowUp")  # the key repeats
    assert slider.input_value() == "1000"
    driving.advance(100)
    assert driving.heard("drive")[-1]["linear"] == 500
    released(driving)


@pytest.mark.parametrize("modifier", MODIFIERS)
def test_an_arrow_key_that_comes_up_with_another_key_down_stops(driving, modifier):
    driving.page.keyboard.down(modifier)
    released(driving)
    driving.page.keyboard.up(modifier)


def test_an_arrow_key_over_the_slider_drives_nothing(caretaker):
    caretaker.state(you=True, owner="caretaker", state="armed")
    caretaker.page.locator("#cap").focus()
    caretaker.page.keyboard.press("ArrowDown")
    assert caretaker.heard("drive", "stop") == []
    assert caretaker.heard("cap")
