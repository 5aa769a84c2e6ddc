"""The driver's own settings: the menu, practice, the eye test, help, and driving that goes off."""

import pytest

from fakehost import OFF, picture
from patience import wait_until

pytestmark = pytest.mark.browser


def choose(driver, target):
    """A click on a target, and the pointer away again."""
    driver.page.locator(f"#{target}").click()
    driver.look((0.5, 0.66))


def background(driver, host):
    host.show(picture(), 1)
    wait_until(lambda: host.acknowledged, "the picture")
    driver.advance(25)


def test_the_menu_is_there_only_while_driving_is_off(driver):
    assert not driver.page.locator("#menu").is_visible()
    assert driver.page.locator("#mode").is_visible()
    driver.state(**OFF)
    assert driver.page.locator("#menu").is_visible()
    assert not driver.page.locator("#mode").is_visible()


def test_the_menu_keeps_stop_and_has_seven_targets_at_most(menu, artefact):
    targets = [t for t in menu.page.locator(".target").all() if t.is_visible()]
    assert len(targets) == 7
    menu.forget()
    menu.look("stop")
    assert menu.received("stop")
    artefact("driver-menu")
    choose(menu, "back")
    assert menu.data("view") == "drive"


def test_nothing_drives_from_the_menu(menu):
    menu.state(state="armed", you=False, owner="caretaker")
    menu.forget()
    for place in ("tile-1", "tile-2", "tile-4", (0.5, 0.2), (0.1, 0.45), (0.9, 0.45)):
        menu.advance(500, look=place)
    for key in ("ArrowUp", "ArrowLeft", "ArrowRight", "ArrowDown"):
        menu.page.keyboard.press(key)
    assert menu.received("cmd") == []


def test_times_are_changed_by_steps_saved_on_the_host_and_used_at_once(menu, host, artefact):
    choose(menu, "tile-3")
    artefact("driver-menu-times")
    assert "0,60 s" in menu.text("#tile-2")
    choose(menu, "tile-2")
    wait_until(lambda: "0,70 s" in menu.text("#tile-2"), "the new time")
    assert host.posted == [("/profiles", {"save": {"id": "1", "dwell_ms": 700}})]
    choose(menu, "back")
    choose(menu, "back")
    menu.state(state="armed", you=True, owner="driver")
    menu.forget()
    menu.advance(350, look=(0.5, 0.66))
    menu.advance(675, look="forward")
    assert menu.received("cmd") == []
    menu.advance(75, look="forward")
    assert menu.received("cmd")


def test_a_time_stops_at_its_limit(menu, host):
    host.profiles.change({"save": {"id": "1", "dwell_ms": 2000}}, True)
    menu.state()
    choose(menu, "tile-3")
    wait_until(lambda: "2,00 s" in menu.text("#tile-2"), "the profile")
    choose(menu, "tile-2")
    wait_until(lambda: host.posted, "the wish")
    assert host.posted[-1][1]["save"]["dwell_ms"] == 2000


@pytest.mark.parametrize("look", ["high", "night"])
def test_contrast_and_mirroring_are_seen_at_once(menu, host, look, artefact):
    choose(menu, "tile-4")
    artefact("driver-menu-looks")
    for _ in range(1 if look == "high" else 2):
        before = menu.data("contrast")
        choose(menu, "tile-1")
        wait_until(lambda before=before: menu.data("contrast") != before, "the look")
    choose(menu, "tile-3")
    wait_until(lambda: menu.data("mirrored") == "true", "mirrored")
    choose(menu, "back")
    choose(menu, "back")
    background(menu, host)
    menu.state(
        state="armed",
        you=True,
        owner="driver",
        motion="turn",
        output_permille=[0, 715],
        decisions={"forward": "slow", "left": "free", "right": "blocked", "backward": "unknown"},
        clearance={"forward": 1.24, "left": 95.0, "right": 0.0, "backward": None},
    )
    menu.advance(25)
    assert menu.data("contrast") == look
    assert menu.spot("stop")[0] > 960 > menu.spot("help")[0]
    assert menu.spot("left")[0] < 960 < menu.spot("right")[0]
    artefact(f"driver-{look}")


def test_another_person_brings_their_own_settings(menu, host):
    host.profiles.change({"create": "Jan"}, True)
    menu.state()
    wait_until(lambda: len(host.profiles.as_json()["profiles"]) == 2, "Jan")
    host.profiles.change({"save": {"id": "2", "mode": "step"}}, True)
    menu.state()
    menu.advance(100)
    choose(menu, "tile-5")
    wait_until(lambda: "Jan" in menu.text("#tile-5"), "the name")
    assert menu.data("mode") == "step"
    assert host.profiles.chosen()["name"] == "Jan"


@pytest.mark.parametrize(
    "change", [{"language": "en"}, {"mode": "step"}, {"auto_off_s": 10}, {"contrast": "night"}]
)
def test_a_profile_changed_elsewhere_waits_until_this_page_drives_no_more(driver, host, change):
    """Nothing saved by another page changes a page that drives: mode, language or arming."""
    page = driver.page
    page.evaluate("window.same = true")
    requested = []
    page.on("request", lambda request: requested.append(request.url))
    host.profiles.change({"save": {"id": "1", "mode": "continuous"}}, True)
    host.profiles.change({"save": {"id": "1", **change}}, True)
    driver.forget()
    for _ in range(20):
        driver.state()
        driver.advance(100)
    assert driver.data("state") == "armed"
    assert driver.data("mode") == "continuous"
    assert driver.data("contrast") == "normal"
    assert page.evaluate("window.same && document.documentElement.lang") == "nl"
    assert not driver.received("disarm")
    assert not any("/profiles" in url for url in requested)
    if "language" in change:
        with page.expect_navigation():
            host.state.update(OFF)
            host.say_state()
        return
    driver.state(**OFF)
    driver.wait_until(lambda: any("/profiles" in url for url in requested), "the profile is read")
    name, value = next(iter(change.items()))
    if name in ("mode", "contrast"):
        wait_until(lambda: driver.data(name) == value, "the change arrives")


def test_a_profile_that_comes_after_arming_is_not_taken(driver, host):
    """Requested while driving was off; the answer arrives when it is on."""
    driver.state(**OFF)
    held = []
    driver.page.route("**/profiles", lambda route: held.append(route))
    host.profiles.change({"save": {"id": "1", "mode": "step", "contrast": "night"}}, True)
    driver.state()
    driver.wait_until(lambda: held, "the page asks")
    driver.state(state="armed", you=True, owner="driver")
    held[0].continue_()
    driver.takes_profiles()
    driver.page.unroute("**/profiles")
    assert (driver.data("mode"), driver.data("contrast")) == ("continuous", "normal")
    driver.state(**OFF)
    wait_until(lambda: driver.data("contrast") == "night", "the change arrives")


def test_a_look_at_a_person_does_not_choose_the_next_one(menu, host):
    """A caretaker chooses while the driver looks at the tile, whose meaning changes."""
    for name in ("Jan", "Piet"):
        host.profiles.change({"create": name}, True)
    host.profiles.change({"choose": "1"}, True)
    menu.state()
    menu.takes_profiles()
    menu.advance(1200, look="tile-5")
    host.profiles.change({"choose": "2"}, True)
    menu.state()
    menu.takes_profiles()
    menu.advance(900, look="tile-5")
    assert host.profiles.chosen()["name"] == "Jan"
    menu.advance(300, look=(0.5, 0.66))
    menu.advance(2200, look="tile-5")
    wait_until(lambda: host.profiles.chosen()["name"] == "Piet", "the choice")


def test_the_next_tile_can_be_looked_at_right_after_ones_own_choice(menu, host):
    """The host's state with the new revision arrives before its answer to the choice."""
    held = {}

    def hold(route):
        held[route.request.method] = route, route.fetch()

    menu.page.route("**/profiles", hold)
    choose(menu, "tile-4")  # looks
    choose(menu, "tile-1")  # the contrast
    menu.wait_until(lambda: "POST" in held, "the choice")
    menu.state()
    menu.wait_until(lambda: "GET" in held, "the page to ask")
    for method in ("POST", "GET"):
        route, response = held[method]
        route.fulfill(response=response)
        menu.answered() if method == "GET" else menu.page.evaluate("true")
    menu.page.unroute("**/profiles")
    menu.advance(2200, look="tile-4")  # the tones
    wait_until(lambda: not host.profiles.chosen()["tones"], "the next choice")


def test_what_a_caretaker_tunes_arrives_without_a_reload(driver, host):
    driver.state(**OFF)
    host.profiles.change({"save": {"id": "1", "contrast": "night"}}, True)
    driver.state()
    wait_until(lambda: driver.data("contrast") == "night", "the look")


def test_a_third_language_is_one_file(page, driver, host):
    words = page.evaluate("fetch('/strings/en.json').then(answer => answer.json())")
    words["labels"]["forward"] = "Forwarts"
    page.route("**/strings/xx.json", lambda route: route.fulfill(json=words))
    driver.state(**OFF)
    host.profiles.change({"save": {"id": "1", "language": "xx"}}, True)
    with page.expect_navigation():
        host.say_state()  # without a check of its arrival: the page then leaves at once
    driver.connect()
    assert driver.text("#forward") == "Forwarts"
    assert page.evaluate("document.documentElement.lang") == "xx"


def test_practice_moves_nothing_and_counts(menu, host, artefact):
    choose(menu, "tile-1")
    assert menu.data("practice") == "true"
    background(menu, host)
    artefact("driver-practice")
    menu.forget()
    menu.advance(1100, look="arm")
    assert menu.data("state") == "armed"
    for target in ("forward", "left", "forward"):
        menu.hover(target)
        menu.advance(300, look=(0.5, 0.66))
    menu.page.keyboard.press("ArrowRight")
    assert menu.received("arm", "take", "cmd", "drive", "bypass") == []
    assert menu.text("#score") == "Vooruit 2 · Links 1 · Rechts 1"
    menu.state(override="obstacle_left")
    artefact("driver-practising")
    menu.page.keyboard.press("Enter")
    menu.advance(500)
    choose(menu, "menu")
    choose(menu, "tile-1")
    assert menu.data("practice") == "false"
    menu.page.keyboard.press("Enter")
    assert len(menu.received("arm")) == 1


def test_a_chair_that_becomes_armed_while_practice_begins_goes_off(menu):
    choose(menu, "tile-1")
    menu.state(state="armed", you=False, owner="caretaker")
    menu.advance(300)
    assert menu.received("disarm") == []  # another page's driving
    menu.state(state="arming", you=True, owner="driver")  # this page had asked
    assert menu.received("disarm")
    menu.state(**OFF)
    menu.forget()
    menu.advance(500)
    assert menu.received("disarm") == []


@pytest.mark.parametrize("view", ["menu", "eyes"])
def test_a_chair_that_becomes_armed_closes_the_menu_and_the_eye_test(menu, view):
    if view == "eyes":
        choose(menu, "tile-2")
    assert menu.data("view") == view
    menu.state(state="armed", you=True, owner="driver")
    assert menu.data("view") == "drive"
    menu.hover("forward")
    assert menu.received("cmd")


def test_the_eye_test_measures_and_proposes(menu, host, artefact):
    choose(menu, "tile-2")
    assert menu.data("view") == "eyes"
    wait_until(lambda: menu.text("#eyes-left"), "the test")
    menu.advance(1025, look=(0.5, 0.5))  # begins it
    menu.advance(500, look=(0.5, 0.5))
    artefact("driver-eyes")
    places = [(0.5, 0.5), (0.12, 0.45), (0.5, 0.2), (0.88, 0.45), (0.5, 0.75)]
    menu.advance(3475, look=places[0])
    for place in places[1:]:
        menu.advance(2000, look=place)
        menu.advance(300)  # the tracker loses the eyes
        menu.advance(1700, look=place)
    menu.advance(50)
    assert menu.data("view") == "menu"
    assert "4 (" in menu.text("#tile-2")
    artefact("driver-eyes-result")
    choose(menu, "tile-3")
    wait_until(lambda: host.posted, "the profile")
    saved = host.profiles.chosen()
    assert (saved["dwell_ms"], saved["leave_grace_ms"]) == (550, 400)


def test_an_eye_test_that_does_not_load_opens_no_menu_over_an_armed_chair(menu):
    waiting = []
    menu.page.route("**/eyes.js*", lambda route: waiting.append(route))
    choose(menu, "tile-2")
    assert menu.data("view") == "eyes"
    menu.wait_until(lambda: waiting, "its request")
    menu.state(state="armed", you=True, owner="driver")
    assert menu.data("view") == "drive"
    waiting[0].abort()
    menu.run_for(200)
    assert menu.data("view") == "drive"


def test_the_eye_test_without_eyes_says_so(menu):
    choose(menu, "tile-2")
    wait_until(lambda: menu.text("#eyes-left"), "the test")
    for _ in range(70):
        menu.state()
        menu.run_for(450)
    assert "Geen blik gezien" in menu.text("#tile-1")


def test_help_is_asked_by_looking_and_taken_back(driver, artefact):
    driver.advance(1100, look="help")
    assert driver.received("call") == [{"k": "call", "on": True}]
    driver.state(call=True)
    assert driver.text("#help-label") == "Hulp gevraagd"
    assert driver.page.locator("#help").get_attribute("aria-pressed") == "true"
    driver.advance(600)
    artefact("driver-help")
    choose(driver, "help")
    assert driver.received("call")[-1] == {"k": "call", "on": False}


def test_driving_unused_counts_down_and_goes_off(driver, host):
    driver.state(**OFF)
    host.profiles.change({"save": {"id": "1", "auto_off_s": 10, "contrast": "night"}}, True)
    driver.state()
    wait_until(lambda: driver.data("contrast") == "night", "the profile")
    driver.state(state="armed", you=True, owner="driver")
    driver.hover("forward")
    driver.advance(300, look=(0.5, 0.66))
    driver.forget()
    driver.advance(7_000, look=(0.5, 0.66))
    assert "Gaat uit over 3 s" in driver.text("#arm-state")
    assert driver.received("disarm") == []
    driver.advance(3100, look=(0.5, 0.66))
    assert driver.received("disarm") == [{"k": "disarm"}]


def test_driving_that_is_used_stays_on(driver):
    driver.page.keyboard.down("ArrowUp")
    for _ in range(40):
        driver.state()
        driver.run_for(450)
    assert driver.received("disarm") == []


def test_two_clicks_of_a_pointer_that_never_moves_mean_steps(driver):
    x, y = driver.spot("forward")
    for click in range(2):
        driver.advance(2000)
        driver.page.mouse.click(x + click, y)
    assert driver.data("mode") == "step"
    assert "Stap per klik" in driver.text("#banner")
    driver.forget()
    driver.advance(2000)
    driver.page.mouse.click(x, y)
    assert {m["mode"] for m in driver.received("cmd")} == {"step"}


def test_a_mouse_that_moves_stays_continuous(driver):
    for _ in range(3):
        driver.advance(300, look=(0.5, 0.66))
        driver.advance(200, look="forward")
        driver.page.mouse.down()
        driver.page.mouse.up()
    assert driver.data("mode") == "continuous"


def test_targets_are_reached_and_pressed_by_tab_and_enter(driver):
    driver.page.keyboard.press("Tab")
    assert driver.page.evaluate("document.activeElement.id") == "arm"
    driver.advance(500)
    driver.page.keyboard.press("Enter")
    assert len(driver.received("disarm")) == 1
    driver.page.keyboard.press("Tab")
    driver.page.keyboard.press("Enter")
    assert driver.data("mode") == "step"
    driver.page.keyboard.press("Enter")
    driver.page.keyboard.press("Tab")
    driver.page.keyboard.down("Enter")
    driver.advance(100)
    assert {m["verb"] for m in driver.received("cmd")} == {"forward"}
    driver.page.keyboard.up("Enter")
    assert driver.received("cmd", "stop")[-1] == {"k": "stop"}
