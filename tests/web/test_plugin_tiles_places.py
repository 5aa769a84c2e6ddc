"""Where the tiles of modes are, their number, and their texts."""

import pytest

from fakehost import picture
from pagelooks import OVERFLOWING, REST, on_every_screen
from patience import wait_until
from pluginrows import WELL, lost, mode, offer
from plugintiles import AHEAD, FOLLOW, HOME, TWENTY, begin, more, moves, shown, tiled
from webperson import BOX, Driver

pytestmark = pytest.mark.browser


# How many, and where


BOXES = f"names => Object.fromEntries(names.map(name => [name, ({BOX})('#' + name)]))"
LABELS = "names => names.map(name => document.querySelector(`#${name} .label`).textContent)"


def boxes(person):
    return person.page.evaluate(BOXES, shown(person))


@pytest.mark.parametrize("backward", [False, True], ids=["", "backward"])
def test_twenty_modes_have_pages_of_three_and_every_page_keeps_the_rules(page, host, backward):
    host.welcome["backward"] = backward
    person = Driver(page, host)
    person.open()
    without = {size: boxes(person) for size in on_every_screen(page)}
    tiled(person, *TWENTY)
    for size in on_every_screen(page):
        before = without[size]
        assert ("plugin-0" in shown(person)) == (not backward)
        now = boxes(person)
        assert {name: now[name] for name in now if name in before} == {
            name: box for name, box in before.items() if name in now
        }
        more(person)
        seen = []
        for _ in range(7):
            found = boxes(person)
            assert len(found) <= 7
            assert found["stop"] == before["stop"]
            assert page.evaluate(REST) >= 0.35
            assert page.evaluate(OVERFLOWING) == []
            tiles = [name for name in found if name.startswith("plugin")]
            for name in tiles:
                assert found[name]["width"] >= 390 / 1920 * size[0]
            seen += page.evaluate(LABELS, tiles)
            page.locator("#next").click()
            person.advance(50)
        assert seen == [row["names"]["nl"] for row in TWENTY]
        assert page.locator("#plugin-1 .label").text_content() == "Mode0"
        page.locator("#mode").click()
        assert boxes(person) == now


def test_the_page_of_modes_drives_and_directions_are_not_behind_it(driver, host, artefact):
    host.show(picture(), 1)
    wait_until(lambda: host.acknowledged, "the picture")
    tiled(driver, AHEAD, lost(HOME, "plugin_hangs"), FOLLOW, mode("zigzag"))
    driver.advance(25)
    artefact("driver-mode-beside")
    more(driver)
    artefact("driver-modes")
    driver.page.keyboard.down("ArrowUp")
    driver.advance(100)
    driver.page.keyboard.up("ArrowUp")
    assert moves(driver) == []
    driver.hover("plugin-3")
    assert moves(driver) == [("mode", "follow", 1)]
    driver.page.locator("#next").click()
    driver.advance(100)
    assert [name for name in shown(driver) if name.startswith("plugin")] == ["plugin-1"]
    driver.forget()
    driver.hover("plugin-1")
    assert moves(driver) == [("mode", "zigzag", 2)]


def test_a_tile_that_comes_under_the_gaze_is_not_chosen(driver):
    driver.advance(400, look=(0.5, 0.8))
    tiled(driver, AHEAD)
    driver.advance(3000, look=(0.5, 0.8))
    assert moves(driver) == []
    tiled(driver, HOME)
    driver.advance(3000, look=(0.5, 0.8))
    assert moves(driver) == []
    driver.hover("plugin-0")
    assert moves(driver) == [("mode", "home", 1)]


def test_a_gaze_that_rests_where_more_or_next_puts_a_tile_chooses_nothing(driver):
    tiled(driver, *TWENTY[:4])
    driver.page.locator("#mode").click()
    left = driver.spot("left")
    where = (left[0] / 1920, left[1] / 1080)
    driver.advance(100, look=where)
    for button in ("mode", "next", "next"):
        driver.page.locator(f"#{button}").evaluate("e => e.click()")  # by a key or a voice
        driver.advance(2000, look=where)
        assert moves(driver) == [], button
    driver.hover("plugin-2")
    assert moves(driver) == [("mode", "mode1", 1)]


def test_modes_come_and_go_while_the_page_is_open(driver):
    tiled(driver, AHEAD, HOME)
    more(driver)
    begin(driver, "plugin-2", "touch")
    driver.advance(200)
    assert moves(driver) == [("mode", "home", 1)]
    offer(driver.host, HOME, FOLLOW)  # home has another place now
    driver.advance(300)
    assert moves(driver) == [("stop", None, None)]
    driver.fingers.lift(1)
    offer(driver.host)
    driver.advance(100)
    assert driver.data("mode") == "continuous"
    assert not [name for name in shown(driver) if name.startswith(("plugin", "next"))]
    assert {"forward", "left", "right", "stop", "help"} <= set(shown(driver))
    tiled(driver, AHEAD)
    assert "plugin-0" in shown(driver)


# Texts from outside

HOSTILE = {
    "long": "x" * 200,
    "words": "een heel lange naam " * 20,
    "html": "<img src=x onerror=alert(1)>",
    "rtl": "\u202eadbil\u202c שלום",
    "marks": "Z" + "\u0336\u0310\u0325" * 60,
    "emoji": "👩‍👩‍👧‍👦" * 10,
    "empty": "",
    "space": " \u00a0\t",
    "null": None,
    "number": 7,
}


@pytest.mark.parametrize("language", ["nl", "en"])
def test_hostile_names_stay_on_their_tiles_and_are_no_html(page, host, language):
    rows = [mode(name, icon=text, names={"nl": text, "en": text}) for name, text in HOSTILE.items()]
    rows.append(mode("bare", icon=None, names=None))
    rows.append(mode("broken", names=["nl"], **{**WELL, "state": "lost", "reason": None}))
    host.welcome.update(plugins=rows, modes=[{"mode": row["name"]} for row in rows])
    person = Driver(page, host)
    person.open(f"?lang={language}")
    wait_until(lambda: page.locator("#plugin-1 .label").count(), "the tiles")
    person.advance(100)
    more(person)
    for _ in range(4):
        assert page.evaluate(OVERFLOWING) == []
        assert page.locator("img").count() == 0
        for place in (1, 2, 3):
            label = page.locator(f"#plugin-{place} .label").text_content()
            assert 0 < len(label.strip()) <= 40
            assert page.locator(f"#plugin-{place} text").text_content().strip()
            ink = page.locator(f"#plugin-{place}").evaluate(
                "e => [...e.children].every(c => getComputedStyle(c).overflow === 'hidden')"
            )
            assert ink
        person.screenshot(f"driver-hostile-{language}-{_}")
        page.locator("#next").click()
        person.advance(50)
    person.forget()
    person.hover("plugin-1")
    assert person.received("mode")[0]["mode"] == "long"
