"""What the page shows the driver: status, override, obstacle line, picture, language."""

import itertools

import pytest

from fakehost import picture
from patience import wait_until
from webperson import Driver

pytestmark = pytest.mark.browser


def banner(driver):
    """The banner's kind and words; kind "none" when it is not shown."""
    kind = driver.page.locator("#banner").get_attribute("data-kind")
    assert driver.page.locator("#banner").is_visible() == (kind != "none")
    return kind, driver.text("#banner")


def test_an_override_is_shown_at_once_with_its_reason_and_goes_with_it(driver):
    driver.state(override="obstacle_forward")
    kind, words = banner(driver)
    assert kind == "override"
    assert "Er staat iets voor de rolstoel." in words
    assert driver.page.locator("#banner").get_attribute("data-key") == "obstacle_forward"
    driver.advance(5000)
    assert banner(driver)[0] == "override"
    driver.state(override="none")
    driver.advance(100)
    assert banner(driver)[0] == "none"


def test_a_short_override_stays_readable(driver):
    driver.state(override="obstacle_left")
    driver.state(override="none")
    driver.advance(1400)
    assert banner(driver)[0] == "override"
    driver.advance(200)
    assert banner(driver)[0] == "none"


def test_an_override_is_heard_once_the_browser_allows_sound(driver):
    driver.page.evaluate(
        "() => { window.tones = 0; const start = OscillatorNode.prototype.start;"
        "OscillatorNode.prototype.start = function(t) { tones += 1; start.call(this, t); } }"
    )
    driver.state(override="time_limit")
    driver.state(override="none")
    assert (driver.page.evaluate("tones") == 0) == (driver.data("audible") == "false")
    driver.page.keyboard.press(" ")

    def received():
        driver.state(override="time_limit")
        driver.state(override="none")
        return driver.page.evaluate("tones") > 0

    wait_until(received, "a tone")


def test_an_unknown_reason_of_a_newer_board_is_shown_by_name(driver):
    driver.state(override="unknown_61")
    assert "unknown_61" in banner(driver)[1]


def test_a_refused_arming_says_why(driver):
    driver.state(state="disarmed", you=False, owner="nobody", arm_reason="obstacle_data_old")
    assert "obstakelsensor" in driver.text("#hint")
    driver.advance(500)
    driver.page.keyboard.press("Enter")
    driver.advance(500)
    assert banner(driver)[0] == "none"
    driver.advance(300)
    kind, words = banner(driver)
    assert kind == "notice"
    assert "Rijden kan niet aan" in words
    assert "obstakelsensor" in words
    driver.advance(4000)
    assert banner(driver)[0] == "none"


def test_an_arming_that_succeeds_says_nothing(driver):
    driver.state(state="disarmed", you=False, owner="nobody")
    assert "Klaar om te rijden" in driver.text("#hint")
    driver.advance(500)
    driver.page.keyboard.press("Enter")
    assert driver.received("arm")
    driver.state(state="arming")
    driver.advance(200)
    driver.state(state="armed", you=True, owner="driver")
    driver.advance(1000)
    assert banner(driver)[0] == "none"
    assert not driver.page.locator("#hint").is_visible()


def test_a_refusal_of_the_host_says_why(driver, host):
    for what, reason, words in (
        ("cmd", "not_owner", "Iemand anders"),
        ("arm", "stale_token", "te traag"),
    ):
        host.say({"k": "refused", "what": what, "reason": reason, "detail": "for the log"})
        driver.state()
        assert words in banner(driver)[1]


def test_a_refusal_said_again_stays_and_touches_nothing(driver, host):
    refusal = {"k": "refused", "what": "cmd", "reason": "not_armed", "detail": "for the log"}
    host.say(refusal)
    driver.advance(3000)
    driver.page.evaluate(
        "() => { window.touched = 0; new MutationObserver(() => { touched += 1; }).observe("
        "document.getElementById('banner'), {subtree: true, childList: true, attributes: true}); }"
    )
    host.say(refusal)
    driver.advance(3000)
    assert banner(driver)[0] == "notice"
    assert driver.page.evaluate("touched") == 0
    driver.advance(1100)
    assert banner(driver)[0] == "none"


def test_a_tap_in_continuous_mode_is_explained(driver):
    driver.page.locator("#forward").click()
    assert "Houd ingedrukt" in banner(driver)[1]


def test_the_corner_says_how_things_are(driver):
    for level, key, words in (
        ("warning", "camera_lost", "De camera geeft geen beeld."),
        ("ok", "ok", "Alles in orde."),
        ("error", "lidar_lost", "De obstakelsensor is niet verbonden."),
    ):
        driver.state(level=level, message=key)
        assert words in driver.text("#status")
        assert driver.page.locator("#status").get_attribute("data-level") == level


def test_the_obstacle_line_has_a_colour_and_a_word_for_each_segment(driver):
    driver.state(
        decisions={"left": "blocked", "forward": "slow", "right": "unknown", "backward": "free"}
    )
    words = [driver.text(f"#line-{segment} .tag") for segment in ("left", "front", "right")]
    assert words == ["Links\nbezet", "Voor langzaam", "Rechts\nonbekend"]
    looks = driver.page.evaluate(
        "[...document.querySelectorAll('.bar')].map(e => { const s = getComputedStyle(e);"
        "return s.backgroundColor + s.backgroundImage; })"
    )
    assert len(set(looks)) == 3


DIRECTIONS = ("forward", "backward", "left", "right")
ALL_SEEN = dict.fromkeys(DIRECTIONS, "seen")


def test_the_obstacle_line_tells_distances_when_the_host_does(driver):
    driver.state(
        decisions={"left": "free", "forward": "slow", "right": "blocked", "backward": "free"},
        clearance={"forward": 1.27, "backward": None, "left": 96.0, "right": 4.0},
        view=ALL_SEEN,
    )
    words = [driver.text(f"#line-{segment} .tag") for segment in ("left", "front", "right")]
    assert words == ["Links\nvrij\n95°", "Voor langzaam 1,2 m", "Rechts\nbezet\n0°"]


def test_what_is_not_seen_is_said_and_looks_like_it(driver):
    for view, word in (("unseen", "niet gezien"), ("blind", "zicht weg")):
        driver.state(
            decisions=dict(zip(DIRECTIONS, ("blocked", "free", "free", "unknown"), strict=True)),
            clearance={"forward": 0.0, "backward": None, "left": None, "right": None},
            view={**ALL_SEEN, "forward": view, "left": view},
        )
        assert driver.text("#line-front .tag").split() == ["Voor", *word.split()]
        assert driver.text("#line-left .tag").split() == ["Links", "vrij", *word.split()]
        assert driver.page.locator("#line-front").get_attribute("data-decision") == view
        look = "getComputedStyle(document.querySelector('#line-left .bar')).backgroundImage"
        assert "repeating" in driver.page.evaluate(look)
        driver.state(view=ALL_SEEN)
        assert "repeating" not in driver.page.evaluate(look)


def test_the_simulation_banner_shows_whenever_the_host_simulates(driver, host):
    simulation = driver.page.get_by_text("SIMULATIE", exact=True)
    assert not simulation.is_visible()
    driver.state(simulated=True)
    assert simulation.is_visible()


def test_a_relay_that_nothing_monitors_is_shown_for_as_long_as_it_is_so(driver):
    banner = driver.page.get_by_text("Relais niet bewaakt", exact=True)
    driver.state(relay_checked=True)
    assert not banner.is_visible()
    driver.state(relay_checked=False)
    driver.advance(20_000)
    assert banner.is_visible()
    driver.state(state="disarmed", you=False, owner="nobody")
    assert banner.is_visible()


def test_who_drives_what_the_chair_does_and_the_link_age_are_shown(driver):
    driver.state(motion="turn")
    driver.advance(1200)
    words = driver.text("header .facts")
    assert "Jij bestuurt" in words
    assert "Draait" in words
    assert " ms" in driver.text("#link-age")


def test_the_speed_is_the_measured_one_and_not_known_without_it(driver):
    measured = {"m_s": -0.42, "deg_s": 13.0, "sigma_m_s": 0.02, "age_s": 0.1}
    for news, words in (
        ({"motion": "backward", "speed": measured}, "Rijdt achteruit 0,4 m/s"),
        ({"motion": "turn", "speed": measured}, "Draait 15°/s"),
        ({"motion": "turn", "speed": None}, "Draait \u2013"),
        ({"motion": "stopped", "speed": measured}, "Staat stil"),
    ):
        driver.state(**news, output_permille=[-500, 0])
        assert driver.text("#motion") == words


def test_assist_is_shown_on_vooruit_and_when_it_steers_or_waits(driver):
    place = driver.page.locator("#forward").bounding_box()
    for news, words in (
        ([True, False, False], "Rijhulp"),
        ([True, True, False], "Rijhulp stuurt mee"),
        ([True, True, True], "Rijhulp wacht: staat daar iemand?"),
        ([False, False, True], "Rijhulp ziet te weinig"),
    ):

        def says(news=news, words=words):
            driver.state(assist=news)
            sign = driver.page.locator("#assist-sign")
            return sign.count() and sign.inner_text() == words

        wait_until(says, words)
    driver.state(assist=None)
    assert not driver.page.locator("#assist-sign").is_visible()
    assert driver.page.locator("#forward").bounding_box() == place


@pytest.mark.parametrize("file", ["late.js", "assist_sign.js"])
def test_assist_that_does_not_load_is_told_and_fetched_again(driver, file):
    page = driver.page
    page.route(f"**/{file}", lambda route: route.abort())
    news = {"assist": [True, True, False]}
    driver.wait_until(
        lambda: driver.state(**news) or driver.advance(100) or "geladen" in driver.text("#status"),
        "what is missing",
    )
    page.unroute(f"**/{file}")
    driver.wait_until(
        lambda: driver.advance(500) or page.locator("#assist-sign").count(), "the sign"
    )
    wait_until(
        lambda: driver.state(**news) or driver.text("#assist-sign") == "Rijhulp stuurt mee", "it"
    )


def test_what_was_told_before_a_part_had_loaded_is_never_shown(driver):
    page = driver.page
    page.route("**/assist_sign.js", lambda route: route.abort())
    for _ in range(20):
        driver.state(assist=[True, True, False])
        driver.advance(100)
    page.unroute("**/assist_sign.js")
    part = "window.shown = []; export function show(news) { window.shown.push(news[1]); }"
    page.route(
        "**/assist_sign.js",
        lambda route: route.fulfill(body=part, content_type="text/javascript"),
    )
    driver.wait_until(
        lambda: (
            driver.state(assist=[True, False, False])
            or driver.advance(500)
            or page.evaluate("window.shown?.length")
        ),
        "the part",
    )
    assert not any(page.evaluate("window.shown"))


def test_the_picture_is_drawn_and_then_acknowledged(driver, host):
    assert driver.data("picture") == "none"
    host.show(picture(640, 360), 7)
    wait_until(lambda: host.acknowledged, "an acknowledgement")
    driver.advance(100)
    assert host.acknowledged == ["7"]
    assert driver.data("picture") == "fresh"
    # The worker draws; the page's element takes its size with the next frame of the screen.
    width = "document.getElementById('picture').width"
    wait_until(lambda: driver.page.evaluate(width) == 640, "the picture's size")


@pytest.mark.parametrize("age_ms", [0, 450])
def test_an_old_picture_is_marked(driver, host, age_ms):
    shown = itertools.count(1)

    def fresh() -> bool:  # its thread's clock is the machine's: one that decodes late is older
        number = next(shown)
        host.show(picture(640, 360), number, age_ms)
        wait_until(lambda: len(host.acknowledged) == number, "an acknowledgement")
        driver.run_for(25)
        return driver.data("picture") == "fresh"

    wait_until(fresh, "a fresh picture")
    driver.advance(550 - age_ms)
    assert driver.data("picture") == "stale"
    assert driver.page.get_by_text("beeld oud").is_visible()
    number = next(shown)
    host.show(picture(640, 360), number)
    wait_until(lambda: len(host.acknowledged) == number, "an acknowledgement")
    driver.advance(25)
    assert driver.data("picture") == "fresh"


def test_a_broken_picture_is_acknowledged_and_does_not_count_as_fresh(driver, host):
    host.show(b"\xff\xd8 not a JPEG", 3)
    wait_until(lambda: host.acknowledged, "an acknowledgement")
    driver.advance(100)
    assert driver.data("picture") == "none"


def test_english_by_address(page, host):
    driver = Driver(page, host)
    driver.open("?lang=en")
    assert driver.text("#forward") == "Forward"
    assert page.evaluate("document.documentElement.lang") == "en"


def test_dutch_is_the_page_of_its_own_accord(driver):
    for target, word in {"forward": "Vooruit", "left": "Links", "right": "Rechts"}.items():
        assert driver.text(f"#{target}") == word


def test_nothing_in_the_page_is_touched_when_nothing_changed(driver):
    driver.advance(1200)
    driver.page.evaluate(
        "() => { window.touched = []; new MutationObserver(l => touched.push(...l)).observe("
        "document, {subtree: true, childList: true, attributes: true, characterData: true}); }"
    )
    for heading in range(8):
        driver.state(heading_deg=float(heading), output_permille=[0, 12 * heading])
    assert driver.page.evaluate("touched.length") == 0


def test_until_the_chair_is_tuned_the_corner_says_so_calmly(driver):
    driver.state(message="untuned", tuned=False, turned=None)
    driver.run_for(25)
    assert driver.page.locator("#status[data-level=ok]").count() == 1
    assert "nog niet ingemeten" in driver.text("#status")
    assert "Laatste stap" not in driver.text("#status")
    driver.state(turned=[7, 10])
    driver.run_for(25)
    assert "Laatste stap: 7 van 10 graden." in driver.text("#status")
    driver.state(message="ok", tuned=True, turned=None)
    driver.run_for(25)
    assert "ingemeten" not in driver.text("#status")
