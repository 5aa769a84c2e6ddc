"""Driving with one switch by scanning, in a real Chromium with a stand-in for the host."""

import pytest

from fakehost import OFF
from gazechair.driving.control import HEARTBEAT_MS
from layoutshift import WATCH, take
from patience import wait_until
from webscanner import DIRECTIONS, LIT, ROWS, Scanner, opened

pytestmark = pytest.mark.browser

MOVES = {"motion": "forward", "output_permille": [500, 0]}


def test_it_is_off_until_a_profile_asks_for_it_and_then_needs_no_reload(driver, host):
    driver.advance(2000)
    assert driver.page.evaluate(LIT) == []
    driver.page.keyboard.press(" ")
    assert driver.received("stop")
    driver.state(**OFF)
    host.profiles.change({"save": {"id": "1", **ROWS}}, True)
    driver.state()
    wait_until(lambda: driver.page.evaluate(LIT) == ["stop"], "the scan")
    host.profiles.change({"save": {"id": "1", "scan": "off"}}, True)
    driver.state()
    wait_until(lambda: driver.page.evaluate(LIT) == [], "its end")


def test_a_held_switch_drives_until_it_is_let_go(scanner, artefact):
    assert scanner.lit() == ["stop"]
    scanner.wait_for(*DIRECTIONS)
    artefact("driver-scan-row")
    scanner.press()
    scanner.wait_for("left")
    artefact("driver-scan-one")
    scanner.forget()
    scanner.down()
    scanner.advance(1000)
    assert 900 <= len(scanner.received("cmd")) * HEARTBEAT_MS <= 1000
    assert scanner.sent() == [("cmd", "left", 1)]
    scanner.up()
    scanner.advance(75)
    assert scanner.sent() == [("stop", None, None)]
    scanner.advance(5000)
    assert scanner.sent() == []


def test_nothing_is_said_to_be_held_while_the_contact_is_open(scanner):
    scanner.choose(DIRECTIONS, ["forward"])
    scanner.forget()
    for _ in range(5):  # bounces of 25 ms
        scanner.up()
        scanner.run_for(25)
        scanner.down()
        scanner.advance(75)
    assert scanner.sent() == [("cmd", "forward", 1)]
    scanner.up()
    scanner.run_for(25)
    assert scanner.received("cmd") == []


def test_a_press_starts_a_step_and_the_next_press_stops(scanner, host):
    scanner.page.locator("#mode").click()
    scanner.choose(DIRECTIONS, ["left"])
    scanner.up()
    scanner.advance(200)
    assert scanner.sent()[-1] == ("cmd", "left", 1)
    scanner.down()  # the board has not reported motion yet
    assert scanner.sent() == [("stop", None, None)]
    scanner.advance(1000)
    scanner.up()
    scanner.advance(1000)
    scanner.choose(DIRECTIONS, ["forward"])
    scanner.up()
    scanner.advance(300)
    scanner.state(**MOVES)
    scanner.advance(1000)
    scanner.forget()
    assert scanner.lit() == ["stop"]
    scanner.down()
    assert scanner.sent() == [("stop", None, None)]


def test_any_press_stops_a_chair_that_others_or_the_eyes_move(scanner):
    scanner.hover("forward")
    scanner.advance(100, look="forward")
    assert scanner.sent()[-1][:2] == ("cmd", "forward")
    scanner.down()
    assert scanner.sent()[-1] == ("stop", None, None)
    scanner.advance(500, look="forward")
    assert scanner.sent() == []
    scanner.up()
    scanner.state(you=False, owner="caretaker", **MOVES)
    scanner.advance(1000)
    assert scanner.lit() == ["stop"]
    scanner.down()
    assert scanner.sent() == [("stop", None, None)]
    scanner.advance(3000)
    scanner.up()
    assert scanner.sent() == []


def test_the_switch_drives_and_a_look_at_stop_stops_it_for_good(scanner):
    scanner.choose(DIRECTIONS, ["forward"])
    scanner.advance(300, look="left")
    assert scanner.sent()[-1][:2] == ("cmd", "forward")
    scanner.look("stop")
    assert scanner.sent()[-1] == ("stop", None, None)
    scanner.advance(2000)
    assert scanner.sent() == []


def test_looking_can_be_off_beside_it_and_a_finger_works(page, host):
    scanner = opened(page, host, scan_gaze=False)
    scanner.hover("forward")
    scanner.look("stop")
    assert scanner.sent() == []
    scanner.page.mouse.down()
    assert scanner.sent() == [("stop", None, None)]


def test_key_repeats_are_no_press_and_the_scan_waits_meanwhile(scanner):
    scanner.choose(DIRECTIONS)
    for _ in range(40):
        scanner.down()  # Playwright sends a repeat of a key that is down
        scanner.advance(50)
    assert scanner.lit() == ["forward"]
    assert scanner.sent() == []


def test_a_switch_that_is_held_while_the_page_loads_chooses_nothing(scanner):
    scanner.down()
    scanner.open()
    wait_until(scanner.lit, "the scan")
    scanner.forget()
    for _ in range(60):
        scanner.down()
        scanner.advance(50)
    assert scanner.sent() == []
    scanner.up()
    scanner.wait_for(*DIRECTIONS)
    scanner.press()
    assert scanner.lit() == ["forward"]


LOSSES = {
    "blur": "dispatchEvent(new Event('blur'))",
    "pagehide": "dispatchEvent(new Event('pagehide'))",
    "freeze": "document.dispatchEvent(new Event('freeze'))",
    "hidden": "Object.defineProperty(document, 'hidden', {value: true, configurable: true});"
    "document.dispatchEvent(new Event('visibilitychange'))",
}


def test_a_page_without_its_person_ends_everything(scanner):
    for how, event in LOSSES.items():
        scanner.choose(DIRECTIONS, ["forward"])
        assert scanner.sent()[-1][0] == "cmd", how
        scanner.page.evaluate(event)
        assert scanner.received("disarm"), how
        assert scanner.sent() == [("stop", None, None)], how
        scanner.advance(3000)
        assert scanner.sent() == [], how
        scanner.up()
        scanner.wait_for(*DIRECTIONS)
        scanner.down()
        scanner.page.evaluate(event)  # before it counts
        scanner.forget()
        scanner.advance(1000)
        scanner.up()
        assert scanner.sent() == [], how


def test_a_link_lost_mid_press_ends_it_and_only_stop_is_left(scanner):
    scanner.choose(DIRECTIONS, ["forward"])
    scanner.forget()
    scanner.run_for(700)
    assert scanner.sent()[-1] == ("stop", None, None)
    assert scanner.lit() == ["stop"]
    scanner.run_for(1000)
    assert scanner.lit() == ["stop"]
    scanner.connect()
    scanner.advance(3000)
    assert scanner.sent() == []
    scanner.up()
    scanner.wait_for(*DIRECTIONS)
    scanner.forget()
    scanner.down()
    scanner.run_for(25)
    scanner.run_for(700)  # lost before it counts: the row is not chosen
    scanner.connect()
    assert scanner.lit() == ["stop"]


def test_while_driving_is_off_no_direction_is_offered(scanner):
    scanner.state(**OFF)
    seen = []
    for _ in range(50):
        scanner.advance(100)
        seen += [scanner.lit()] if scanner.lit() not in seen else []
    assert seen == [["stop"], ["arm"], ["menu"], ["help"]]
    assert "gele rand" in scanner.text("#hint")
    scanner.wait_for("arm")
    scanner.press()
    assert len(scanner.received("arm")) == 1


def test_the_menu_is_reached_and_left_and_every_tile_can_be_chosen(scanner, host, artefact):
    scanner.state(**OFF)
    scanner.wait_for("menu")
    scanner.press()
    scanner.wait_for("tile-1", "tile-2", "tile-3")
    scanner.advance(1000)
    scanner.wait_for("tile-4", "tile-5", "back")
    artefact("driver-scan-menu")
    scanner.press()
    scanner.wait_for("tile-4")
    scanner.press()  # looks: four tiles
    scanner.wait_for("tile-4", "back")
    scanner.press()
    scanner.wait_for("back")
    scanner.press()
    scanner.wait_for("tile-4", "tile-5", "back")
    scanner.press()
    scanner.wait_for("back")
    scanner.press()
    assert scanner.data("view") == "drive"


def test_a_tile_that_was_not_shown_can_be_chosen_again(driver, host):
    driver.state(**OFF)
    for name in ("menu", "tile-4", "tile-1", "back"):  # looks, another contrast, back
        driver.page.locator(f"#{name}").click()
        if name == "tile-1":
            wait_until(lambda: host.posted, "another contrast")
            driver.takes_profiles()
        driver.state()
    host.posted.clear()
    driver.page.locator("#tile-5").click()
    wait_until(lambda: host.posted, "the next person")


def test_practice_by_scanning_sends_nothing(scanner):
    scanner.state(**OFF)
    scanner.wait_for("menu")
    scanner.press()
    scanner.wait_for("tile-1", "tile-2", "tile-3")
    scanner.press()
    scanner.wait_for("tile-1")
    scanner.press()
    scanner.wait_for("arm")
    scanner.press()
    scanner.forget()
    scanner.choose(DIRECTIONS, ["right"])
    scanner.advance(500)
    scanner.up()
    scanner.advance(100)
    assert "Rechts 1" in scanner.text("#score")
    assert scanner.received("cmd", "arm") == []


def test_a_profile_changed_elsewhere_waits_until_driving_is_off(scanner, host):
    scanner.choose(DIRECTIONS, ["forward"])
    request = {"save": {"id": "1", "scan": "single", "scan_switch": "enter", "scan_ms": 2000}}
    host.profiles.change(request, True)
    scanner.advance(500)
    assert scanner.sent()[-1][:2] == ("cmd", "forward")
    scanner.up()
    scanner.advance(100)
    scanner.state(**OFF)
    scanner.takes_profiles()
    scanner.key = "Enter"
    scanner.state(state="armed", you=True, owner="driver")
    scanner.choose(["forward"])
    assert scanner.sent()[-1] == ("cmd", "forward", 2)


def test_driving_stays_on_long_enough_for_a_slow_scan(page, host):
    scanner = opened(page, host, scan="single", scan_ms=2000, auto_off_s=10)
    scanner.advance(15_000)
    assert scanner.received("disarm") == []
    scanner.advance(4_000)
    assert scanner.received("disarm")


def test_driving_stays_on_for_nine_scan_times_within_a_row_too(page, host):
    scanner = opened(page, host, scan_ms=3000, auto_off_s=15)
    scanner.wait_for(*DIRECTIONS)
    scanner.press()
    assert scanner.lit() == ["forward"]
    scanner.advance(17_000)
    assert scanner.received("disarm") == []
    scanner.wait_for(*DIRECTIONS)
    assert scanner.received("disarm") == []


def test_the_light_moves_nothing_else_and_is_seen(page, host, artefact):
    page.add_init_script(WATCH)
    page.set_viewport_size({"width": 1280, "height": 800})
    host.state.update(OFF)
    scanner = opened(page, host, contrast="high")
    take(page)
    for _ in range(8):
        scanner.advance(500)
        assert take(page) == []
    artefact("driver-scan-off")
    scanner.state(state="armed", you=True, owner="driver")
    scanner.choose(DIRECTIONS, ["right"])
    scanner.advance(500)
    artefact("driver-scan-holds")
    assert take(page) == []
    wide = page.evaluate(
        "parseFloat(getComputedStyle(document.querySelector('#stop.lit')).outlineWidth)"
    )
    assert wide >= 8


def test_scanning_that_cannot_be_fetched_is_asked_for_again(page, host):
    page.route("**/switch_scan.js", lambda route: route.abort())
    host.profiles.change({"save": {"id": "1", **ROWS}}, True)
    scanner = Scanner(page, host)
    scanner.open()
    scanner.advance(3000)
    assert scanner.lit() == []
    page.unroute("**/switch_scan.js")
    scanner.wait_until(lambda: scanner.advance(500) or scanner.lit(), "the scan")
