"""Driving with the page, in a real Chromium with a stand-in for the host."""

from itertools import pairwise

import pytest

from fakehost import OFF
from fingers import Stylus
from gazechair.driving.control import HEARTBEAT_MS

pytestmark = pytest.mark.browser

ON = {"state": "armed", "you": True, "owner": "driver"}
# A step is repeated for 150 ms (intent_times.js).
STEP_REPEATS = 150 // HEARTBEAT_MS

KEYS = {"ArrowUp": "forward", "ArrowLeft": "left", "ArrowRight": "right"}


def choose_step(driver):
    driver.page.locator("#mode").click()
    assert driver.data("mode") == "step"
    driver.forget()


def test_heartbeats_prove_when_they_were_said(driver):
    driver.advance(600)
    driver.forget()
    driver.advance(1000)
    beats = driver.received("hb")
    assert len(beats) in (9, 10, 11)
    said_ms = [beat["token"] + beat["since"] for beat in beats]
    assert {b - a for a, b in pairwise(said_ms)} == {100}, beats
    assert max(beat["since"] for beat in beats) <= 500
    assert driver.host.now_ms - said_ms[-1] <= 150


def test_the_token_that_was_delayed_least_is_used(driver):
    """A token that is 80 ms late is worth less than the one before it plus the ms since."""
    driver.advance(600)
    driver.state()
    driver.forget()
    prompt = driver.host.token
    driver.run_for(200)
    driver.host.now_ms -= 80
    driver.state()
    driver.host.now_ms += 80
    driver.page.keyboard.press("ArrowUp")
    assert {m["token"]: m["since"] for m in driver.received("cmd")} == {prompt: 200}


def test_a_newcomer_drives_with_the_mouse_by_press_and_hold(driver):
    driver.look("forward")
    driver.page.mouse.down()
    first = driver.received("cmd")[0]  # before any time passed
    intent = {"verb": "forward", "mode": "continuous", "edge": 1}
    assert first.items() >= {"k": "cmd", **intent}.items()
    driver.advance(1000)
    assert len(driver.received("cmd")) - 1000 // HEARTBEAT_MS in (0, 1)
    driver.page.mouse.up()
    assert driver.newest()["k"] == "stop"
    driver.forget()
    driver.advance(1500, look="forward")
    assert driver.received("cmd") == []


def test_hovering_drives_after_the_dwell_and_leaving_stops(driver):
    driver.hover("forward")
    driver.advance(500, look="forward")
    assert driver.newest()["verb"] == "forward"
    driver.advance(100, look=(0.5, 0.6))
    assert driver.newest()["k"] == "cmd"  # a blink's length is forgiven
    driver.advance(150, look=(0.5, 0.6))
    assert driver.newest()["k"] == "stop"


def test_a_frozen_pointer_stops(driver):
    driver.hover("left")
    assert driver.newest()["verb"] == "left"
    driver.advance(300)
    driver.forget()
    driver.advance(400)
    assert [message["k"] for message in driver.received("cmd", "stop")] == ["stop"]


def test_a_pointer_event_at_the_same_place_is_no_proof(driver):
    driver.hover("left")
    x, y = driver.spot("left")
    driver.forget()
    for _ in range(8):
        driver.page.mouse.move(x, y)
        driver.advance(100)
    assert driver.newest()["k"] == "stop"


def test_a_step_is_one_edge_until_the_gaze_left_and_returned(driver):
    choose_step(driver)
    driver.hover("left")
    driver.advance(2000, look="left")
    steps = driver.received("cmd", "stop")
    assert {(m["verb"], m["mode"], m["edge"]) for m in steps} == {("left", "step", 1)}
    assert len(steps) == STEP_REPEATS
    driver.hover("left")
    driver.advance(200, look="left")
    assert [m["edge"] for m in driver.received("cmd", "stop")] == sorted([1, 2] * STEP_REPEATS)


def test_a_touch_drives_while_it_lasts_and_a_step_survives_its_end(chromium, page, driver):
    session = page.context.new_cdp_session(page)

    def touch(kind, points):
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    x, y = driver.spot("right")
    touch("touchStart", [{"x": x, "y": y}])
    driver.advance(500)
    assert driver.newest()["verb"] == "right"
    touch("touchEnd", [])
    assert driver.newest()["k"] == "stop"
    choose_step(driver)
    touch("touchStart", [{"x": x, "y": y}])
    touch("touchEnd", [])
    driver.advance(300)
    assert [m["k"] for m in driver.received("cmd", "stop")] == ["cmd"]


def test_a_step_that_a_stylus_taps_survives_its_lifting_off(driver):
    choose_step(driver)
    stylus = Stylus(driver)
    stylus.tap("left")
    driver.advance(500)
    assert {m["k"] for m in driver.received("cmd", "stop")} == {"cmd"}


def test_what_a_stylus_over_the_page_holds_ends_when_it_leaves(driver):
    driver.hover("forward")
    driver.advance(100, look="forward")
    driver.forget()
    Stylus(driver).leave()
    assert driver.newest()["k"] == "stop"


@pytest.mark.parametrize("mode", ["continuous", "step"])
def test_a_stylus_that_leaves_while_it_dwells_chooses_nothing(driver, mode):
    if mode == "step":
        choose_step(driver)
    driver.advance(350, look=(0.5, 0.6))
    driver.advance(500, look="forward")
    Stylus(driver).leave()
    driver.advance(300)
    assert driver.received("cmd") == []
    driver.hover("forward")
    assert driver.newest()["verb"] == "forward"


def test_a_stylus_that_leaves_while_it_dwells_presses_no_button(driver):
    driver.state(**OFF)
    driver.advance(950, look="arm")
    Stylus(driver).leave()
    driver.advance(300)
    assert driver.received("arm") == []


def test_an_arrow_key_drives_while_held(driver):
    for edge, (key, verb) in enumerate(KEYS.items(), start=1):
        driver.forget()
        driver.page.keyboard.down(key)
        driver.page.keyboard.down(key)  # the keyboard's own repeat is no new press
        driver.advance(400)
        driver.page.keyboard.up(key)
        sent = driver.received("cmd", "stop")
        assert {(m["verb"], m["edge"]) for m in sent[:-1]} == {(verb, edge)}
        assert len(sent) - 1 - 400 // HEARTBEAT_MS in (0, 1)
        assert driver.newest()["k"] == "stop"


def test_a_key_of_the_keypad_that_comes_up_as_a_digit_stops(driver):
    driver.keyed("keydown", "ArrowUp", "Numpad8")
    driver.advance(200)
    assert driver.newest()["verb"] == "forward"
    driver.keyed("keyup", "8", "Numpad8")
    assert driver.newest()["k"] == "stop"
    driver.forget()
    driver.advance(500)
    assert driver.received("cmd") == []


def test_cmd_ends_what_a_key_holds(driver):
    driver.page.keyboard.down("ArrowUp")
    driver.advance(200)
    driver.page.keyboard.down("Meta")  # macOS reports no release from now on
    assert driver.newest()["k"] == "stop"
    driver.forget()
    driver.page.keyboard.up("Meta")
    driver.page.keyboard.down("ArrowUp")  # the key repeats
    driver.advance(500)
    assert driver.received("cmd") == []


def test_space_stops_and_enter_arms(driver):
    driver.page.keyboard.press(" ")
    assert driver.newest()["k"] == "stop"
    driver.state(state="disarmed")
    driver.advance(500)
    driver.page.keyboard.press("Enter")
    assert [set(message) for message in driver.received("arm")] == [{"k", "token", "since"}]


def test_backward_exists_only_when_the_host_says_so(driver, host):
    assert not driver.page.locator("#backward").is_visible()
    driver.page.keyboard.press("ArrowDown")
    assert driver.received("cmd") == []
    host.welcome["backward"] = True
    driver.run_for(100)
    driver.open()
    assert driver.page.locator("#backward").is_visible()
    driver.page.keyboard.press("ArrowDown")
    assert driver.received("cmd")[0]["verb"] == "backward"


def test_stop_acts_on_entry_of_the_pointer(driver):
    driver.hover("forward")
    driver.forget()
    driver.look("stop")
    assert [m["k"] for m in driver.received("cmd", "stop")] == ["stop"]


def test_stop_under_a_pressed_pointer_and_by_a_click(driver):
    driver.look("stop")
    driver.forget()
    driver.page.mouse.down()
    driver.page.mouse.up()
    assert len(driver.received("stop")) == 1


def test_arming_by_dwell_by_click_and_back(driver):
    driver.state(state="disarmed", you=False, owner="nobody")
    assert driver.text("#arm-label") == "Rijden aan"
    driver.advance(975, look="arm")
    assert driver.received("arm") == []
    driver.advance(1500, look="arm")
    assert len(driver.received("arm")) == 1
    driver.state(state="armed", you=True, owner="driver")
    assert driver.text("#arm-label") == "Rijden uit"
    driver.advance(500)
    driver.page.mouse.down()
    driver.page.mouse.up()
    assert len(driver.received("disarm")) == 1


def test_a_double_tap_on_rijden_uit_is_one_and_so_is_one_on_rijden_aan(driver):
    for label, news in (("disarm", OFF), ("arm", ON)):
        driver.advance(500)
        driver.forget()
        driver.page.locator("#arm").click()
        driver.state(**news)
        driver.advance(200)
        driver.page.locator("#arm").click()
        assert {m["k"] for m in driver.received("arm", "disarm")} == {label}
        assert len(driver.received("arm", "disarm")) == 1


@pytest.mark.parametrize("by", ["gaze", "press"])
def test_what_began_before_driving_went_off_does_not_switch_it_on(driver, by):
    driver.advance(500, look="arm")
    if by == "press":
        driver.page.mouse.down()
        driver.run_for(25)
    driver.state(**OFF)
    driver.advance(1500, look="arm" if by == "gaze" else None)
    if by == "press":
        driver.page.mouse.up()
    assert driver.received("arm", "disarm") == []
    driver.advance(300, look=(0.5, 0.66))
    driver.advance(1100, look="arm")
    assert len(driver.received("arm")) == 1


def test_the_left_button_is_released_while_another_one_is_down(driver):
    mouse = driver.page.mouse
    mouse.move(*driver.spot("forward"))
    mouse.down()
    mouse.down(button="right")
    driver.advance(300)
    driver.forget()
    mouse.up()
    driver.advance(100)
    assert driver.received("stop") == [{"k": "stop"}]
    driver.forget()
    driver.advance(500)
    assert driver.received("cmd") == []
    mouse.move(*driver.spot("stop"))  # with that one down
    assert driver.received("stop") == [{"k": "stop"}]
    mouse.up(button="right")


def test_gaze_commands_nothing_while_disarmed_or_when_another_drives(driver):
    driver.state(state="disarmed", you=False, owner="nobody")
    driver.hover("forward")
    driver.state(state="armed", you=False, owner="caretaker")
    driver.hover("forward")
    assert driver.received("cmd") == []
    assert "begeleider" in driver.text("#owner")


def test_losing_the_armed_state_ends_a_hold_for_good(driver):
    driver.hover("forward")
    driver.state(state="disarmed")
    driver.state(state="armed")
    driver.forget()
    driver.advance(2000, look="forward")
    assert driver.received("cmd") == []


def test_assistive_clicks_without_a_pointer_work(driver):
    driver.page.evaluate("document.getElementById('stop').click()")
    assert driver.newest()["k"] == "stop"
    driver.state(state="disarmed")
    driver.advance(500)
    driver.page.evaluate("document.getElementById('arm').click()")
    assert len(driver.received("arm")) == 1


def test_an_entered_target_holds_the_gaze_a_little_longer(driver):
    box = driver.page.locator("#left").bounding_box()
    beside = ((box["x"] + box["width"] * 1.08) / 1920, (box["y"] + box["height"] / 2) / 1080)
    driver.advance(350, look=(0.5, 0.6))
    driver.advance(1000, look=beside)
    assert driver.received("cmd") == []
    driver.hover("left")
    driver.advance(600, look=beside)
    assert driver.newest()["k"] == "cmd"
