"""The first drive on a phone: steps with their facts, a held button, a procedure's questions."""

import pytest

from layoutshift import WATCH, take
from patience import wait_until

pytestmark = pytest.mark.browser

RUN = {"step": "", "lines": [], "pulses": 0, "straight": 0, "asks": "", "ended": None}
ROWS = [
    {"step": "versions", "done": True, "refused": "", "host": "0.2.0", "board": "teensy 0.2.0"},
    {"step": "mask", "done": False, "refused": "lidar_lost", "arcs": [[[123.0, -123.0]]]},
    {"step": "distance", "done": False, "refused": "", "seen_mm": 1500, "found": None},
    {"step": "neutral", "done": False, "refused": "", "counts": [170, 172]},
    {
        "step": "heading",
        "done": False,
        "refused": "",
        "gyro": 3,
        "accelerometer": 1,
        "degrees": None,
    },
    {"step": "profile", "done": False, "refused": "", "profile": "3.1", "choices": ["1.2", "3.1"]},
    {"step": "relay", "done": False, "refused": "emergency"},
    {"step": "tune", "done": False, "refused": "", "profile": "3.1"},
    {"step": "turn", "done": False, "refused": "", "turned_deg": [7.04, -9.8], "wanted_deg": 10.0},
    {"step": "person", "done": False, "refused": "", "name": ""},
    {"step": "practice", "done": False, "refused": ""},
]


def test_a_caretaker_is_led_from_step_to_step(caretaker):
    host, page = caretaker.host, caretaker.page

    def now(**run):
        """Set the host's answer from now on, and wait until the page has shown it."""
        answer = (200, {"steps": ROWS, "run": {**RUN, **run}})
        host.replies |= {"GET /first-drive": answer, "POST /first-drive": answer}
        for _ in range(3):
            caretaker.advance(600)
            caretaker.answered()

    def text_of(name: str) -> str:
        return page.locator(f".first li[data-open=true] .{name}").inner_text()

    def opened(number: int) -> None:
        page.locator(f".first li:nth-child({number}) .head").click()

    now()
    page.locator("#tab-settings").click()
    page.locator("#tab-first").click()
    caretaker.wait_until(lambda: caretaker.advance(600) or page.locator(".first li").count(), "it")
    assert page.locator(".first li").count() == len(ROWS)
    assert page.locator(".first li[data-done=true]").count() == 1
    # The first step that is not done is open, and shows what prevents it.
    assert "Wat de lidar van de stoel ziet" in text_of("head")
    assert text_of("fact") == "Verborgen: 123..-123°."
    assert "obstakelsensor" in text_of("status-text")

    opened(9)
    assert text_of("fact") == "Gedraaid: links 7,0 van 10 graden, rechts 9,8 van 10."
    opened(5)
    assert "richting nog niet bekend°" in text_of("fact")

    # Tuning: held, repeated with a fresh token, ended by letting go.
    opened(8)
    caretaker.screenshot("first_drive")
    caretaker.forget()
    page.locator(".first li:nth-child(8) button.held").scroll_into_view_if_needed()
    page.locator(".first li:nth-child(8) button.held").hover()
    page.mouse.down()
    caretaker.advance(200)
    held = [m for m in caretaker.received("step") if m["held"]]
    assert len(held) >= 3
    assert {m["step"] for m in held} == {"tune"}
    assert len({m["edge"] for m in held}) == 1
    assert all("token" in m for m in held)
    page.evaluate(WATCH)
    take(page)  # opening a step moved the others
    now(step="tune", pulses=2)
    assert text_of("status-text").startswith("2 van 10")
    now(step="tune", pulses=10, straight=1)
    assert text_of("status-text").startswith("Rechtuit: 1 van 3")
    page.mouse.up()
    caretaker.run_for(50)
    assert caretaker.received("step")[-1]["held"] is False
    failed = {"step": "tune", "ok": False, "reason": "first_failed", "detail": "the chair slides"}
    now(ended=failed)
    assert text_of("status-text").endswith("the chair slides")
    now(ended={**failed, "error": "tune_little", "fields": {"deg": 3.5}})
    assert "De stoel draaide maar 3,5° per keer." in text_of("status-text")
    now(ended={**failed, "error": "board_off", "fields": {"reason": "heading_bus"}})
    assert "De richtingsensor antwoordt niet." in text_of("status-text")
    now(ended={**failed, "reason": "first_let_go"})
    assert text_of("status-text").startswith("Gestopt. Er is niets veranderd.")
    assert take(page) == [], "nothing moves by itself"

    # The joystick procedure's questions become buttons.
    opened(4)
    now(step="neutral", asks="turn")
    assert "pin 2" in text_of("status-text")
    page.locator(".first li:nth-child(4) .controls button").nth(1).click()
    plus = {"answer": "+", "asks": "turn"}
    wait_until(lambda: ("/first-drive", plus) in host.posted, "the answer")
    now()
    opened(3)
    page.locator(".first li:nth-child(3) input").fill("151")
    page.locator(".first li:nth-child(3) .controls button").click()
    run = {"run": "distance", "value": 1510}
    wait_until(lambda: ("/first-drive", run) in host.posted, "the distance")
    # A stop ends a held button, and so does leaving the page.
    opened(7)
    page.locator(".first li:nth-child(7) button.held").hover()
    page.mouse.down()
    caretaker.advance(100)
    caretaker.forget()
    page.evaluate("window.dispatchEvent(new Event('blur'))")
    assert caretaker.received("step")[-1]["held"] is False
    page.mouse.up()


def test_a_refusal_is_told_until_the_button_is_pressed_again(caretaker):
    host, page = caretaker.host, caretaker.page
    tune = {"step": "tune", "done": False, "refused": "", "profile": "3.1"}
    relay = {"step": "relay", "done": False, "refused": ""}
    failed = {"step": "tune", "ok": False, "reason": "first_let_go", "detail": ""}
    status = page.locator(".first li[data-open=true] .status-text")

    def now(refused: str = "", **run) -> str:
        """Set the host's answer from now on; returns what the page tells after three of them."""
        rows = [{**tune, "refused": refused}, relay]
        host.replies["GET /first-drive"] = 200, {"steps": rows, "run": {**RUN, **run}}
        for _ in range(3):
            caretaker.advance(600)
            caretaker.answered()
        return status.inner_text()

    def refused(reason: str) -> None:
        host.say({"k": "refused", "what": "step", "reason": reason, "detail": ""})
        caretaker.state()  # it comes after that

    page.locator("#tab-settings").click()
    page.locator("#tab-first").click()
    host.replies["GET /first-drive"] = 200, {"steps": [tune, relay], "run": RUN}
    caretaker.wait_until(lambda: caretaker.advance(600) or status.count(), "the steps")
    assert now(ended=failed).startswith("Gestopt.")
    button = page.locator(".first li[data-open=true] button.held")
    button.hover()
    page.mouse.down()
    refused("first_cap")
    assert now(ended=failed).startswith("Inmeten draait op volle snelheid")
    page.mouse.up()
    assert now(ended=failed).startswith("Inmeten draait op volle snelheid")
    page.mouse.down()
    assert now(ended=failed).startswith("Gestopt.")
    # Too late, but the next proof of the same press came in time.
    refused("stale_token")
    assert now(ended=failed).startswith("De verbinding was te traag")
    assert now(step="tune", pulses=2).startswith("2 van 10")
    page.mouse.up()
    # What the step itself tells now ends when that does.
    refused("emergency")
    stopped = now("emergency")
    assert "noodstop" in stopped.lower()
    assert now() == ""
    refused("first_busy")
    assert "al een stap" in now()
    for number in (2, 1):  # another step, and back
        page.locator(f".first li:nth-child({number}) .head").click()
    assert now() == ""


def test_a_refused_request_is_told_until_the_next_one(caretaker):
    host, page = caretaker.host, caretaker.page
    heading = next(row for row in ROWS if row["step"] == "heading")
    answer = {"steps": [heading], "run": RUN}
    host.replies |= {
        "GET /first-drive": (200, answer),
        "POST /first-drive": (409, {"reason": "first_busy", "detail": ""}),
    }
    page.locator("#tab-settings").click()
    page.locator("#tab-first").click()
    begin = page.locator(".first .controls button")
    status = page.locator(".first .status-text")
    caretaker.wait_until(lambda: caretaker.advance(600) or begin.count(), "the step")
    begin.click()
    caretaker.wait_until(lambda: "al een stap" in status.inner_text(), "why not")
    for _ in range(3):
        caretaker.advance(600)
        caretaker.answered()
        assert "al een stap" in status.inner_text()
    host.replies["POST /first-drive"] = 200, answer
    begin.click()
    caretaker.wait_until(lambda: status.inner_text() == "", "the host to take it")


def test_who_is_added_meanwhile_can_be_chosen(caretaker):
    host, page = caretaker.host, caretaker.page
    person = next(row for row in ROWS if row["step"] == "person")
    host.replies["GET /first-drive"] = (200, {"steps": [person], "run": RUN})
    page.locator("#tab-settings").click()
    page.locator("#tab-first").click()
    select = page.locator(".first select")
    offered = select.locator("option")
    caretaker.wait_until(lambda: caretaker.advance(600) or offered.count() == 1, "the step")

    def shown(*names: str) -> None:
        caretaker.wait_until(
            lambda: caretaker.advance(600) or offered.all_text_contents()[1:] == list(names), "it"
        )

    host.profiles.change({"create": "Jan"}, True)
    shown("Jan")
    select.select_option(label="Jan")
    host.profiles.change({"create": "Piet"}, True)
    shown("Jan", "Piet")
    assert select.locator("option:checked").text_content() == "Jan"
    chosen = select.input_value()
    page.locator(".first .controls button").click()
    wait_until(lambda: ("/profiles", {"choose": chosen}) in host.posted, "the choice")
