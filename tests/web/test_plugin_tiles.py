"""Tiles of plug-in modes, in a real Chromium: held and released like a direction."""

import pytest

from fakehost import OFF
from fingers import Fingers, Stylus
from pluginrows import WELL
from plugintiles import (
    AHEAD,
    HELD,
    HOME,
    TWENTY,
    begin,
    end,
    more,
    moves,
    shown,
    tiled,
)
from webperson import Driver
from webscanner import opened

pytestmark = pytest.mark.browser


# Nothing without plug-ins


def test_without_plug_ins_nothing_is_fetched_and_nothing_is_there(page, host):
    requested = []
    page.on("request", lambda request: requested.append(request.url))
    person = Driver(page, host)
    person.open()
    person.advance(500)
    assert [url for url in requested if "plugin" in url or "menu.js" in url] == []
    assert page.locator(".plugin").count() == 0


# Held and let go


def test_a_mode_is_held_with_fresh_tokens_and_let_go_as_soon_as_vooruit_is(ride):
    for by in ("gaze", "touch", "mouse", "key"):
        check_held(ride, by)


def check_held(ride, by):
    """Both are held in this way, and let go."""
    took = {}
    for target, kind in (("forward", "cmd"), ("plugin-0", "mode")):
        ride.advance(400, look=(0.5, 0.55))
        ride.forget()
        begin(ride, target, by)
        ride.advance(500, look=target if by == "gaze" else None)
        sent = ride.received("cmd", "mode")
        assert {m["k"] for m in sent} == {kind}
        assert len({m["edge"] for m in sent}) == 1
        assert len(sent) >= 10
        assert all(m["since"] <= 500 for m in sent)
        if kind == "mode":
            assert {m["mode"] for m in sent} == {"ahead"}
        assert ride.page.evaluate(HELD) == target
        ride.forget()
        end(ride, by)
        began = ride.host.now_ms
        while not ride.received("stop"):
            ride.advance(25, look=(0.5, 0.55) if by == "gaze" else None)
            assert ride.host.now_ms - began < 1000
        took[target] = ride.host.now_ms - began
        assert ride.page.evaluate(HELD) is None
    assert took["plugin-0"] == took["forward"] <= 225


@pytest.mark.parametrize("how", ["blur", "pagehide"])
def test_a_page_without_its_person_lets_a_mode_go(ride, how):
    begin(ride, "plugin-0", "touch")
    ride.advance(100)
    ride.forget()
    ride.page.evaluate(f"dispatchEvent(new Event('{how}'))")
    assert ride.received("mode", "stop", "disarm") == [{"k": "stop"}, {"k": "disarm"}]


def test_a_frozen_pointer_and_a_lost_link_let_it_go(ride):
    ride.hover("plugin-0")
    ride.forget()
    ride.advance(600)
    assert moves(ride)[-1] == ("stop", None, None)
    begin(ride, "plugin-0", "touch")
    ride.advance(100)
    ride.run_for(700)
    assert moves(ride)[-1] == ("stop", None, None)
    ride.state()
    ride.advance(500)
    assert moves(ride) == []


def test_in_step_mode_a_mode_is_held_all_the_same(ride):
    ride.page.locator("#mode").click()
    assert ride.data("mode") == "step"
    ride.hover("plugin-0")
    ride.advance(600, look="plugin-0")
    assert len(ride.received("mode")) > 10
    ride.forget()
    ride.advance(300, look=(0.5, 0.55))
    assert moves(ride) == [("stop", None, None)]


def test_one_look_starts_what_nobody_holds_and_eyes_on_the_page_watch_it(ride):
    tiled(ride, {**AHEAD, "auto": True})
    ride.state(state="armed", you=True, owner="driver")
    begin(ride, "plugin-0", "gaze")
    ride.advance(400, look="plugin-0")
    sent = ride.received("mode", "watch")
    assert {m["k"] for m in sent} == {"mode"}
    assert len({m["edge"] for m in sent}) == 1
    ride.state(auto=["ahead", ""])
    assert ride.text("#plugin-0 .small") == "rijdt zelf"
    # The eyes leave the tile: nothing is stopped, and they watch while they move on the page.
    for k in range(20):
        ride.advance(50, look=(0.5 + k % 2 / 50, 0.55))
    assert ride.received("stop") == []
    assert 2 <= len(ride.received("watch")) <= 6
    ride.forget()
    ride.advance(1000)  # they are nowhere
    assert ride.received("watch", "stop") == []
    # Any tile ends it; after an end before its goal the tile continues it.
    ride.page.locator("#mode").click()
    assert ride.received("stop") == [{"k": "stop"}]
    ride.state(auto=["", "ahead"])
    assert ride.text("#plugin-0 .label") == "Verder"
    ride.state(auto=["", ""])
    assert ride.text("#plugin-0 .label") == "Ahead"


def test_looking_from_a_mode_at_a_direction_and_back_steers_as_from_a_direction(ride):
    sent = {}
    for target in ("forward", "plugin-0"):
        ride.forget()
        ride.hover(target)
        ride.advance(300, look="left")
        ride.advance(300, look=target)
        sent[target] = [kind for kind, *_ in moves(ride)]
        ride.advance(500, look=(0.5, 0.55))
    assert sent["plugin-0"].count("mode") == sent["forward"].count("cmd") - 1 == 2
    turned = [kind.replace("mode", "cmd") for kind in sent["plugin-0"]]
    assert turned == sent["forward"]


@pytest.mark.parametrize(("first", "second"), [("forward", "plugin-0"), ("plugin-0", "forward")])
def test_of_two_fingers_the_newest_counts_and_lifting_it_stops(ride, first, second):
    fingers = Fingers(ride)
    fingers.put(1, first)
    ride.advance(300)
    fingers.put(2, second)
    ride.advance(300)
    names = {"forward": ("cmd", "forward"), "plugin-0": ("mode", "ahead")}
    assert moves(ride) == [(*names[first], 1), (*names[second], 2)]
    fingers.lift(2)
    ride.advance(500)
    assert moves(ride) == [("stop", None, None)]
    fingers.lift(1)
    ride.advance(500)
    assert moves(ride) == []


def test_stop_under_a_second_finger_ends_it_for_good(ride):
    fingers = Fingers(ride)
    fingers.put(1, "plugin-0")
    ride.advance(300)
    ride.forget()
    fingers.put(2, "stop")
    ride.advance(1000)
    assert moves(ride) == [("stop", None, None)]


def test_nothing_is_held_before_driving_is_on(ride):
    ride.state(**OFF)
    ride.advance(100)
    assert "plugin-0" not in shown(ride)
    assert "help" in shown(ride)
    ride.page.keyboard.press("Enter")
    assert ride.received("mode") == []


@pytest.mark.parametrize("backward", [False, True], ids=["", "backward"])
def test_while_somebody_else_drives_hulp_is_there_and_is_pressed(driver, backward):
    driver.host.welcome["backward"] = backward
    tiled(driver, *TWENTY[:5])
    for page in ("directions", "modes"):
        if page == "modes":
            more(driver)
        assert "help" not in shown(driver)
        driver.state(you=False, owner="caretaker")
        driver.advance(50)
        assert "help" in shown(driver)
        assert not {"plugin-0", "backward", "next"} & set(shown(driver))
        driver.forget()
        x, y = driver.spot("help")
        driver.page.mouse.click(x, y)
        assert driver.received("call")
        driver.state(you=True, owner="driver")
        driver.advance(50)


def test_practice_counts_it_and_sends_nothing(ride):
    ride.state(**OFF)
    ride.page.locator("#menu").click()
    ride.page.locator("#tile-1").click()
    ride.advance(500)
    ride.page.locator("#arm").click()
    begin(ride, "plugin-0", "mouse")
    ride.advance(300)
    assert ride.received("mode", "cmd") == []
    assert "ahead 1" in ride.text("#score")
    ride.page.mouse.up()


def test_it_is_reached_by_scanning_with_one_switch(page, host):
    scanner = opened(page, host)
    tiled(scanner, AHEAD, HOME)
    scanner.wait_for("forward", "left", "right")
    scanner.wait_for("plugin-0")  # alone in its row: one press takes it
    scanner.forget()
    scanner.down()
    scanner.advance(1000)
    assert len(scanner.received("mode")) >= 18
    scanner.up()
    scanner.advance(75)
    assert moves(scanner) == [("mode", "ahead", 1), ("stop", None, None)]
    more(scanner)
    scanner.wait_for("plugin-1", "plugin-2")


def test_who_is_followed_has_a_tile_and_sentences_of_its_own(ride):
    row = {"kind": "place", "name": "follow-person", "sign": "person", **WELL}
    names = {"nl": "Volg persoon", "en": "Follow person"}
    tiled(ride, AHEAD, {**row, "names": names})
    more(ride)
    assert ride.text("#plugin-2 .label") == "Volg persoon"
    assert ride.page.locator("#plugin-2 .sign").bounding_box()["height"] > 20
    assert ride.page.locator("#plugin-2 text").text_content() == ""
    news = {"kind": "person", "mode": "follow-person", "name": "Volg persoon", "goal": {}}
    ride.state(going={**news, "state": "waits", "reason": "person_choosing"})
    assert "Wacht tot er iemand voor de stoel stilstaat." in ride.text("#status")
    ride.state(going={**news, "state": "ended", "reason": "going_stopped"})
    assert "Gestopt met volgen." in ride.text("#status")


def test_a_places_name_is_shown_as_its_people_wrote_it(ride):
    row = {"kind": "place", "name": "to-1", "sign": "bed", **WELL}
    tiled(ride, AHEAD, {**row, "names": {"nl": "$& of $1", "en": "$& of $1"}})
    more(ride)
    news = {"kind": "place", "mode": "to-1", "name": "$& of $1", "goal": {}}
    ride.state(going={**news, "state": "thinks", "reason": ""})
    assert "$& of $1" in ride.text("#status")
    assert "{name}" not in ride.text("#status")


def auto_ride(person):
    """The tile is that of an auto mode, and the chair is armed."""
    tiled(person, {**AHEAD, "auto": True})
    person.state(state="armed", you=True, owner="driver")


def test_a_pointer_that_stands_still_watches_nothing(ride):
    auto_ride(ride)
    ride.state(auto=["ahead", ""])
    ride.forget()
    for _ in range(8):
        ride.page.evaluate(
            "dispatchEvent(new PointerEvent('pointermove', {clientX: 700, clientY: 500}))"
        )
        ride.advance(300)
    assert len(ride.received("watch")) == 1


def test_a_short_press_of_a_tile_that_nobody_holds_is_no_tap(ride):
    auto_ride(ride)
    for _ in range(3):
        ride.advance(2000)
        ride.page.mouse.click(*ride.spot("plugin-0"))
    assert len({m["edge"] for m in ride.received("mode")}) == 3
    assert ride.data("mode") == "continuous"
    assert not ride.page.locator("#banner").is_visible()


def test_a_stylus_starts_what_nobody_holds_and_lifting_it_off_stops_nothing(ride):
    auto_ride(ride)
    Stylus(ride).tap("plugin-0")
    ride.state(auto=["ahead", ""])
    ride.advance(500)
    assert {m["k"] for m in ride.received("mode", "stop")} == {"mode"}


def test_a_stylus_that_leaves_while_it_dwells_starts_no_ride(ride):
    auto_ride(ride)
    ride.advance(350, look=(0.5, 0.55))
    ride.advance(500, look="plugin-0")
    Stylus(ride).leave()
    ride.advance(300)
    assert ride.received("mode") == []
