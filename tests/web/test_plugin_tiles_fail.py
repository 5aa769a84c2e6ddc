"""A plug-in's tile when its mode, or a part of the page, does not work."""

import pytest

from fakehost import OFF, picture
from patience import wait_until
from pluginrows import lost, mode, offer
from plugintiles import AHEAD, FOLLOW, HELD, HOME, begin, moves, shown, tiled
from webperson import Driver

pytestmark = pytest.mark.browser


# A mode that does not work


def test_a_mode_that_dies_while_held_ends_and_does_not_go_on_by_itself(ride):
    begin(ride, "plugin-0", "touch")
    ride.advance(300)
    ride.forget()
    offer(ride.host, lost(AHEAD))
    ride.advance(50)
    assert moves(ride)[-1] == ("stop", None, None)
    assert ride.page.evaluate(HELD) is None
    assert "is gestopt" in ride.text("#plugin-0")
    ride.advance(500)
    offer(ride.host, AHEAD)
    ride.advance(2000)
    assert moves(ride) == []  # the finger never left
    assert ride.text("#plugin-0 .small") == ""
    ride.fingers.lift(1)
    begin(ride, "plugin-0", "touch")
    ride.advance(100)
    assert moves(ride) == [("mode", "ahead", 2)]


def test_a_gaze_that_stays_on_it_chooses_nothing_when_it_is_back(ride):
    ride.hover("plugin-0")
    ride.advance(100, look="plugin-0")
    offer(ride.host, lost(AHEAD))
    ride.advance(300, look="plugin-0")
    ride.forget()
    offer(ride.host, AHEAD)
    ride.advance(2000, look="plugin-0")
    assert moves(ride) == []
    ride.hover("plugin-0")
    assert moves(ride) == [("mode", "ahead", 2)]


def test_one_that_does_not_work_cannot_be_chosen_and_says_why(ride):
    offer(ride.host, lost(AHEAD, "plugin_hangs"))
    ride.advance(100)
    ride.hover("plugin-0")
    ride.advance(2000, look="plugin-0")
    begin(ride, "plugin-0", "touch")
    ride.advance(500)
    assert moves(ride) == []
    assert "Deze rijwijze werkt nu niet." in ride.text("#banner")
    assert ride.page.locator("#plugin-0").get_attribute("aria-disabled") == "true"
    assert "antwoordt niet" in ride.text("#plugin-0")


@pytest.mark.parametrize("by", ["gaze", "touch"])
def test_what_becomes_of_modes_holds_up_no_other_motion(driver, by):
    tiled(driver, AHEAD, HOME)
    begin(driver, "forward", by)
    for rows in ([lost(AHEAD), HOME], [AHEAD, lost(HOME)], [AHEAD], [HOME, FOLLOW], [], [AHEAD]):
        offer(driver.host, *rows)
        driver.advance(300, look="forward" if by == "gaze" else None)
    assert moves(driver) == [("cmd", "forward", 1)]


def test_the_corner_names_it_until_it_works_and_says_more_important_things_first(ride):
    offer(ride.host, lost(AHEAD, again=ride.host.token + 8000), HOME)
    ride.advance(100)
    assert "Ahead\u2069 is gestopt." in ride.page.locator("#status").text_content()
    assert "Nieuwe poging binnen 10 s." in ride.text("#status")
    assert ride.page.locator("#status").get_attribute("data-level") == "wait"
    ride.advance(4000)
    assert "Nieuwe poging binnen 5 s." in ride.text("#status")
    ride.advance(5000)
    assert "Wordt nu opnieuw gestart." in ride.text("#status")
    ride.state(level="warning", message="camera_lost")
    ride.advance(50)
    assert "gestopt" not in ride.text("#status")
    ride.state(level="ok", message="ok")
    ride.advance(50)
    assert "gestopt" in ride.text("#status")
    offer(ride.host, AHEAD, HOME)
    ride.advance(50)
    assert "Alles in orde." in ride.text("#status")


def test_what_somebody_must_repair_is_a_warning_and_a_start_says_nothing(ride):
    offer(ride.host, lost(AHEAD, "plugin_setting"), mode("home", state="starting", reason=""))
    ride.advance(50)
    assert ride.page.locator("#status").get_attribute("data-level") == "warning"
    assert "Vraag wie de stoel inricht." in ride.text("#status")
    offer(ride.host, mode("ahead", state="starting", reason="plugin_starting"))
    ride.advance(50)
    assert "Alles in orde." in ride.text("#status")
    assert "start op" in ride.text("#plugin-0")


def test_an_input_that_fails_is_named_too_and_has_no_tile(driver):
    pad = {**mode("gamepad"), "kind": "input", "state": "degraded", "reason": "plugin_trouble"}
    tiled(driver, pad)
    driver.advance(100)
    assert "meldt een probleem." in driver.text("#status")
    assert not [name for name in shown(driver) if name.startswith("plugin")]
    assert "help" in shown(driver)


# Parts that do not come


@pytest.mark.parametrize("file", ["plugin_tiles.js", "plugins.js", "plugin_tiles.css", "nl-plug"])
def test_a_part_that_does_not_come_is_told_and_holds_up_nothing(page, host, file):
    page.route(f"**/{file}*", lambda route: route.abort())
    offer(host, AHEAD)
    person = Driver(page, host)
    person.open()
    host.show(picture(), 1)
    wait_until(lambda: host.acknowledged, "the picture")
    person.wait_until(
        lambda: person.advance(100) or "niet geladen" in person.text("#status"), "what is missing"
    )
    assert page.locator("#status").get_attribute("data-level") == "wait"
    person.forget()
    person.look("stop")
    assert person.received("stop")
    person.advance(400, look=(0.5, 0.55))
    person.hover("forward")
    assert person.received("cmd")
    page.unroute(f"**/{file}*")
    person.wait_until(lambda: person.advance(500) or "plugin-0" in shown(person), "the tiles")
    assert person.text("#plugin-0 .label") == "Ahead"
    person.advance(100)
    assert "Alles in orde." in person.text("#status")


def test_a_part_that_never_answers_holds_up_neither_stop_nor_the_picture(page, host):
    waiting = []
    page.route("**/plugin_tiles.js", lambda route: waiting.append(route))
    offer(host, AHEAD)
    person = Driver(page, host)
    person.open()
    host.show(picture(), 1)
    wait_until(lambda: host.acknowledged, "the picture")
    person.look("stop")
    assert person.received("stop")
    for route in waiting:
        route.abort()


def test_a_menu_that_does_not_come_is_told_and_is_there_at_the_next_try(driver):
    driver.page.route("**/menu.js", lambda route: route.abort())
    driver.state(**OFF)
    driver.page.locator("#menu").click()
    driver.wait_until(
        lambda: driver.advance(50) or "niet geladen" in driver.text("#banner"), "what is missing"
    )
    assert driver.data("view") == "drive"
    driver.page.unroute("**/menu.js")
    driver.page.locator("#menu").click()
    wait_until(lambda: driver.data("view") == "menu", "the menu")
    driver.page.route("**/eyes.js", lambda route: route.abort())
    driver.advance(5000)
    driver.page.locator("#tile-2").click()
    driver.wait_until(
        lambda: driver.advance(50) or "niet geladen" in driver.text("#banner"), "what is missing"
    )
    assert driver.data("view") == "menu"
