"""What a driver must know: who drives, who gets a call, if STOP was confirmed, if sound is on."""

import pytest

import gazesetup
from fakehost import OFF, picture
from gazedemo.browser import OPTIONS
from patience import wait_until
from webperson import Driver

pytestmark = pytest.mark.browser

TAKEN = {"state": "armed", "you": False, "owner": "caretaker"}
LANGUAGES = ["nl", "en"]
MENU_TARGETS = ["tile-1", "tile-2", "tile-3", "tile-4", "tile-5", "back"]
# Visible words smaller than `least` px: their text and size.
SMALL = """
least => [...document.querySelectorAll("body *")].filter(e => {
  const own = [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim());
  const box = e.getBoundingClientRect();
  return own && box.width && getComputedStyle(e).visibility === "visible" &&
    parseFloat(getComputedStyle(e).fontSize) < least;
}).map(e => `${e.textContent.trim()}: ${getComputedStyle(e).fontSize}`)
"""


@pytest.fixture
def tablet(page):
    page.set_viewport_size({"width": 1280, "height": 800})
    return page


def height(driver, selector):
    return driver.page.evaluate(
        "s => parseFloat(getComputedStyle(document.querySelector(s)).fontSize)", selector
    )


def opacity(driver, target):
    return float(
        driver.page.evaluate("id => getComputedStyle(document.getElementById(id)).opacity", target)
    )


# Taken over


def test_taken_over_is_a_large_banner_and_dimmed_targets(tablet, driver, artefact):
    dimmed = ("forward", "left", "right", "mode")
    for owner, words in (
        ("caretaker", "De begeleider bestuurt"),
        ("driver", "Andere pagina bestuurt"),
    ):
        driver.state(**TAKEN | {"owner": owner})
        assert words in driver.text("#banner")
        assert "STOP werkt altijd" in driver.text("#banner")
        assert height(driver, "#banner .title") >= 40
        assert [opacity(driver, target) < 0.5 for target in dimmed] == [True] * 4
        assert opacity(driver, "stop") == opacity(driver, "help") == 1
        driver.advance(20_000)
        assert words in driver.text("#banner")
        artefact("driver-taken")
        driver.state(state="armed", you=True, owner="driver")
        driver.advance(50)
        assert not driver.page.locator("#banner").is_visible()
        assert opacity(driver, "forward") == 1


def test_a_refusal_does_not_hide_who_has_taken_over(driver, host):
    driver.state(**TAKEN)
    host.say({"k": "refused", "what": "cmd", "reason": "not_owner", "detail": ""})
    driver.advance(200)
    assert "De begeleider bestuurt" in driver.text("#banner")


# Help


def test_help_says_who_hears_it_and_who_comes(driver, artefact):
    for news, label, small in (
        ({"heard": False}, "Hulp", "niemand hoort het"),
        ({"heard": True}, "Hulp", "begeleider hoort het"),
        ({"call": True, "heard": False}, "Hulp gevraagd", "niemand hoort het"),
        ({"call": True, "heard": True}, "Hulp gevraagd", "wacht op antwoord"),
        ({"coming": True, "heard": True}, "Komt eraan", ""),
        ({"coming": True, "heard": False}, "Komt eraan", ""),
    ):
        driver.state(**OFF, **{"call": False, "coming": False} | news)
        assert (driver.text("#help-label"), driver.text("#help-state")) == (label, small), news
        artefact(f"driver-{label}-{small}".replace(" ", "-"))


def test_help_that_is_coming_is_no_longer_needed_by_the_same_button(driver):
    driver.state(**OFF, coming=True)
    driver.advance(600)
    driver.page.locator("#help").click()
    assert driver.received("call") == [{"k": "call", "on": False}]


@pytest.mark.parametrize("coming", [True, False])
def test_a_look_at_help_means_the_words_at_its_beginning(driver, coming):
    driver.state(**OFF, coming=coming)
    driver.advance(600)
    driver.advance(300, look="help")
    driver.state(coming=not coming)
    driver.advance(900, look="help")
    assert driver.received("call") == []
    driver.advance(300, look=(0.5, 0.66))
    driver.state(coming=coming)
    driver.advance(600)
    driver.advance(100, look="help")
    driver.state(coming=not coming)
    driver.advance(25, look="help")
    driver.advance(150, look=(0.5, 0.66))  # a blink
    driver.advance(1300, look="help")
    assert driver.received("call") == []
    driver.advance(300, look=(0.5, 0.66))
    driver.advance(1100, look="help")
    assert driver.received("call") == [{"k": "call", "on": coming}]


def test_a_double_tap_on_help_is_one_call(driver):
    driver.page.locator("#help").click()
    driver.state(call=True)
    driver.page.locator("#help").click()
    assert driver.received("call") == [{"k": "call", "on": True}]
    driver.advance(600)
    driver.page.locator("#help").click()
    assert driver.received("call")[-1] == {"k": "call", "on": False}


def test_a_caretaker_answers_and_then_is_there(page, host):
    page.set_viewport_size({"width": 390, "height": 844})
    host.welcome["role"] = "caretaker"
    host.state.update(you=False, call=True)
    caretaker = Driver(page, host)
    caretaker.open("caretaker")
    page.locator("#answer").click()
    caretaker.state(call=False, coming=True)
    assert "wacht op je" in caretaker.text("#call")
    assert caretaker.text("#answer") == "Ik ben er"
    page.locator("#answer").click()  # a double tap, or meant before another caretaker answered
    caretaker.advance(600)
    page.locator("#answer").click()
    sent = [message["there"] for message in caretaker.received("call")]
    assert sent == [False, False, True]
    assert {message["on"] for message in caretaker.received("call")} == {False}
    caretaker.state(coming=False)
    assert not page.locator("#answer").is_visible()


# STOP


def seen(driver):
    return driver.page.locator("#stop").get_attribute("data-seen"), driver.text("#stop-seen")


def test_stop_shows_that_it_was_seen(driver):
    for by in ("look", "press", "key"):
        driver.advance(500, look=(0.5, 0.6))
        if by == "look":
            driver.look("stop")
        elif by == "press":
            driver.page.locator("#stop").click()
        else:
            driver.page.keyboard.press("Escape")
        count = len(driver.received("stop"))
        assert seen(driver) == ("sent", "gevraagd …"), by
        driver.state(stops=count - 1)
        assert seen(driver)[0] == "sent", by
        driver.state(stops=count)
        assert seen(driver) == ("seen", "✓ gezien"), by
        driver.advance(3100)
        assert seen(driver) == ("none", ""), by


def test_a_stop_that_nobody_confirms_says_so(driver):
    driver.page.keyboard.press("Escape")
    driver.advance(1100)
    assert seen(driver) == ("late", "niet bevestigd")
    driver.state(stops=99)
    assert seen(driver)[0] == "seen"


def test_the_stops_of_an_earlier_connection_do_not_count(driver, host):
    for _ in range(3):
        driver.page.keyboard.press("Escape")
    host.close(1001)
    driver.run_for(500)
    driver.connect()
    driver.page.keyboard.press("Escape")
    count = driver.page.evaluate("0")
    driver.forget()
    driver.state(stops=count)
    assert seen(driver)[0] == "sent"
    driver.state(stops=1)
    assert seen(driver)[0] == "seen"


# Sound


# A browser that lets the page be heard when the test says so.
SOUND = """
window.AudioContext = class extends AudioContext {
  constructor() { super(); window.context = this; }
  get state() { return window.sounding ? "running" : "suspended"; }
};
"""


def test_sound_that_is_off_is_shown_until_it_is_on(page, host):
    page.add_init_script(SOUND)
    driver = Driver(page, host)
    driver.open()
    chip = page.get_by_text("Geluid uit", exact=True)
    assert chip.is_visible()
    page.evaluate("sounding = true; context.onstatechange()")
    assert not chip.is_visible()
    page.evaluate("sounding = false; context.onstatechange()")
    assert chip.is_visible()


def test_who_wants_no_tones_is_not_told_that_there_are_none(page, host):
    page.add_init_script(SOUND)
    driver = Driver(page, host)
    driver.open()
    driver.state(**OFF)  # a page that drives keeps what it has
    chip = page.get_by_text("Geluid uit", exact=True)
    assert chip.is_visible()
    host.profiles.change({"save": {"id": "1", "tones": False}}, True)
    driver.state()
    wait_until(lambda: not chip.is_visible(), "the profile")


def test_a_kiosk_that_may_sounds_by_itself(chromium, host):
    options = [*OPTIONS, "--autoplay-policy=no-user-gesture-required"]
    browser = chromium.browser_type.launch(
        executable_path=str(gazesetup.ensure_chromium()), args=options
    )
    try:
        page = browser.new_page()
        page.goto(host.url)
        page.wait_for_selector("body[data-audible=true][data-ready]", timeout=30_000)
        assert not page.get_by_text("Geluid uit", exact=True).is_visible()
    finally:
        browser.close()


# The menu


def test_reading_the_menu_chooses_nothing(menu, host):
    title = menu.text("#sheet-title")
    for _ in range(2):
        for tile in MENU_TARGETS:
            menu.advance(1500, look=tile)
    assert menu.data("view") == "menu"
    assert menu.text("#sheet-title") == title
    assert host.posted == []
    menu.advance(2100, look="tile-3")
    assert menu.text("#sheet-title") == "Tijden"


def test_the_menu_has_a_free_middle(menu):
    for x, y in [(0.5, 0.5), (0.34, 0.45), (0.66, 0.45), (0.5, 0.4), (0.5, 0.68), (0.33, 0.65)]:
        menu.advance(3000, look=(x, y))
        assert menu.page.locator(".dwelling").count() == 0, (x, y)
    assert menu.data("view") == "menu"


def test_a_menu_that_opens_under_the_gaze_is_not_chosen_from(driver):
    driver.state(**OFF)
    driver.advance(350, look=(0.5, 0.5))
    spot = driver.spot("menu")
    share = (spot[0] / 1920, spot[1] / 1080)
    driver.advance(1100, look=share)
    wait_until(lambda: driver.data("view") == "menu", "the menu")
    driver.advance(5000, look="tile-3")
    assert driver.text("#sheet-title") == "Menu"


# The eye test


def test_the_eye_test_begins_with_the_first_look_at_its_dot(menu):
    menu.page.locator("#tile-2").click()
    wait_until(lambda: menu.text("#eyes-left"), "the test")
    menu.advance(5000, look=(0.1, 0.9))
    assert menu.text("#eyes-left") == "De test begint als je kijkt."
    menu.advance(900, look=(0.5, 0.5))
    menu.advance(300, look=(0.2, 0.2))
    menu.advance(900, look=(0.5, 0.5))
    assert menu.text("#eyes-left") == "De test begint als je kijkt."
    menu.advance(400, look=(0.5, 0.5))
    assert menu.text("#eyes-left") == "20 s"


def test_the_eye_test_is_reached_and_ended_by_gaze_alone(driver):
    driver.state(**OFF)
    for target, ms in (("menu", 1100), ("tile-2", 2600)):
        x, y = driver.spot(target)
        driver.advance(ms, look=(x / 1920, y / 1080))
        driver.advance(300, look=(0.5, 0.5))
        view = "menu" if target == "menu" else "eyes"
        wait_until(lambda view=view: driver.data("view") == view, view)
    wait_until(lambda: driver.text("#eyes-left"), "the test")
    driver.advance(1200, look=(0.5, 0.5))
    assert driver.text("#eyes-left").endswith(" s")


# Words that stay, and are large enough


@pytest.mark.parametrize("language", LANGUAGES)
def test_simulation_stays_where_it_is_whatever_else_is_said(tablet, host, language):
    driver = Driver(tablet, host)
    driver.open(f"?lang={language}")
    place = "() => JSON.stringify(document.querySelector('.simulation').getBoundingClientRect())"
    driver.state(simulated=True)
    before = tablet.evaluate(place)
    host.welcome["insecure"] = True
    for news in (
        OFF,
        TAKEN,
        {"relay_checked": False},
        {"motion": "backward", "output_permille": [-953, -953]},
    ):
        driver.state(**news)
        assert tablet.evaluate(place) == before
        assert tablet.locator(".simulation").is_visible()
    driver.state(**OFF)
    tablet.locator("#menu").click()
    wait_until(lambda: driver.data("view") == "menu", "the menu")
    assert tablet.evaluate(place) == before


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("path", ["", "caretaker", "pair"])
def test_no_word_is_smaller_than_18_px_on_a_tablet(tablet, host, path, language):
    host.welcome["role"] = path or "driver"
    person = Driver(tablet, host)
    if path == "pair":
        tablet.goto(f"{host.url}pair?lang={language}")
        tablet.wait_for_selector("body[data-ready]")
        return check_sizes(tablet)
    person.open(f"{path}?lang={language}")
    check_sizes(tablet)
    for news in (
        {"simulated": True, "relay_checked": False, "call": True, "heard": False},
        {"override": "obstacle_left", "stops": 9},
        {**OFF, "override": "none", "level": "error", "message": "emergency"},
        {"level": "ok", "message": "ok", "arm_reason": "none"},
        TAKEN,
    ):
        person.state(**news)
        person.advance(25)
        check_sizes(tablet)
    if path == "":
        person.state(**OFF)
        for target in ("menu", "tile-3", "back", "tile-4", "back", "tile-2"):
            tablet.locator(f"#{target}").click()
            check_sizes(tablet)
    return None


def check_sizes(page):
    assert page.evaluate(SMALL, 18) == []


COVERED = """
() => [...document.querySelectorAll(".near, .tag")].filter(e => {
  const box = e.getBoundingClientRect();
  if (!box.width || getComputedStyle(e).visibility !== "visible") return false;
  return [[0.02, 0.5], [0.5, 0.5], [0.98, 0.5], [0.5, 0.1], [0.5, 0.9]].some(([x, y]) => {
    const all = document.elementsFromPoint(box.x + x * box.width, box.y + y * box.height);
    return !all.some(found => e.contains(found)) || !e.contains(all[0]);
  });
}).map(e => e.id || e.parentElement.id)
"""


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_tag_is_ever_covered_on_a_phone(page, host, language):
    page.set_viewport_size({"width": 390, "height": 844})
    host.welcome["role"] = "caretaker"
    person = Driver(page, host)
    person.open(f"caretaker?lang={language}")
    host.show(picture(), 1)
    for news in (
        {"decisions": dict.fromkeys(("forward", "backward", "left", "right"), "slow")},
        {"clearance": {"forward": 12.3, "backward": 12.3, "left": 175.0, "right": 175.0}},
        {"call": True, "you": False},
        {"override": "heading_frozen", "level": "error", "message": "wiper"},
        {"simulated": True, "coming": True},
    ):
        person.state(**news)
        person.advance(25)
        assert page.evaluate(COVERED) == [], news
