"""Maps on the pages: made while driving, drawn on by taps; a quiet one for the driver."""

import re

import numpy as np
import pytest

from gazechair.sensing.mapping.home_map import HomeMap
from gazechair.sensing.mapping.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.packed_map import unpacked
from gazechair.sensing.mapping.picture import drawn
from gazechair.sensing.mapping.ros_map import files_of
from layoutshift import WATCH, take
from patience import wait_until

pytestmark = pytest.mark.browser

CELLS = np.full((80, 60), 5, dtype=np.uint16)
CELLS[0] = 0
GRID = OccupancyGrid(0.1, np.array((-1.0, -2.0)), 5 - CELLS, CELLS)
PICTURE = drawn(HomeMap("Thuis", GRID))
ROW = {
    "map": "a1",
    "name": "Thuis",
    "made": "2026-11-22T20:00:00Z",
    "floor_m2": 40,
    "updates": 0,
    "updated": "",
    "problem": "",
}
NOTHING = {"places": [], "no_go": [], "home": None}
DETAILS = {**ROW, "picture": PICTURE.as_json(), **NOTHING}
WHERE = {"map": "a1", "x": 3.0, "y": 1.0, "heading": 90.0, "sigma": 0.02, "sigma_deg": 0.5}
IDLE = {
    "state": "no_maps",
    "wants": "know",
    "making": None,
    "ended": None,
    "where": None,
    "most_file_bytes": 5_000_000,
    "maps": [],
}
KNOWN = {**IDLE, "state": "known", "where": WHERE, "maps": [ROW]}
MAKING = {"keys": 9, "loops": 2, "driven_m": 12.4, "doubt": "", "x": 3.0, "y": 1.0, "heading": 0.0}


def test_a_caretaker_makes_a_map_and_draws_on_it(caretaker):
    host, page = caretaker.host, caretaker.page
    host.pictures |= {"a1": PICTURE.png, "growing": PICTURE.png}
    host.replies |= {
        "GET /maps/a1": (200, DETAILS),
        "GET /maps/growing": (200, {"picture": PICTURE.as_json()}),
    }

    def now(answer) -> None:
        """The host's answer from now on, and the page has shown it."""
        host.replies |= {"GET /maps": (200, answer), "POST /maps": (200, answer)}
        for _ in range(3):
            caretaker.advance(600)
            page.wait_for_load_state("networkidle")

    def told() -> str:
        return page.locator("#maps .told").inner_text()

    def posted(wish) -> None:
        wait_until(lambda: ("/maps", wish) in host.posted, f"{wish} among {host.posted[-3:]}")

    def press(text: str) -> None:
        page.locator("#maps button", has_text=text).locator("visible=true").first.click()

    now(IDLE)
    page.locator("#tab-settings").click()
    page.locator("#tab-maps").click()
    caretaker.wait_until(lambda: caretaker.advance(600) or "nog geen kaart" in told(), "the list")
    press("Kaart maken")
    posted({"make": True})
    now({**IDLE, "state": "making", "wants": "make", "making": MAKING})
    assert told() == "De kaart groeit: 12 m gereden, 2 keer teruggevonden."
    page.evaluate(WATCH)
    take(page)
    now({**IDLE, "state": "making", "wants": "make", "making": {**MAKING, "driven_m": 230.0}})
    assert take(page) == [], "nothing moves by itself"
    caretaker.screenshot("map_making")
    now({**IDLE, "wants": "make", "making": {**MAKING, "doubt": "broken"}})
    assert "telt niet mee" in told()
    page.locator("#maps .making input").fill("Thuis")
    press("Bewaren")
    posted({"save": "Thuis"})
    stored = {"reason": "", "detail": "", "map": "a1"}
    now({**KNOWN, "ended": stored})
    assert "is bewaard" in told()

    # A place: two taps, a name, a sign. The map is 8 m by 6 m.
    press("Plek")
    assert told() == "Tik waar de stoel dan staat."
    box = page.locator("#maps canvas").bounding_box()
    scale = min(box["width"] / 8.0, box["height"] / 6.0)

    def tap(x: float, y: float) -> None:
        """At these metres of the map."""
        left, top = (box["width"] - 8.0 * scale) / 2, (box["height"] - 6.0 * scale) / 2
        at = {"x": left + (x + 1.0) * scale, "y": top + (4.0 - y) * scale}
        page.locator("#maps canvas").click(position=at)

    tap(2.0, 1.0)
    tap(2.0, 3.0)
    page.locator("#maps .form input").fill("Bed van opa")
    page.locator("#maps .form select").select_option("bed")
    press("Bewaren")
    wait_until(lambda: "place" in host.posted[-1][1], "the place")
    wish = host.posted[-1][1]
    assert (wish["map"], wish["place"]["name"], wish["place"]["icon"]) == (
        "a1",
        "Bed van opa",
        "bed",
    )
    found = [wish["place"][name] for name in ("x", "y", "heading")]
    assert found == pytest.approx([2.0, 1.0, 90.0], abs=1.5)
    assert found[:2] == pytest.approx([2.0, 1.0], abs=0.1)
    # An area: three corners or more; a refusal is told in plain words.
    press("Verboden gebied")
    for corner in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)):
        tap(*corner)
    host.replies["POST /maps"] = (400, {"reason": "map_area", "detail": "no extent"})
    press("Klaar")
    wait_until(lambda: "no_go" in host.posted[-1][1], "the area")
    assert len(host.posted[-1][1]["no_go"]) == 3
    caretaker.wait_until(lambda: "geen gebied" in told(), "why not")
    # Removed and deleted only at the second press.
    place = {"number": 1, "name": "Bed", "icon": "bed", "x": 2.0, "y": 1.0, "heading": 90.0}
    host.replies["GET /maps/a1"] = (200, {**DETAILS, "places": [place]})
    now({**KNOWN, "maps": [{**ROW, "name": "Ons huis"}]})
    caretaker.wait_until(lambda: page.locator("#maps li").count() == 1, "the place's row")
    caretaker.screenshot("map_drawn")
    before = len(host.posted)
    delete = page.locator("#maps .rename .sure", has_text="verwijderen")
    delete.click()
    assert len(host.posted) == before
    caretaker.advance(1000)
    page.locator("#maps .rename .sure", has_text="Zeker weten").click()
    posted({"map": "a1", "delete": True})


def test_a_caretaker_takes_files_home_and_a_change_back(caretaker):
    host, page = caretaker.host, caretaker.page
    host.pictures["a1"] = PICTURE.png
    host.replies |= {
        "GET /maps": (200, KNOWN),
        "GET /maps/a1": (200, DETAILS),
        "POST /maps": (200, KNOWN),
    }
    back = page.locator("#maps .rename .sure", has_text="Aanpassing terugnemen")
    page.locator("#tab-settings").click()
    page.locator("#tab-maps").click()
    files = page.locator("#maps button", has_text="Kaart als bestand")
    caretaker.wait_until(lambda: caretaker.advance(600) or files.is_visible(), "the map")
    assert not back.is_visible()  # no drive has changed it
    with page.expect_download() as download:
        files.click()
    assert download.value.url.endswith("/maps/a1.zip")
    host.replies["GET /maps/a1"] = (
        200,
        {**DETAILS, "updates": 1, "updated": "2026-11-23T10:05:00Z"},
    )
    page.locator("#maps select").first.dispatch_event("change")
    caretaker.wait_until(back.is_visible, "what can be taken back")
    when = page.locator("#maps .rename .note").inner_text()
    assert re.fullmatch(
        r"Laatste aanpassing door rijden: 2[34] november 2026 om \d\d:05\.", when
    ), when
    caretaker.screenshot("map_back")
    for one in page.locator("#maps .rename button").all():
        assert one.evaluate("one => one.scrollWidth <= one.clientWidth"), one.inner_text()
    before = len(host.posted)
    size = [back.bounding_box()[side] for side in ("width", "height")]
    back.click()
    sure = page.locator("#maps .rename .sure", has_text="Zeker weten")
    assert [sure.bounding_box()[side] for side in ("width", "height")] == size
    assert len(host.posted) == before
    host.replies["GET /maps/a1"] = (200, DETAILS)
    caretaker.advance(1000)
    page.locator("#maps .rename .sure", has_text="Zeker weten").click()
    wait_until(lambda: ("/maps", {"map": "a1", "back": True}) in host.posted, "the wish")
    caretaker.wait_until(lambda: not back.is_visible(), "nothing to take back any more")


def chosen(page, *files: tuple[str, bytes]) -> None:
    """Files of the phone, chosen as a person does."""
    with page.expect_file_chooser() as chooser:
        page.locator("#maps button", has_text="Kaart uit een bestand").click()
    kind = "application/octet-stream"
    chooser.value.set_files([{"name": n, "mimeType": kind, "buffer": b} for n, b in files])


def test_a_caretaker_brings_a_map_of_files(caretaker):
    host, page = caretaker.host, caretaker.page
    other = {**ROW, "map": "b2", "name": "Kantoor"}
    host.pictures |= {"a1": PICTURE.png, "b2": PICTURE.png}
    both = {**KNOWN, "maps": [ROW, other], "added": "b2"}
    host.replies |= {
        "GET /maps": (200, KNOWN),
        "GET /maps/a1": (200, DETAILS),
        "GET /maps/b2": (200, {**DETAILS, **other}),
    }
    page.locator("#tab-settings").click()
    page.locator("#tab-maps").click()

    def told(text: str) -> None:
        caretaker.wait_until(
            lambda: caretaker.advance(600) or text in page.locator("#maps .told").inner_text(), text
        )

    told("weet waar hij is")
    # What it is refused for is told, and the same file can be chosen once more.
    host.replies["POST /maps/import"] = (400, {"reason": "map_file_zip", "detail": "no zip"})
    for number in (1, 2):
        chosen(page, ("map.zip", b"nothing"))
        told("geen zip met een kaart")
        wait_until(lambda n=number: len(host.files) == n, "the file")  # type: ignore[misc]
    # A file that is too large is not even sent.
    chosen(page, ("film.zip", bytes(5_000_001)))
    told("hoogstens 5 MB")
    assert host.files == [b"nothing", b"nothing"]
    # Several become one zip file, which the host understands.
    host.replies |= {"POST /maps/import": (200, both), "GET /maps": (200, both)}
    made = files_of(HomeMap("Kantoor", GRID))
    chosen(page, *made.items())
    told("is bewaard")
    line, press = (
        page.locator(f"#maps {name}").bounding_box() for name in (".told", "button.import")
    )
    assert 0 < line["y"] - press["y"] < 70  # beside what was pressed: never scrolled away
    found = unpacked(host.files[-1])
    assert found.name == "Kantoor"
    assert (found.grid.occupied == GRID.occupied).all()
    assert page.locator("#maps select").first.input_value() == "b2"
    assert page.locator("#maps .rename input").input_value() == "Kantoor"
    caretaker.screenshot("map_import")
    # And while a map is made, nothing else begins.
    making = {**both, "state": "making", "wants": "make", "making": MAKING}
    host.replies |= {
        "GET /maps": (200, making),
        "GET /maps/growing": (200, {"picture": PICTURE.as_json()}),
    }
    host.pictures["growing"] = PICTURE.png
    button = page.locator("#maps button", has_text="Kaart uit een bestand")
    caretaker.wait_until(
        lambda: caretaker.advance(600) or button.is_disabled(), "no files meanwhile"
    )


def drawn_on(page) -> str:
    """What is on the small map's canvas now: a screenshot may be of a frame before."""
    return page.evaluate("document.getElementById('small-map').toDataURL()")


def picture_came(page) -> None:
    """The small map has drawn its picture."""
    some = """() => {
      const canvas = document.getElementById("small-map");
      const { width, height } = canvas;
      if (!width || !height) return false;
      const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
      return data.some((part) => part > 0);
    }"""
    wait_until(lambda: page.evaluate(some), "the picture")


def drawn_at(driver, where) -> str:
    """The small map 100 ms after the host said that."""
    driver.state(where=where)
    driver.run_for(100)
    return drawn_on(driver.page)


def test_a_driver_sees_a_small_map_that_is_calm_and_no_target(driver):
    host, page = driver.host, driver.page
    host.pictures["a1"] = PICTURE.png
    host.replies["GET /maps/a1"] = (200, DETAILS)
    small = page.locator("#small-map")
    driver.advance(3000)
    assert small.count() == 0  # not even fetched
    page.evaluate(WATCH)

    def shown() -> bool:
        driver.state(where=WHERE)
        driver.run_for(500)
        return small.count() == 1 and small.is_visible()

    wait_until(shown, "the small map")
    driver.screenshot("map_small")
    assert take(page) == [], "nothing else has moved"
    box = small.bounding_box()
    at = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    under = "([x, y]) => document.elementFromPoint(x, y).closest('#small-map') === null"
    assert page.evaluate(under, at)
    picture_came(page)
    # The chair on it has just moved, whenever that was.
    for x in (3.5, 2.5):
        was = drawn_at(driver, WHERE)
        moved = {**WHERE, "x": x}
        wait_until(lambda: drawn_at(driver, moved) != was, "the chair to move")  # noqa: B023
    before = drawn_on(page)
    for _ in range(15):
        assert drawn_at(driver, {**WHERE, "x": 4.0}) == before  # at most every 2 s

    def tell(**news) -> None:
        """For 2.5 s, as a host does."""
        for _ in range(5):
            driver.state(**news)
            driver.run_for(500)

    tell(where={**WHERE, "x": 4.0})
    assert drawn_on(page) != before
    # What is told needs the room; and where the chair is not known, there is no map.
    driver.state(level="error", message="board_lost")
    driver.run_for(200)
    assert not small.is_visible()
    driver.state(level="ok", message="ok")
    driver.run_for(200)
    assert small.is_visible()
    tell(where=None)
    assert not small.is_visible()


def test_a_style_sheet_that_comes_after_the_map_hides_nothing(driver):
    host, page = driver.host, driver.page
    host.pictures["a1"] = PICTURE.png
    host.replies["GET /maps/a1"] = (200, DETAILS)
    held = []
    page.route("**/small_map.css", lambda route: held.append(route))
    small = page.locator("#small-map")

    def open_but_for_that() -> bool:
        driver.state(where=WHERE)
        driver.run_for(500)
        return held and small.get_attribute("data-fits") is not None

    driver.wait_until(open_but_for_that, "the map")
    held[0].continue_()
    driver.wait_until(small.is_visible, "the small map")


def test_a_map_that_does_not_come_is_asked_for_again(driver):
    host, small = driver.host, driver.page.locator("#small-map")
    host.pictures["a1"] = PICTURE.png
    host.replies["GET /maps/a1"] = (500, {"reason": "no_answer"})
    failed = []
    driver.page.on("console", lambda line: failed.append(line.text))

    def look() -> None:
        driver.state(where=WHERE)
        driver.run_for(500)

    driver.wait_until(lambda: look() or any("small map" in text for text in failed), "the failure")
    assert not small.is_visible()
    host.replies["GET /maps/a1"] = (200, DETAILS)
    driver.wait_until(lambda: look() or small.is_visible(), "the small map")


def test_the_way_to_a_spot_is_on_the_small_map_before_it_is_gone(driver):
    host, page = driver.host, driver.page
    host.pictures["a1"] = PICTURE.png
    host.replies["GET /maps/a1"] = (200, DETAILS)
    small = page.locator("#small-map")

    def tell(**news) -> None:
        for _ in range(5):
            driver.state(where=WHERE, **news)
            driver.run_for(500)

    def seen() -> bool:
        tell()
        return small.count() == 1 and small.is_visible()

    wait_until(seen, "the small map")
    page.evaluate("document.body.dataset.view = 'pick'")
    assert small.is_visible()
    picture_came(page)
    tell()
    bare = drawn_on(page)
    goal = {"map": "a1", "x": 4.5, "y": 2.0}
    spot = {"kind": "look", "state": "ready", "goal": goal, "way": [[3.0, 1.0], [4.5, 2.0]]}
    over = {"kind": "look", "name": "x", "state": "arrived", "reason": "", "goal": goal, "mode": ""}
    tell(spot=spot, going=over)
    shown = drawn_on(page)
    assert shown != bare
    tell(spot={**spot, "state": "ended"}, going=over)
    assert drawn_on(page) == bare
    tell(spot={**spot, "goal": {**goal, "map": "b2"}}, going=None)
    assert drawn_on(page) == bare
