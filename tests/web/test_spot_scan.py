"""A spot in the picture by one switch: a column, then a cell of it; a choice moves nothing."""

import pytest

from fakehost import picture
from gazemeasure.go.floor import SWITCHED
from pagelooks import OVERFLOWING
from patience import wait_until
from pluginrows import WELL, offer
from plugintiles import more, named
from webscanner import opened

pytestmark = pytest.mark.browser

LOOK = {
    "kind": "spot",
    "name": "go-look",
    "icon": "~",
    "names": {"nl": "Ga waar ik kijk", "en": "Go where I look"},
    "aspect": 4 / 3,
    "top": 0.3,
    "of": "look",
    **WELL,
}
MODE = "go-look-7"
SPOT = {"kind": "look", "tile": "go-look", "mode": MODE, "at": [0.5, 0.8], "state": "ready"}
SPOT |= {"reason": "", "px": [[0.5, 0.9], [0.5, 0.8]]}
TILES = ["pick-back", "plugin-go"]
# On a screen of 1920 by 1080 a picture of 4 by 3 is 1440 high, and starts 180 above it.
TOP = 0.3 * 1440 - 180
BARS = "() => [...document.querySelectorAll('.spot-bar')].map(e => e.id)"


def columns(first):
    return [f"column-{n}" for n in range(first, first + 4)]


def cells(column, first):
    return [f"cell-{column}-{n}" for n in range(first, first + 4)]


def spots(person):
    return [m["at"] for m in person.received("spot") if m["at"] is not None]


@pytest.fixture
def choosing(page, host):
    """One switch, and the choice of a spot is open."""
    return chooses(opened(page, host, scan_gaze=False))


def chooses(scanner):
    offer(scanner.host, LOOK)
    named(scanner, "Ga waar ik kijk")
    more(scanner)
    scanner.choose(["plugin-1"])
    scanner.up()
    scanner.advance(300)
    assert scanner.data("view") == "pick"
    scanner.forget()
    return scanner


def pick(scanner, *path):
    scanner.choose(*path)
    scanner.up()
    scanner.advance(100)


def test_a_column_then_a_cell_choose_a_spot(choosing):
    across, down = SWITCHED
    assert choosing.page.evaluate(BARS) == [f"column-{n}" for n in range(across)]
    assert "Kies de plek met de schakelaar" in choosing.text("#status")
    assert choosing.lit() == ["stop"]
    choosing.wait_for(*columns(4))
    pick(choosing, columns(4), ["column-6"])
    assert spots(choosing) == []
    assert choosing.page.evaluate(BARS) == [f"cell-6-{n}" for n in range(down)]
    pick(choosing, cells(6, 4), ["cell-6-5"])
    x, y = 6.5 * 1920 / across, TOP + 5.5 * (1080 - TOP) / down
    assert spots(choosing) == [pytest.approx([x / 1920, (y + 180) / 1440], abs=0.001)]
    assert choosing.page.evaluate(BARS)[0] == "column-0"
    kinds = {m["k"] for m in choosing.received("cmd", "mode", "drive", "watch")}
    assert kinds == set()


def test_the_bars_leave_words_and_targets_as_they_are(choosing, artefact):
    stop = choosing.page.locator("#stop").bounding_box()
    pick(choosing, columns(4), ["column-6"])
    choosing.wait_for(*cells(6, 4))
    choosing.host.show(picture(640, 480), 1)
    wait_until(lambda: choosing.host.acknowledged, "the picture")
    choosing.run_for(50)
    artefact("driver-pick-scan")
    assert choosing.page.evaluate(OVERFLOWING) == []
    assert choosing.page.locator("#stop").bounding_box() == stop


def test_what_is_shown_starts_by_its_tile_alone_and_any_press_stops_it(choosing):
    pick(choosing, columns(0), ["column-1"], cells(1, 8), ["cell-1-9"])
    choosing.host.welcome["modes"] = [{"mode": MODE, "auto": True}]
    choosing.host.say(choosing.host.welcome)
    choosing.state(spot=SPOT)
    choosing.advance(100)
    choosing.forget()
    pick(choosing, columns(8), ["column-8"])
    assert choosing.received("mode") == []
    choosing.choose(TILES, ["plugin-go"])
    assert choosing.received("mode")[0]["mode"] == MODE
    edge = choosing.received("mode")[0]["edge"]
    rides = {"mode": MODE, "kind": "look", "name": "", "state": "drives", "goal": {}}
    rides |= {"reason": "", "px": SPOT["px"]}
    choosing.state(auto=[MODE, ""], going=rides, motion="forward")
    choosing.forget()
    choosing.advance(1000)
    assert choosing.lit() == ["stop"]
    assert choosing.page.evaluate(BARS) == []
    held = choosing.received("mode", "stop")  # supervises it, as the bars go too
    assert len(held) >= 36
    assert {(m["k"], m.get("edge")) for m in held} == {("mode", edge)}
    choosing.up()
    choosing.advance(500)
    choosing.forget()
    choosing.down()
    assert choosing.received("stop")
    choosing.advance(200)
    choosing.up()
    choosing.advance(500)
    assert choosing.received("mode") == []


def test_a_press_at_stop_is_a_stop_and_back_closes(choosing):
    pick(choosing, columns(0), ["column-1"])
    choosing.wait_for("stop")
    choosing.down()
    assert choosing.received("stop")
    choosing.advance(100)
    choosing.up()
    assert spots(choosing) == []
    pick(choosing, TILES, ["pick-back"])
    assert choosing.data("view") == "drive"
    assert choosing.page.evaluate(BARS) == []


def test_one_by_one_and_with_an_old_picture(page, host):
    scanner = chooses(opened(page, host, scan="single", scan_ms=500))
    for name in ("stop", "plugin-go", "pick-back", "column-0", "column-1"):
        scanner.wait_for(name)
    host.show(picture(640, 480), 1)
    wait_until(lambda: host.acknowledged, "the picture")
    scanner.advance(300)
    assert len(scanner.page.evaluate(BARS)) == SWITCHED[0]
    scanner.advance(1000)
    assert scanner.data("picture") == "stale"
    scanner.advance(200)
    assert scanner.page.evaluate(BARS) == []


def test_driving_stays_on_until_every_choice_was_lit(page, host):
    scanner = chooses(opened(page, host, scan="single", scan_ms=800, auto_off_s=10))
    scanner.wait_for(f"column-{SWITCHED[0] - 1}")
    scanner.press()
    assert scanner.received("disarm") == []
    scanner.wait_for(f"cell-{SWITCHED[0] - 1}-{SWITCHED[1] - 1}")
    assert scanner.received("disarm") == []
    for _ in range(40):
        scanner.advance(1000)
    assert scanner.received("disarm")


def test_a_pointer_does_not_watch_for_a_driver_who_scans_without_gaze(choosing):
    choosing.state(auto=[MODE, ""], going={"mode": MODE, "kind": "look", "state": "drives"})
    choosing.forget()
    for at in range(20):
        choosing.look((0.3 + at / 50, 0.5))
        choosing.run_for(50)
    assert choosing.received("watch") == []


def test_who_scans_and_looks_chooses_by_one_dwell(page, host):
    scanner = chooses(opened(page, host))
    scanner.advance(1300, look=(0.5, 0.5))
    assert spots(scanner) == [pytest.approx([0.5, 0.5], abs=0.003)]


def test_the_bars_are_for_scanning_alone(driver):
    driver.forget()
    offer(driver.host, LOOK)
    named(driver, "Ga waar ik kijk")
    more(driver)
    driver.hover("plugin-1")
    assert driver.data("view") == "pick"
    driver.advance(500)
    assert driver.page.evaluate(BARS) == []
