"""What a key holds on the caretaker's page ends when the key comes up, wherever the focus went."""

import pytest

from patience import wait_until

pytestmark = pytest.mark.browser

MODIFIERS = ["Control", "Alt", "Meta"]


@pytest.fixture
def driving(caretaker):
    """The caretaker has taken over, and drives by the arrow key."""
    caretaker.state(you=True, owner="caretaker", state="armed")
    pushed(caretaker)
    return caretaker


def pushed(caretaker):
    """Pushes the chair ahead by the arrow key."""
    caretaker.page.keyboard.down("ArrowUp")
    caretaker.advance(100)
    assert caretaker.received("drive")[-1]["linear"] == 500


def released(driving):
    """Lets the arrow key come up: the chair is stopped, and stays so."""
    driving.page.keyboard.up("ArrowUp")
    assert driving.received("drive", "stop")[-1] == {"k": "stop"}
    driving.forget()
    driving.advance(500)
    assert driving.received("drive") == []


def test_an_arrow_key_that_comes_up_over_the_slider_stops(driving):
    slider = driving.page.locator("#cap")
    slider.focus()
    driving.page.keyboard.down("ArrowUp")  # the key repeats
    assert slider.input_value() == "1000"
    driving.advance(100)
    assert driving.received("drive")[-1]["linear"] == 500
    released(driving)


def test_an_arrow_key_that_comes_up_with_another_key_down_stops(driving):
    for modifier in MODIFIERS:
        driving.page.keyboard.down(modifier)
        released(driving)
        driving.page.keyboard.up(modifier)
        pushed(driving)


def test_a_key_of_the_keypad_that_comes_up_as_a_digit_stops(caretaker):
    caretaker.state(you=True, owner="caretaker", state="armed")
    caretaker.keyed("keydown", "ArrowUp", "Numpad8")
    caretaker.advance(100)
    assert caretaker.received("drive")[-1]["linear"] == 500
    caretaker.keyed("keyup", "8", "Numpad8")
    assert caretaker.received("drive", "stop")[-1] == {"k": "stop"}
    caretaker.forget()
    caretaker.advance(500)
    assert caretaker.received("drive") == []


def test_two_keys_for_one_direction_push_as_one(driving):
    driving.keyed("keydown", "ArrowUp", "Numpad8")
    driving.advance(100)
    driving.keyed("keyup", "8", "Numpad8")
    driving.advance(100)
    assert {sent["linear"] for sent in driving.received("drive")} == {500}
    released(driving)


def test_cmd_ends_the_push_of_an_arrow_key(driving):
    driving.page.keyboard.down("Meta")  # macOS reports no release from now on
    assert driving.received("drive", "stop")[-1] == {"k": "stop"}
    driving.forget()
    driving.page.keyboard.down("ArrowUp")  # the key repeats
    driving.page.keyboard.up("Meta")
    driving.page.keyboard.down("ArrowUp")
    driving.advance(500)
    assert driving.received("drive") == []


def test_an_arrow_key_over_the_slider_drives_nothing(caretaker):
    caretaker.state(you=True, owner="caretaker", state="armed")
    caretaker.page.locator("#cap").focus()
    caretaker.page.keyboard.press("ArrowDown")
    assert caretaker.received("drive", "stop") == []
    assert caretaker.received("cap")


# Buttons that work only while held


def tabbed(page):
    page.keyboard.press("Tab")


def clicked(page):
    page.locator("header").click(position={"x": 2, "y": 2})


def never_told(page):
    """The button lost the focus without a word, as one that is hidden does in some browsers."""
    page.evaluate(
        "addEventListener('blur', (event) => event.stopImmediatePropagation(),"
        "{ capture: true, once: true })"
    )
    page.keyboard.press("Tab")
    page.keyboard.up("Enter")


def held(caretaker, button, kind):
    """The button is held by a key, and says so."""
    caretaker.page.locator(button).focus()
    caretaker.page.keyboard.down("Enter")
    caretaker.advance(200)
    assert caretaker.received(kind)


def ended(caretaker, kind):
    caretaker.forget()
    caretaker.advance(500)
    assert [sent for sent in caretaker.received(kind) if sent.get("held", True)] == []


@pytest.mark.parametrize("kind", ["watch", "bypass"])
def test_a_button_held_by_a_key_is_released_when_the_focus_goes(caretaker, kind):
    caretaker.state(auto=["go", ""])
    for leave in (tabbed, clicked, never_told):
        caretaker.forget()
        held(caretaker, f"#{kind}", kind)
        leave(caretaker.page)
        ended(caretaker, kind)
        caretaker.page.keyboard.up("Enter")


def test_a_step_of_the_first_drive_held_by_a_key_ends_when_the_focus_goes(caretaker):
    row = {"step": "tune", "done": False, "refused": "", "profile": "3.1"}
    run = {"step": "", "lines": [], "pulses": 0, "straight": 0, "asks": "", "ended": None}
    caretaker.host.replies["GET /first-drive"] = (200, {"steps": [row], "run": run})
    caretaker.page.locator("#tab-settings").click()
    caretaker.page.locator("#tab-first").click()
    button = ".first button.held"
    caretaker.wait_until(
        lambda: caretaker.advance(600) or caretaker.page.locator(button).is_visible(), "the step"
    )
    held(caretaker, button, "step")
    tabbed(caretaker.page)
    assert caretaker.received("step")[-1] == {"k": "step", "held": False}
    ended(caretaker, "step")


def test_a_button_held_by_space_is_released_by_a_space_of_another_name(caretaker):
    caretaker.page.locator("#bypass").focus()
    caretaker.keyed("keydown", " ", "Space")
    assert caretaker.received("bypass")
    caretaker.keyed("keyup", "\u00a0", "Space")
    ended(caretaker, "bypass")


def test_cmd_releases_a_button_that_a_key_holds(caretaker):
    held(caretaker, "#bypass", "bypass")
    caretaker.page.keyboard.down("Meta")
    ended(caretaker, "bypass")
    caretaker.page.keyboard.up("Enter")
    caretaker.page.keyboard.down("Enter")  # no release of this one would be reported
    ended(caretaker, "bypass")


# Buttons that act at a press


@pytest.mark.parametrize(("button", "kind"), [("#answer", "call"), ("#take", "take")])
def test_a_key_that_is_held_presses_a_button_once(caretaker, button, kind):
    caretaker.state(call=True)
    caretaker.page.locator(button).focus()
    caretaker.page.keyboard.down("Enter")
    caretaker.state(call=False, coming=True)
    for _ in range(3):
        caretaker.advance(600)
        caretaker.page.keyboard.down("Enter")  # Playwright sends a repeat of a key that is down
    assert len(caretaker.received(kind)) == 1
    caretaker.page.keyboard.up("Enter")
    caretaker.page.keyboard.down("Enter")
    assert len(caretaker.received(kind)) == 2


def test_a_key_that_is_held_makes_one_person(caretaker, host):
    caretaker.page.locator("#tab-settings").click()
    caretaker.page.locator("#profiles button").first.focus()
    for _ in range(4):
        caretaker.page.keyboard.down("Enter")
        caretaker.advance(100)
    wait_until(lambda: len(host.profiles.as_json()["profiles"]) > 1, "the new one")
    caretaker.page.evaluate("fetch('/me').then((answer) => answer.text())")
    assert len(host.profiles.as_json()["profiles"]) == 2


def test_a_key_that_comes_up_over_its_button_releases_it(caretaker):
    held(caretaker, "#bypass", "bypass")
    caretaker.page.keyboard.up("Enter")
    assert caretaker.received("bypass")[-1] == {"k": "bypass", "held": False}
    ended(caretaker, "bypass")
