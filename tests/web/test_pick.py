"""A spot of the picture: chosen by a dwell or a tap, shown, and started by its own tile alone."""

import pytest

from fakehost import picture
from pagelooks import OVERFLOWING, REST, on_every_screen
from patience import wait_until
from pluginrows import WELL, offer
from plugintiles import more, named

pytestmark = pytest.mark.browser

NAMES = {"nl": "Volg lijn", "en": "Follow line"}
LINE = {
    "kind": "spot",
    "name": "follow-line",
    "icon": "~",
    "names": NAMES,
    "aspect": 4 / 3,
    "of": "line",
}
LINE |= WELL
MODE = "follow-line-3"
PX = [[0.5, 0.9], [0.5, 0.7], [0.45, 0.55]]
SPOT = {
    "kind": "line",
    "tile": "follow-line",
    "mode": MODE,
    "at": [0.5, 0.8],
    "state": "ready",
    "reason": "",
}
SPOT["px"] = PX
RIDES = {"mode": MODE, "kind": "line", "name": "Volg lijn", "state": "drives", "goal": {}}
RIDES |= {"reason": "line_follows", "px": PX}
FREE = (0.5, 0.5)
ENLARGED = "() => document.querySelector('#picture').style.transform"
CENTRE = """() => document.querySelector('#picture').style.transformOrigin.split(' ')
  .map(parseFloat)"""


def enlarged(person):
    return person.page.evaluate(ENLARGED) == "scale(3)"


def sent_messages(person):
    """Everything that was sent, except heartbeats."""
    found = []
    for m in person.received("cmd", "mode", "stop", "spot", "arm", "disarm"):
        what = (m["k"], m.get("mode"), m.get("at"))
        if not found or found[-1] != what:
            found.append(what)
    person.forget()
    return found


def opened(person):
    """Open the view by a dwell on its tile."""
    offer(person.host, LINE)
    named(person, "Volg lijn")
    more(person)
    person.forget()
    person.hover("plugin-1")
    assert person.data("view") == "pick"
    sent = person.received("mode", "cmd", "spot")
    assert {m["k"] for m in sent} == {"spot"}
    assert {m["at"] for m in sent} == {None}
    person.forget()


def ready(person):
    """The host's answer to the choice."""
    person.host.welcome["modes"] = [{"mode": MODE, "auto": True}]
    person.host.say(person.host.welcome)
    person.state(spot=SPOT)
    person.advance(100)
    person.forget()


def test_a_dwell_on_the_picture_chooses_a_spot_and_moves_nothing(driver):
    opened(driver)
    driver.advance(700, look=FREE)
    assert not enlarged(driver)  # not yet as long as a button
    driver.advance(700, look=FREE)
    assert enlarged(driver)
    assert sent_messages(driver) == []
    driver.advance(1000, look=FREE)
    ((kind, _, at),) = sent_messages(driver)
    assert kind == "spot"
    assert not enlarged(driver)
    # 1920 by 1080 shows the middle of a picture of 4 by 3.
    assert at == pytest.approx([0.5, 0.5], abs=0.01)
    driver.advance(3000, look=FREE)
    assert sent_messages(driver) == []  # once
    driver.look((0.45, 0.6))
    driver.advance(200)
    assert driver.page.locator("#over-picture .ring").count() == 1
    driver.advance(500)  # nobody looks
    assert driver.page.locator("#over-picture .ring").count() == 0
    driver.page.mouse.click(1920 * 0.4, 1080 * 0.75)
    ((kind, _, at),) = sent_messages(driver)
    assert at == pytest.approx([0.4, (0.75 * 1080 + 180) / 1440], abs=0.01)


def test_the_second_look_is_three_times_as_exact(driver):
    opened(driver)
    driver.advance(1200, look=FREE)
    assert enlarged(driver)
    driver.advance(50)
    assert "Vergroot" in driver.text("#status")
    assert driver.page.evaluate(OVERFLOWING) == []
    # The intended spot was to the right and below: now it is three times as far off.
    driver.advance(1200, look=(0.5 + 0.09, 0.5 + 0.12))
    ((_, _, at),) = sent_messages(driver)
    assert at == pytest.approx([0.53, (0.54 * 1080 + 180) / 1440], abs=0.003)
    driver.advance(3000, look=(0.5 + 0.09, 0.5 + 0.12))
    assert sent_messages(driver) == []
    assert not enlarged(driver)


def test_what_is_shown_lies_on_the_enlarged_picture(driver):
    opened(driver)
    ready(driver)
    driver.advance(2300, look=FREE)  # who reads takes twice as long
    assert enlarged(driver)
    x, y = driver.page.evaluate(CENTRE)  # of its first dwell
    points = driver.page.locator("#over-picture .way").get_attribute("points").split()
    found = [float(one) for one in points[0].split(",")]
    whole = 0.5 * 1920, 0.9 * 1440 - 180
    assert found == pytest.approx([x + 3 * (whole[0] - x), y + 3 * (whole[1] - y)], abs=1)
    # Who reads what to do looks back then; a look at a tile shows the whole picture.
    driver.advance(300, look="status")
    assert enlarged(driver)
    driver.advance(100, look="pick-back")
    assert not enlarged(driver)


def test_a_finger_needs_no_second_look_and_means_what_is_shown(driver):
    opened(driver)
    driver.advance(1200, look=FREE)
    assert enlarged(driver)
    driver.page.mouse.click(1920 * 0.59, 1080 * 0.5)
    ((_, _, at),) = sent_messages(driver)
    assert at == pytest.approx([0.53, 0.5], abs=0.003)
    assert not enlarged(driver)
    driver.page.mouse.click(1920 * 0.4, 1080 * 0.5)
    ((_, _, at),) = sent_messages(driver)
    assert at == pytest.approx([0.4, 0.5], abs=0.003)


def test_driving_off_ends_an_enlarged_picture(driver):
    opened(driver)
    driver.advance(1200, look=FREE)
    assert enlarged(driver)
    driver.state(state="disarmed", you=False, owner="nobody")
    assert not enlarged(driver)
    assert driver.data("view") == "drive"
    assert driver.received("spot") == []  # the host would refuse it: nobody drives


def test_what_is_shown_starts_by_its_tile_and_by_nothing_else(driver):
    opened(driver)
    driver.hover("plugin-go")
    assert sent_messages(driver) == []  # nothing is shown yet
    ready(driver)
    points = driver.page.locator("#over-picture .way").get_attribute("points").split()
    assert points[0] == f"960,{round(0.9 * 1440 - 180)}"
    driver.advance(6000, look=(0.5, 0.62))
    assert {kind for kind, *_ in sent_messages(driver)} <= {"spot"}
    driver.hover("plugin-go")
    assert [what for what in sent_messages(driver) if what[0] != "spot"] == [("mode", MODE, None)]
    # It rides: looks at the picture only watch.
    driver.state(auto=[MODE, ""], going=RIDES)
    driver.advance(4400, look=FREE)
    assert driver.received("watch")
    assert sent_messages(driver) == []
    assert driver.text("#plugin-go .label") == "Pauze"
    assert driver.page.locator("#over-picture .way").count() == 1
    driver.advance(650, look="plugin-go")
    assert sent_messages(driver) == [("stop", None, None)]
    driver.state(auto=["", MODE], going={**RIDES, "state": "ended", "reason": "going_stopped"})
    assert driver.text("#plugin-go .label") == "Verder"


def test_a_tap_on_ga_starts_it_and_its_end_is_no_stop(driver):
    opened(driver)
    ready(driver)
    driver.advance(400, look=FREE)
    driver.forget()
    driver.page.locator("#plugin-go").click()
    driver.advance(300)
    assert [what for what in sent_messages(driver) if what[0] != "spot"] == [("mode", MODE, None)]


def test_back_stop_and_driving_off_end_it(driver):
    opened(driver)
    ready(driver)
    driver.state(auto=[MODE, ""], going=RIDES)
    driver.page.locator("#pick-back").click()
    driver.advance(50)
    sent = sent_messages(driver)
    assert ("stop", None, None) in sent
    assert ("spot", None, None) in sent
    assert driver.data("view") == "drive"
    assert not driver.page.locator("#over-picture .way").count()
    ended = {**RIDES, "state": "ended", "reason": "going_stopped"}
    driver.state(auto=["", MODE], spot=None, going=ended)
    driver.advance(50)
    assert "Gestopt op de lijn" in driver.text("#status")
    assert "Verder" not in driver.text("#status")
    driver.state(going=None)
    driver.hover("plugin-1")
    assert driver.data("view") == "pick"
    driver.forget()
    driver.page.locator("#stop").click()
    assert ("stop", None, None) in sent_messages(driver)
    driver.state(state="disarmed", you=False, owner="nobody")
    assert driver.data("view") == "drive"


def test_no_line_there_is_told_and_starts_nothing(driver):
    opened(driver)
    driver.advance(50)
    assert "Kijk naar de lijn op de vloer" in driver.text("#status")
    driver.state(spot={**SPOT, "mode": "", "px": [], "state": "ended", "reason": "line_no_line"})
    driver.advance(50)
    assert "Daar is geen lijn" in driver.text("#status")
    driver.hover("plugin-go")
    assert "mode" not in {kind for kind, *_ in sent_messages(driver)}


def test_another_tiles_spot_or_a_mode_that_is_not_offered_starts_nothing(driver):
    opened(driver)
    driver.state(spot={**SPOT, "tile": "another"})
    driver.hover("plugin-go")
    driver.state(spot=SPOT)  # the welcome has no such mode
    driver.hover("plugin-go")
    driver.page.locator("#plugin-go").click()
    assert "mode" not in {kind for kind, *_ in sent_messages(driver)}


def test_an_old_picture_shows_nothing_to_choose(driver, host):
    host.show(picture(), 1)
    wait_until(lambda: host.acknowledged, "the picture")
    opened(driver)
    driver.advance(1000)
    assert driver.data("picture") == "stale"
    driver.advance(2500, look=FREE)
    driver.page.mouse.click(1920 * 0.4, 1080 * 0.75)
    assert sent_messages(driver) == []


def test_the_view_keeps_the_rules(driver, page, host):
    host.show(picture(), 1)
    wait_until(lambda: host.acknowledged, "the picture")
    for width, _ in on_every_screen(page):
        before = page.locator("#stop").bounding_box()
        opened(driver)
        ready(driver)
        assert page.locator("#stop").bounding_box() == before
        assert page.evaluate(OVERFLOWING) == []
        assert page.evaluate(REST) >= 0.35
        driver.screenshot(f"driver-pick-{width}")
        page.locator("#pick-back").click()
        driver.state(spot=None)
        page.locator("#mode").click()  # from the page of modes to the directions
        driver.advance(100)
        assert driver.data("view") == "drive"
