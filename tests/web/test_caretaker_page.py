"""The caretaker's page on a phone: see, stop, take over, bypass, cap; and the viewer's."""

from itertools import pairwise

import pytest

from gazechair.base.languages import message
from gazechair.driving.control import HEARTBEAT_MS
from pagelooks import CUT_OFF
from patience import wait_until
from pluginrows import lost, mode, offer
from webperson import CARETAKER, Driver

pytestmark = pytest.mark.browser


@pytest.fixture
def driving(caretaker):
    """The caretaker has taken over."""
    caretaker.state(you=True, owner="caretaker", state="armed")
    return caretaker


def pad(caretaker, right, forward):
    """A place on the joystick, -1..1 each (px)."""
    caretaker.page.locator("#pad").scroll_into_view_if_needed()
    box = caretaker.page.locator("#pad").bounding_box()
    x = box["x"] + box["width"] * (1 + right) / 2
    return x, box["y"] + box["height"] * (1 - forward) / 2


def test_stop_is_said_when_the_finger_touches(caretaker):
    x, y = caretaker.spot("stop")
    caretaker.forget()
    caretaker.page.mouse.move(x, y)
    caretaker.page.mouse.down()
    assert caretaker.received("stop")


def test_stop_by_key(caretaker):
    for key in (" ", "Escape"):
        caretaker.forget()
        caretaker.page.keyboard.press(key)
        assert caretaker.received("stop") == [{"k": "stop"}], key


def test_emergency_at_once_and_reset_by_holding_two_seconds(caretaker):
    caretaker.page.locator("#emergency").click()
    assert caretaker.received("emergency")[0] == {"k": "emergency"}
    assert not caretaker.page.locator("#reset").is_visible()
    caretaker.state(level="error", message="emergency", state="disarmed")
    caretaker.page.locator("#reset").scroll_into_view_if_needed()
    x, y = caretaker.spot("reset")
    caretaker.page.mouse.move(x, y)
    caretaker.page.mouse.down()
    caretaker.advance(1900)
    assert caretaker.received("reset") == []
    caretaker.advance(200)
    caretaker.page.mouse.up()
    caretaker.advance(3000)
    assert [set(message) for message in caretaker.received("reset")] == [{"k", "token", "since"}]


def test_take_over_and_hand_back(caretaker):
    assert caretaker.text("#take") == "Overnemen"
    caretaker.page.locator("#take").click()
    assert [set(message) for message in caretaker.received("take")] == [{"k", "token", "since"}]
    caretaker.state(you=True, owner="caretaker")
    assert caretaker.text("#take") == "Teruggeven"
    caretaker.advance(500)
    caretaker.page.locator("#take").click()
    assert caretaker.received("release") == [{"k": "release"}]


def test_a_double_tap_on_teruggeven_takes_nothing_over(driving):
    driving.advance(500)
    driving.page.locator("#take").click()
    driving.state(you=False, owner="nobody", state="disarmed")
    driving.advance(200)
    driving.page.locator("#take").click()
    assert driving.received("release", "take") == [{"k": "release"}]


def test_a_reset_that_is_held_ends_when_something_else_is_shown(caretaker):
    caretaker.state(level="error", message="wiper", state="disarmed")
    caretaker.page.locator("#reset").scroll_into_view_if_needed()
    caretaker.page.mouse.move(*caretaker.spot("reset"))
    caretaker.page.mouse.down()
    caretaker.advance(1500)
    caretaker.state(message="emergency")
    caretaker.advance(3000)
    caretaker.page.mouse.up()
    assert caretaker.received("reset") == []


def test_a_phone_put_away_gives_back_over_a_link_that_only_seems_lost(driving):
    driving.run_for(600)
    assert driving.data("link") == "lost"
    driving.page.evaluate("dispatchEvent(new Event('blur'))")
    assert driving.received("release") == [{"k": "release"}]


@pytest.mark.parametrize("event", ["blur", "pagehide"])
def test_a_phone_put_away_before_it_has_taken_over_gives_back(caretaker, event):
    caretaker.page.locator("#take").click()
    caretaker.page.evaluate(f"dispatchEvent(new Event('{event}'))")
    assert caretaker.received("release") == []
    caretaker.state(you=True, owner="caretaker")
    assert caretaker.received("release") == [{"k": "release"}]
    caretaker.state(you=False, owner="nobody", state="disarmed")
    caretaker.advance(500)
    caretaker.forget()
    caretaker.page.locator("#take").click()
    caretaker.state(you=True, owner="caretaker", state="armed")
    caretaker.advance(500)
    assert [m["k"] for m in caretaker.received("take", "release")] == ["take"]


def test_the_joystick_drives_in_proportion_while_touched_and_springs_back(driving):
    driving.page.mouse.move(*pad(driving, 0, 0))
    driving.page.mouse.down()
    assert driving.received("drive")[0].items() >= {"linear": 0, "turn": 0, "edge": 1}.items()
    driving.page.mouse.move(*pad(driving, 0, 0.55))
    driving.advance(100)
    ahead = driving.received("drive")[-1]
    assert (ahead["linear"], ahead["turn"], ahead["edge"]) == (pytest.approx(500, abs=15), 0, 1)
    driving.page.mouse.move(*pad(driving, -3, 0))
    driving.advance(100)
    left = driving.received("drive")[-1]
    assert (left["linear"], left["turn"]) == (pytest.approx(0, abs=10), pytest.approx(1000, abs=10))
    driving.page.mouse.up()
    assert driving.received("drive", "stop")[-1] == {"k": "stop"}
    driving.forget()
    driving.advance(500)
    assert driving.received("drive") == []


def test_the_joystick_says_so_every_heartbeat_with_a_fresh_proof(driving):
    driving.page.mouse.move(*pad(driving, 0, 0.5))
    driving.page.mouse.down()
    driving.advance(1000)
    sent = driving.received("drive")
    assert len(sent) - 1000 // HEARTBEAT_MS in (0, 1)
    proofs = [message["token"] + message["since"] for message in sent]
    assert all(b > a for a, b in pairwise(proofs))


def test_every_grab_is_a_new_press(driving):
    for _ in range(3):
        driving.page.mouse.move(*pad(driving, 0, 0.5))
        driving.page.mouse.down()
        driving.page.mouse.up()
    assert sorted({message["edge"] for message in driving.received("drive")}) == [1, 2, 3]


def test_the_joystick_is_dead_until_taken_over_and_when_driving_goes_off(caretaker):
    caretaker.page.mouse.move(*pad(caretaker, 0, 0.5))
    caretaker.page.mouse.down()
    caretaker.page.mouse.up()
    assert caretaker.received("drive") == []
    caretaker.state(you=True, owner="caretaker")
    caretaker.page.mouse.down()
    assert caretaker.received("drive")
    caretaker.state(state="disarmed")
    caretaker.advance(50)
    caretaker.forget()
    caretaker.state(state="armed")
    caretaker.advance(500)
    assert caretaker.received("drive") == []


def test_arrow_keys_drive_together_while_held(driving):
    driving.page.keyboard.down("ArrowUp")
    driving.page.keyboard.down("ArrowLeft")
    driving.advance(100)
    both = driving.received("drive")[-1]
    assert (both["linear"], both["turn"], both["edge"]) == (500, 500, 1)
    driving.page.keyboard.up("ArrowUp")
    driving.advance(100)
    assert driving.received("drive")[-1].items() >= {"linear": 0, "turn": 500, "edge": 1}.items()
    driving.page.keyboard.up("ArrowLeft")
    assert driving.received("drive", "stop")[-1] == {"k": "stop"}


@pytest.mark.parametrize("event", ["blur", "pagehide"])
def test_putting_the_phone_away_stops_and_gives_back(driving, event):
    driving.page.keyboard.down("ArrowUp")
    driving.forget()
    driving.page.evaluate(f"dispatchEvent(new Event('{event}'))")
    assert [message["k"] for message in driving.received("drive", "stop", "release")] == [
        "stop",
        "release",
    ]
    driving.advance(500)
    assert driving.received("drive") == []


def test_bypass_while_held_with_what_is_left(caretaker):
    caretaker.page.locator("#bypass").scroll_into_view_if_needed()
    x, y = caretaker.spot("bypass")
    caretaker.page.mouse.move(x, y)
    caretaker.page.mouse.down()
    caretaker.state(bypass_ms=19_400)
    caretaker.advance(200)
    assert "20 s" in caretaker.text("#bypass")
    caretaker.page.mouse.up()
    sent = caretaker.received("bypass")
    assert {message["held"] for message in sent[:-1]} == {True}
    assert {message["edge"] for message in sent[:-1]} == {1}
    assert sent[-1] == {"k": "bypass", "held": False}


def test_a_chair_that_drives_itself_is_watched_while_the_button_is_held(caretaker):
    button = caretaker.page.locator("#watch")
    assert not button.is_visible()
    caretaker.state(auto=["go", ""])
    assert "rijdt zelf" in button.text_content()
    button.scroll_into_view_if_needed()
    caretaker.page.mouse.move(*caretaker.spot("watch"))
    caretaker.page.mouse.down()
    caretaker.advance(300)
    sent = caretaker.received("watch")
    assert len(sent) >= 4
    assert all("token" in message for message in sent)
    caretaker.state(auto=["", "go"])
    assert not button.is_visible()
    caretaker.forget()
    caretaker.advance(300)
    assert caretaker.received("watch") == []
    caretaker.page.mouse.up()


def test_the_cap_is_told_and_shown(caretaker):
    slider = caretaker.page.locator("#cap")
    assert caretaker.text("#cap-word") == "geen grens"
    slider.fill("600")
    assert caretaker.received("cap") == [{"k": "cap", "permille": 600}]
    caretaker.state(cap_permille=600)
    assert caretaker.text("#cap-word") == "60 %"


def test_a_call_for_help_is_heard_felt_and_answered(caretaker, artefact):
    caretaker.page.evaluate(
        "() => { window.shaken = 0; navigator.vibrate = () => (shaken += 1);"
        "window.tones = 0; const start = OscillatorNode.prototype.start;"
        "OscillatorNode.prototype.start = function(t) { tones += 1; start.call(this, t); } }"
    )
    # A press before the sound began counts as a touch of the page: it sounds already.
    if caretaker.data("audible") == "false":
        caretaker.page.locator("#sound").click()
    wait_until(lambda: not caretaker.page.locator("#sound").is_visible(), "sound to be on")
    caretaker.state(call=True)
    caretaker.advance(4500)
    assert caretaker.page.evaluate("shaken") >= 2
    assert caretaker.page.evaluate("tones") >= 8
    assert "vraagt hulp" in caretaker.text("#call")
    artefact("caretaker-call")
    caretaker.page.locator("#answer").click()
    assert caretaker.received("call") == [{"k": "call", "on": False, "there": False}]
    before = caretaker.page.evaluate("shaken")
    caretaker.advance(5000)  # seen: silent, although the host still reports it
    assert caretaker.page.evaluate("shaken") == before


@pytest.mark.parametrize(
    "news", [{"level": "error", "message": "board_lost"}, None], ids=["an error", "a lost link"]
)
def test_trouble_is_felt(caretaker, news):
    caretaker.page.evaluate("() => { window.shaken = 0; navigator.vibrate = () => (shaken += 1); }")
    if news:
        caretaker.state(**news)
        caretaker.advance(100)
    else:
        caretaker.run_for(2200)
    assert caretaker.page.evaluate("shaken") == 1


def test_what_only_the_caretaker_needs_to_know_has_words(caretaker):
    caretaker.state(level="warning", message="log_full")
    caretaker.advance(100)
    text, do = message("nl", "log_full")
    corner = caretaker.page.text_content("#status")
    assert text in corner
    assert do in corner


def test_a_viewer_has_no_controls(page, host, artefact):
    page.set_viewport_size({"width": 390, "height": 844})
    host.welcome["role"] = "viewer"
    host.state.update(you=False)
    viewer = Driver(page, host)
    viewer.open("caretaker")
    assert page.locator("button:visible:not(#sound)").count() == 0
    assert page.locator("#sound").is_visible() == (viewer.data("audible") == "false")
    assert viewer.page.locator(".watching").is_visible()
    viewer.page.keyboard.press("ArrowUp")
    assert viewer.received("drive", "stop") == []
    artefact("caretaker-viewer")


def test_inputs_and_modes_are_listed_with_how_they_are(caretaker, artefact):
    pad = {**mode("gamepad"), "kind": "input", "state": "degraded", "reason": "plugin_trouble"}
    pad["detail"] = "no gamepad: none is plugged in"
    raised = lost(mode("home"), "plugin_raised", again=caretaker.host.token + 9000)
    hostile = mode("odd", names={"nl": "<b>" + "x" * 200}, icon="<i>", detail="y" * 200)
    offer(caretaker.host, pad, mode("ahead"), raised, hostile)
    caretaker.state()
    caretaker.page.locator("#tab-modules").click()
    rows = caretaker.page.locator("#plugins li")
    wait_until(lambda: rows.count() == 4, "the list")
    texts = rows.all_inner_texts()
    assert "invoer" in texts[0]
    assert "meldt een probleem" in texts[0]
    assert "no gamepad: none is plugged in" in texts[0]
    assert "rijwijze" in texts[1]
    assert "werkt" in texts[1]
    assert "heeft een fout" in texts[2]
    assert "Nieuwe poging binnen 10 s. mode home ended unexpectedly" in texts[2]
    assert "<b>xxxx" in texts[3]
    assert caretaker.page.locator("#plugins i").count() == 0
    assert caretaker.page.evaluate(CUT_OFF) == []
    assert "Home" in caretaker.text("#status")
    assert "En nog 1." in caretaker.text("#status")
    rows.nth(2).scroll_into_view_if_needed()
    artefact("caretaker-modules")
    offer(caretaker.host, mode("home"))
    caretaker.state()
    caretaker.advance(50)
    assert "werkt" in rows.all_inner_texts()[0]
    assert "Alles in orde." in caretaker.text("#status")
    offer(caretaker.host)
    caretaker.state()
    assert "Er zijn geen modules" in caretaker.text("#plugins")


def test_without_the_words_about_plug_ins_the_page_works_and_says_so(page, host):
    page.route("**/nl-plugins.json", lambda route: route.abort())
    host.welcome["role"] = "caretaker"
    host.replies.update(CARETAKER)
    offer(host, lost(mode("ahead")))
    person = Driver(page, host)
    person.open("caretaker")
    person.wait_until(
        lambda: person.advance(100) or "niet geladen" in person.text("#status"), "what is missing"
    )
    page.locator("#stop").click()
    assert person.received("stop")
    page.unroute("**/nl-plugins.json")
    person.wait_until(
        lambda: person.advance(500) or "is gestopt" in person.text("#status"), "the words"
    )


def test_the_corner_names_the_lidar_that_may_sit_askew(caretaker):
    caretaker.state(level="warning", message="lidar_turned", about="rear")
    caretaker.run_for(25)
    assert "(rear)" in caretaker.text("#status")
    caretaker.state(about="")
    caretaker.run_for(25)
    assert "scheef" in caretaker.text("#status")
    assert "(" not in caretaker.text("#status")
