"""Maps on the caretaker's page: made while driving, drawn on by taps, kept as files."""

import re

import numpy as np
import pytest

from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.packed_map import unpack
from gazechair.sensing.mapping.stored.ros_map import files_of
from layoutshift import WATCH, take
from mapanswers import DETAILS, GRID, PICTURE, ROW, WHERE
from patience import wait_until

pytestmark = pytest.mark.browser

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
        """Set the host's answer from now on, and wait until the page has shown it."""
        host.replies |= {"GET /maps": (200, answer), "POST /maps": (200, answer)}
        for _ in range(3):
            caretaker.advance(600)
            caretaker.answered()

    def status() -> str:
        return page.locator("#maps .status-text").inner_text()

    def posted(request) -> None:
        wait_until(lambda: ("/maps", request) in host.posted, f"{request} among {host.posted[-3:]}")

    def press(text: str) -> None:
        page.locator("#maps button", has_text=text).locator("visible=true").first.click()

    now(IDLE)
    page.locator("#tab-settings").click()
    page.locator("#tab-maps").click()
    caretaker.wait_until(lambda: caretaker.advance(600) or "nog geen kaart" in status(), "the list")
    press("Kaart maken")
    posted({"make": True})
    now({**IDLE, "state": "making", "wants": "make", "making": MAKING})
    assert status() == "De kaart groeit: 12 m gereden, 2 keer teruggevonden."
    page.evaluate(WATCH)
    take(page)
    now({**IDLE, "state": "making", "wants": "make", "making": {**MAKING, "driven_m": 230.0}})
    assert take(page) == [], "nothing moves by itself"
    caretaker.screenshot("map_making")
    now({**IDLE, "wants": "make", "making": {**MAKING, "doubt": "broken"}})
    assert "telt niet mee" in status()
    page.locator("#maps .making input").fill("Thuis")
    press("Bewaren")
    posted({"save": "Thuis"})
    stored = {"reason": "", "detail": "", "map": "a1"}
    now({**KNOWN, "ended": stored})
    assert "is bewaard" in status()

    # A place: two taps, a name, a sign. The map is 8 m by 6 m.
    press("Plek")
    assert status() == "Tik waar de stoel dan staat."
    box = page.locator("#maps canvas").bounding_box()
    scale = min(box["width"] / 8.0, box["height"] / 6.0)

    def tap(x: float, y: float) -> None:
        """Tap at these metres of the map."""
        left, top = (box["width"] - 8.0 * scale) / 2, (box["height"] - 6.0 * scale) / 2
        at = {"x": left + (x + 1.0) * scale, "y": top + (4.0 - y) * scale}
        page.locator("#maps canvas").click(position=at)

    tap(2.0, 1.0)
    tap(2.0, 3.0)
    page.locator("#maps .form input").fill("Bed van opa")
    page.locator("#maps .form select").select_option("bed")
    press("Bewaren")
    wait_until(lambda: host.posted and "place" in host.posted[-1][1], "the place")
    request = host.posted[-1][1]
    assert (request["map"], request["place"]["name"], request["place"]["icon"]) == (
        "a1",
        "Bed van opa",
        "bed",
    )
    found = [request["place"][name] for name in ("x", "y", "heading")]
    assert found == pytest.approx([2.0, 1.0, 90.0], abs=1.5)
    assert found[:2] == pytest.approx([2.0, 1.0], abs=0.1)
    # An area: three corners or more; a refusal is shown in plain words.
    press("Verboden gebied")
    for corner in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)):
        tap(*corner)
    host.replies["POST /maps"] = (400, {"reason": "map_area", "detail": "no extent"})
    press("Klaar")
    wait_until(lambda: host.posted and "no_go" in host.posted[-1][1], "the area")
    assert len(host.posted[-1][1]["no_go"]) == 3
    caretaker.wait_until(lambda: "geen gebied" in status(), "why not")
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


def test_a_tap_on_a_phone_that_was_turned_counts_where_it_is(caretaker):
    host, page = caretaker.host, caretaker.page
    page.set_viewport_size({"width": 360, "height": 640})
    host.pictures["a1"] = PICTURE.png
    host.replies |= {
        "GET /maps": (200, KNOWN),
        "GET /maps/a1": (200, DETAILS),
        "POST /maps": (200, KNOWN),
    }
    page.locator("#tab-settings").click()
    page.locator("#tab-maps").click()
    tool = page.locator("#maps [data-tool=no_go]")
    canvas = page.locator("#maps canvas")
    drawn = (
        "one => one.getContext('2d').getImageData(0, 0, one.width, one.height).data.some(x => x)"
    )
    caretaker.wait_until(
        lambda: caretaker.advance(600) or (tool.is_visible() and canvas.evaluate(drawn)), "the map"
    )
    tool.click()
    page.set_viewport_size({"width": 640, "height": 360})
    corners = [[1.0, 3.0], [3.0, 3.0], [3.0, -1.0]]
    for x, y in corners:
        box = canvas.bounding_box()
        scale = min(box["width"] / 8.0, box["height"] / 6.0)
        left, top = (box["width"] - 8.0 * scale) / 2, (box["height"] - 6.0 * scale) / 2
        canvas.click(position={"x": left + (x + 1.0) * scale, "y": top + (4.0 - y) * scale})
    page.locator("#maps .form .strong").click()
    wait_until(lambda: host.posted and "no_go" in host.posted[-1][1], "the area")
    found = host.posted[-1][1]["no_go"]
    assert np.array(found) == pytest.approx(np.array(corners), abs=0.05)
    assert canvas.evaluate("one => one.height === one.clientHeight")  # nothing is distorted


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

    def shows(text: str) -> None:
        line = page.locator("#maps .status-text")
        caretaker.wait_until(lambda: caretaker.advance(600) or text in line.inner_text(), text)

    shows("weet waar hij is")
    # The reason of a refusal is shown, and the same file can be chosen again.
    host.replies["POST /maps/import"] = (400, {"reason": "map_file_zip", "detail": "no zip"})
    for number in (1, 2):
        chosen(page, ("map.zip", b"nothing"))
        shows("geen zip met een kaart")
        wait_until(lambda n=number: len(host.files) == n, "the file")  # type: ignore[misc]
    # A file that is too large is not even sent.
    chosen(page, ("film.zip", bytes(5_000_001)))
    shows("hoogstens 5 MB")
    assert host.files == [b"nothing", b"nothing"]
    # Several become one zip file, which the host understands.
    host.replies |= {"POST /maps/import": (200, both), "GET /maps": (200, both)}
    made = files_of(HomeMap("Kantoor", GRID))
    chosen(page, *made.items())
    shows("is bewaard")
    line, press = (
        page.locator(f"#maps {name}").bounding_box() for name in (".status-text", "button.import")
    )
    assert 0 < line["y"] - press["y"] < 70  # next to the pressed button: never scrolled away
    found = unpack(host.files[-1])
    assert found.name == "Kantoor"
    assert (found.grid.occupied == GRID.occupied).all()
    assert page.locator("#maps select").first.input_value() == "b2"
    name = page.locator("#maps .rename input")
    wait_until(lambda: name.input_value() == "Kantoor", "its details")
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


@pytest.mark.parametrize("older", ["arrives before", "arrives after", "knows it already"])
def test_an_answer_that_was_overtaken_changes_no_choice(caretaker, older):
    host, page = caretaker.host, caretaker.page
    other = {**ROW, "map": "b2", "name": "Kantoor"}
    host.pictures |= {"a1": PICTURE.png, "b2": PICTURE.png}
    both = {**KNOWN, "maps": [ROW, other]}
    host.replies |= {
        "GET /maps": (200, KNOWN),
        "GET /maps/a1": (200, DETAILS),
        "GET /maps/b2": (200, {**DETAILS, **other}),
        "POST /maps/import": (200, {**both, "added": "b2"}),
    }
    page.locator("#tab-settings").click()
    page.locator("#tab-maps").click()
    name = page.locator("#maps .rename input")
    caretaker.wait_until(lambda: caretaker.advance(600) or name.input_value() == "Thuis", "the map")
    held = []

    def hold(route) -> None:
        held.append(route) if len(held) < 2 else route.continue_()

    page.route(re.compile("/maps(/import)?$"), hold)
    caretaker.wait_until(lambda: caretaker.advance(600) or held, "the question")
    chosen(page, ("map.zip", b"PK"))
    caretaker.wait_until(lambda: len(held) == 2, "the file")
    question, file = held

    def answered(route, **news) -> None:
        """Wait until that request is answered, and the page has processed it."""
        with page.expect_response(route.request.url):
            route.fulfill(json=news) if news else route.continue_()
        page.evaluate("fetch('/me').then((answer) => answer.text())")

    if older == "arrives after":
        answered(file)
        answered(question, **KNOWN)
    else:
        answered(question, **(KNOWN if older == "arrives before" else both))
        answered(file)
    wait_until(lambda: name.input_value() == "Kantoor", "the new map")
    assert page.locator("#maps select").first.input_value() == "b2"
