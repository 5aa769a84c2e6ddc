"""The page's look: sizes and places of the targets, legible words, screenshots."""

import pytest

from fakehost import OFF, FakeHost, picture
from pagelooks import OVERFLOWING, REST, SCREENS, on_every_screen
from patience import wait_until
from webperson import Driver

pytestmark = pytest.mark.browser

DRIVE = ["forward", "left", "right", "backward"]
TARGETS = [*DRIVE, "stop", "arm", "mode", "menu", "help"]


@pytest.fixture(params=[False, True], ids=["", "backward"])
def shown(request, host, page):
    """The page with or without Achteruit."""
    host.welcome["backward"] = request.param
    person = Driver(page, host)
    person.open()
    return person


def boxes(driver, names):
    found = {name: driver.page.locator(f"#{name}").bounding_box() for name in names}
    return {name: box for name, box in found.items() if box}


def test_drive_targets_are_large_enough_for_gaze(shown):
    """390 px at 1920x1080 is 60 mm on a 13.3 inch tablet; other screens in proportion."""
    for screen in on_every_screen(shown.page):
        margin = 2 * 0.022 * screen[1]  # the hit area's vertical extension
        for name, box in boxes(shown, DRIVE).items():
            assert box["width"] >= 390 / 1920 * screen[0], (screen, name)
            assert box["height"] + margin >= 390 / 1080 * screen[1], (screen, name)


def test_a_third_of_the_screen_around_the_middle_never_drives(shown):
    for screen in on_every_screen(shown.page):
        assert shown.page.evaluate(REST) >= 0.35, screen


def test_hit_areas_never_touch_each_other_even_when_grown(shown):
    for screen in on_every_screen(shown.page):
        found = boxes(shown, TARGETS)
        for name, box in found.items():
            margin = 0.022 * screen[1] if name in DRIVE else 0
            width, height = box["width"], box["height"] + 2 * margin
            left, top = box["x"] - 0.1 * width, box["y"] - margin - 0.1 * height
            for other, there in found.items():
                apart = (
                    left + 1.2 * width <= there["x"]
                    or there["x"] + there["width"] <= left
                    or top + 1.2 * height <= there["y"]
                    or there["y"] + there["height"] <= top
                )
                assert other == name or apart, f"{name} grown reaches {other} on {screen}"


def test_no_target_ever_moves(shown):
    before = boxes(shown, TARGETS)
    long_one = "heading_frozen"
    for change in (
        {
            "state": "disarmed",
            "arm_reason": "relay_stuck",
            "level": "error",
            "message": "emergency",
        },
        {"state": "armed", "override": long_one, "level": "warning", "message": long_one},
        {"simulated": True, "override": "none", "motion": "backward", "level": "ok"},
    ):
        shown.state(**change)
        now = boxes(shown, TARGETS)
        assert {name: now[name] for name in now.keys() & before} == {
            name: before[name] for name in now.keys() & before
        }
        assert len(now) <= 7
    shown.hover("forward")
    assert boxes(shown, TARGETS) == before


STATES = {
    "disarmed": dict(OFF, simulated=True),
    "not-ready": dict(
        OFF,
        level="error",
        message="obstacle_data_old",
        arm_reason="obstacle_data_old",
        decisions=dict.fromkeys(DRIVE, "unknown"),
    ),
    "armed": {},
    "override": {
        "override": "obstacle_forward",
        "simulated": True,
        "decisions": {"forward": "blocked", "left": "slow", "right": "free", "backward": "blocked"},
    },
    "warning": {"level": "warning", "message": "heading_bus", "override": "heading_bus"},
    "emergency": dict(OFF, level="error", message="emergency", arm_reason="emergency"),
}


@pytest.mark.parametrize("name", STATES)
def test_every_word_fits_and_here_is_how_it_looks(page, host, name):
    host.welcome["backward"] = name in ("warning", "override")
    driver = Driver(page, host)
    for sequence, language in enumerate(("nl", "en"), 1):
        page.evaluate("spied.run(100)")
        driver.open(f"?lang={language}")
        host.show(picture(), sequence)
        wait_until(lambda n=str(sequence): n in host.acknowledged, "the picture")
        driver.state(**STATES[name])
        driver.advance(25)
        for width, height in SCREENS:
            page.set_viewport_size({"width": width, "height": height})
            driver.screenshot(f"driver-{name}-{language}-{width}")
            assert page.evaluate(OVERFLOWING) == []


def test_the_dwell_ring_and_a_held_target(page, host, driver):
    driver.advance(350, look=(0.5, 0.6))
    driver.advance(300, look="left")
    assert page.locator("#left").get_attribute("class") == "target drive dwelling"
    assert page.locator("#left .ring").is_visible()
    driver.screenshot("driver-dwell")
    driver.advance(400, look="left")
    assert page.locator("#left").get_attribute("class") == "target drive holding"
    host.show(picture(), 1)
    wait_until(lambda: host.acknowledged, "the picture")
    driver.advance(25, look="left")
    driver.screenshot("driver-holding")


# Of [key, state] each key whose words do not fit: into what is around them, above Achteruit.
UNFIT = f"""
async (states) => {{
  const box = (id) => document.getElementById(id).getBoundingClientRect();
  const overflowing = {OVERFLOWING.strip()};
  const found = [];
  for (const [key, text] of states) {{
    spied.say(text);
    await null;
    const {{ height, bottom }} = box("banner");
    const unfit = overflowing();
    if (unfit.length || !height || bottom >= box("backward").y) found.push([key, unfit, bottom]);
  }}
  return found;
}}
"""


def test_the_longest_words_fit_in_the_corner_and_the_banner(page, host: FakeHost, driver):
    messages = page.evaluate("fetch('/strings/nl.json').then(answer => answer.json())")["messages"]
    page.evaluate("document.body.dataset.backward = true")
    sent = []
    for key in messages:
        host.state.update(level="error", message=key, override=key)
        sent.append([key, host.coming_state(0)])
    for screen in on_every_screen(page):
        assert page.evaluate(UNFIT, sent) == [], screen


@pytest.mark.parametrize("language", ["nl", "en"])
def test_the_bar_has_room_for_its_longest_words(page, host, language):
    driver = Driver(page, host)
    driver.open(f"?lang={language}")
    page.evaluate("document.body.dataset.backward = true")
    driver.state(you=False, owner="driver", motion="backward", simulated=True)
    page.evaluate("document.getElementById('link-age').textContent = '1230 ms'")
    for screen in on_every_screen(page):
        facts = page.locator("#motion").bounding_box()
        simulation = page.locator(".simulation").bounding_box()
        assert facts["x"] + facts["width"] < simulation["x"], screen


def test_the_tag_on_achteruit_hides_neither_its_arrow_nor_its_word(page, driver):
    page.evaluate("document.body.dataset.backward = true")
    driver.state(decisions=dict.fromkeys(DRIVE, "blocked"))
    for screen in on_every_screen(page):
        tag = page.locator("#backward .tag").bounding_box()
        assert page.locator("#backward .tag").is_visible(), screen
        arrow = page.locator("#backward .arrow").bounding_box()
        assert tag["y"] + tag["height"] < arrow["y"], screen


def test_links_lost_and_old_pictures_look_like_it(page, host, driver):
    host.show(picture(), 1)
    wait_until(lambda: host.acknowledged, "the picture")
    driver.advance(800)
    driver.screenshot("driver-stale")
    page.evaluate("spied.run(800)")
    driver.screenshot("driver-lost")
    assert page.locator("#lost").is_visible()
