"""Maps on the caretaker's page when a press comes too often, or an answer late or not at all."""

import pytest

from mapanswers import CHANGED, DETAILS, PICTURE, ROW, WHERE
from patience import wait_until

pytestmark = pytest.mark.browser

OTHER = {**ROW, "map": "b2", "name": "Kantoor"}
BOTH = {
    "state": "known",
    "wants": "know",
    "making": None,
    "ended": None,
    "where": WHERE,
    "most_file_bytes": 5_000_000,
    "maps": [ROW, OTHER],
}

# Pixels that the map's canvas shows.
DRAWN = """
() => {
  const canvas = document.querySelector("#maps canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return data.some(Boolean);
}
"""


@pytest.fixture
def maps(caretaker):
    """The host's answers for two maps; the caretaker has opened the settings."""
    host = caretaker.host
    host.pictures |= {"a1": PICTURE.png, "b2": PICTURE.png}
    host.replies |= {
        "GET /maps": (200, BOTH),
        "POST /maps": (200, BOTH),
        "GET /maps/a1": (200, {**DETAILS, "updates": 2, "updated": "2026-11-23T10:05:00Z"}),
        "GET /maps/b2": (200, {**DETAILS, **OTHER}),
    }
    caretaker.page.locator("#tab-settings").click()
    return caretaker


def opened(maps, name="Thuis"):
    """Opens the maps; the map of that name is shown with its tools."""
    maps.page.locator("#tab-maps").click()
    shown(maps, name)


def shown(maps, name):
    field = maps.page.locator("#maps .rename input")
    tools = maps.page.locator("#maps button", has_text="Kaart als bestand")
    maps.wait_until(
        lambda: maps.advance(600) or (tools.is_visible() and field.input_value() == name), name
    )


def status(maps):
    return maps.page.locator("#maps .status-text").inner_text()


def requests_to(maps, action):
    """How often the host was asked that."""
    maps.page.evaluate("fetch('/me').then((answer) => answer.text())")
    return [posted for _, posted in maps.host.posted if action in posted]


# Buttons that ask first


@pytest.mark.parametrize(
    ("place", "text", "action"),
    [(0, "Kaart verwijderen", "delete"), (1, "Aanpassing terugnemen", "back")],
)
def test_a_tap_after_the_confirmed_one_asks_again(maps, place, text, action):
    opened(maps)
    button = maps.page.locator("#maps .rename .sure").nth(place)
    for _ in range(2):
        button.click()
        maps.advance(1000)
    wait_until(lambda: requests_to(maps, action) == [{"map": "a1", action: True}], "the request")
    assert button.inner_text() == text
    button.click()
    assert len(requests_to(maps, action)) == 1
    assert button.inner_text() == "Zeker weten?"
    maps.advance(5100)
    assert button.inner_text() == text


def test_a_key_that_is_held_on_such_a_button_confirms_nothing(maps):
    opened(maps)
    maps.page.locator("#maps .rename .sure", has_text="verwijderen").focus()
    for _ in range(3):
        maps.page.keyboard.down("Enter")
        maps.advance(1000)
    assert requests_to(maps, "delete") == []
    maps.page.keyboard.up("Enter")


def test_another_map_is_not_deleted_by_the_second_press(maps):
    opened(maps)
    maps.page.locator("#maps .rename .sure", has_text="verwijderen").click()
    maps.advance(600)
    maps.page.locator("#maps select").first.select_option("b2")
    shown(maps, "Kantoor")
    button = maps.page.locator("#maps .rename .sure", has_text="verwijderen")
    assert button.is_visible()
    button.click()
    assert requests_to(maps, "delete") == []
    maps.advance(1000)
    maps.page.locator("#maps .rename .sure", has_text="Zeker weten").click()
    wait_until(
        lambda: requests_to(maps, "delete") == [{"map": "b2", "delete": True}], "the request"
    )


# Answers that do not come


def test_a_map_whose_details_did_not_load_is_asked_for_again(maps):
    details = maps.host.replies["GET /maps/a1"]
    maps.host.replies["GET /maps/a1"] = (500, {"reason": "no_answer", "detail": ""})
    maps.page.locator("#tab-maps").click()
    maps.wait_until(lambda: maps.advance(600) or status(maps), "the trouble")
    choose = maps.page.locator("#maps select").first
    wait_until(lambda: choose.input_value() == "a1", "the list")
    assert not maps.page.locator("#maps button", has_text="Kaart als bestand").is_visible()
    maps.host.replies["GET /maps/a1"] = details
    shown(maps, "Thuis")


def test_details_that_loaded_are_not_asked_for_again(maps):
    requested = []
    maps.page.on("request", lambda request: requested.append(request.url))
    opened(maps)
    maps.advance(3000)
    assert sum(url.endswith("/maps/a1") for url in requested) == 1


def test_the_map_of_an_auto_motion_that_does_not_come_is_asked_for_every_2_s(caretaker):
    host, page = caretaker.host, caretaker.page
    host.replies["GET /maps/a1"] = (500, {"reason": "no_answer"})
    host.pictures["a1"] = PICTURE.png
    requested = []
    page.on("request", lambda request: requested.append(request.url))
    goal = {"map": "a1", "x": 3.0, "y": 1.0, "heading": 0.0}
    drives = {"kind": "place", "mode": "to-1", "name": "Bed", "state": "drives", "reason": ""}
    host.state["going"] = {**drives, "goal": goal}

    def times() -> int:
        return sum(url.endswith("/maps/a1") for url in requested)

    caretaker.wait_until(lambda: caretaker.advance(100) or times() == 1, "the first question")
    caretaker.advance(1500)
    assert times() == 1
    caretaker.advance(700)
    caretaker.wait_until(lambda: times() == 2, "the second question")
    host.replies["GET /maps/a1"] = (200, DETAILS)
    drawn = DRAWN.replace("#maps canvas", "#going-map")
    caretaker.wait_until(lambda: caretaker.advance(100) or page.evaluate(drawn), "the map")
    requested.clear()
    caretaker.advance(3000)
    assert times() == 0


def test_the_map_of_an_auto_motion_is_shown_as_it_is_now(caretaker):
    host, page = caretaker.host, caretaker.page
    host.replies["GET /maps/a1"] = (200, DETAILS)
    host.pictures["a1"] = PICTURE.png
    drives = {"kind": "place", "mode": "to-1", "name": "Bed", "state": "drives", "reason": ""}
    host.state |= {"going": {**drives, "goal": {"map": "a1", "x": 3.0, "y": 1.0}}, "where": WHERE}
    there = page.locator("#going-map")
    caretaker.wait_until(lambda: caretaker.advance(100) or there.count() == 1, "its part")
    drawn = DRAWN.replace("#maps canvas", "#going-map")
    caretaker.wait_until(lambda: caretaker.advance(100) or page.evaluate(drawn), "the map")
    requested = []
    page.on("request", lambda request: "/maps/" in request.url and requested.append(request.url))
    host.state["where"] = {**WHERE, "map": "b2", "version": 9}  # another map's version
    caretaker.advance(1000)
    assert requested == []
    host.state["where"] = {**WHERE, "version": 8}
    caretaker.wait_until(lambda: caretaker.advance(100) or len(requested) == 2, "its picture")
    caretaker.advance(1000)
    assert ["/maps/a1.png" in url for url in requested] == [False, True]


def test_no_plan_of_another_map_is_shown_while_a_maps_own_loads(maps):
    held = []
    maps.page.route("**/maps/b2.png?*", lambda route: held.append(route))
    opened(maps)
    maps.wait_until(lambda: maps.page.evaluate(DRAWN), "the plan")
    maps.page.locator("#maps select").first.select_option("b2")
    shown(maps, "Kantoor")
    maps.wait_until(lambda: held, "the request")
    assert not maps.page.evaluate(DRAWN)
    maps.page.locator("#maps [data-tool=place]").click()
    for _ in range(2):
        maps.page.locator("#maps canvas").click()
    assert maps.page.locator("#maps .form input").count() == 0  # nothing was placed
    held[0].continue_()
    maps.wait_until(lambda: maps.page.evaluate(DRAWN), "its plan")
    maps.page.locator("#maps canvas").click()
    assert "kijkt" in status(maps)


def test_a_plan_that_did_not_load_is_asked_for_again(maps):
    maps.page.route("**/maps/a1.png?*", lambda route: route.abort())
    opened(maps)
    name = maps.page.locator("#maps .rename input")
    name.fill("Ons huis")
    maps.advance(1200)
    assert not maps.page.evaluate(DRAWN)
    maps.page.unroute("**/maps/a1.png?*")
    maps.wait_until(lambda: maps.advance(600) or maps.page.evaluate(DRAWN), "the plan")
    assert name.input_value() == "Ons huis"


def test_a_plan_that_has_changed_is_shown_as_it_is_now(maps):
    opened(maps)
    maps.wait_until(lambda: maps.page.evaluate(DRAWN), "the plan")
    content = "document.querySelector('#maps canvas').toDataURL()"
    before = maps.page.evaluate(content)
    maps.host.pictures["a1"] = CHANGED.png
    news = {"updates": 3, "updated": "2026-11-24T10:05:00Z"}
    maps.host.replies |= {
        "GET /maps": (200, {**BOTH, "maps": [{**ROW, **news}, OTHER]}),
        "GET /maps/a1": (200, {**DETAILS, **news}),
    }
    maps.wait_until(lambda: maps.advance(600) or maps.page.evaluate(content) != before, "it")


def test_a_damaged_map_is_not_asked_for(maps):
    requested = []
    maps.page.on("request", lambda request: requested.append(request.url))
    damaged = {**ROW, "name": "", "problem": "map_damaged"}
    maps.host.replies["GET /maps"] = (200, {**BOTH, "where": None, "maps": [damaged]})
    maps.page.locator("#tab-maps").click()
    choose = maps.page.locator("#maps select").first
    maps.wait_until(lambda: maps.advance(600) or choose.input_value() == "a1", "the list")
    maps.advance(3000)
    assert not any(url.endswith("/maps/a1") for url in requested)


def test_maps_opened_again_while_they_load_work(maps):
    held = []
    maps.page.route("**/nl-maps.json", lambda route: held.append(route))
    for name in ("maps", "settings", "maps"):
        maps.page.locator(f"#tab-{name}").click()
    maps.wait_until(lambda: held, "the texts")
    maps.page.evaluate("fetch('/me').then((answer) => answer.text())")
    for route in held:
        route.continue_()
    shown(maps, "Thuis")


def test_maps_that_did_not_load_are_loaded_by_the_next_press(maps):
    maps.page.route("**/nl-maps.json", lambda route: route.abort())
    maps.page.locator("#tab-maps").click()
    wait_until(lambda: "antwoord" in maps.text("#banner"), "the trouble")
    maps.page.unroute("**/nl-maps.json")
    maps.page.locator("#tab-settings").click()
    opened(maps)


def test_a_map_that_was_made_before_the_page_was_opened_is_no_news(maps):
    stored = {"reason": "", "detail": "", "map": "b2"}
    maps.host.replies["GET /maps"] = (200, {**BOTH, "ended": stored})
    opened(maps)
    assert "weet waar hij is" in status(maps)
    # One that ends while the page looks on is told, also when it ended at once.
    failed = {"reason": "map_empty", "detail": "", "map": ""}
    maps.host.replies["GET /maps"] = (200, {**BOTH, "ended": failed})
    maps.wait_until(lambda: maps.advance(600) or "te weinig" in status(maps), "the result")


def test_a_started_drawing_survives_what_others_do_to_the_maps(maps):
    opened(maps)
    maps.wait_until(lambda: maps.page.evaluate(DRAWN), "the plan")
    maps.page.locator("#maps [data-tool=place]").click()
    for at in (100, 140):
        maps.page.locator("#maps canvas").click(position={"x": at, "y": 100})
    maps.page.locator("#maps .form input").fill("Bed")
    renamed = {**BOTH, "maps": [ROW, {**OTHER, "name": "Werk"}]}
    maps.host.replies["GET /maps"] = (200, renamed)
    options = maps.page.locator("#maps select").first
    maps.wait_until(lambda: maps.advance(600) or "Werk" in options.inner_text(), "the name")
    assert maps.page.locator("#maps .form input").input_value() == "Bed"


def test_what_others_draw_is_shown(maps):
    opened(maps)
    place = {"number": 1, "name": "Bed", "icon": "bed", "x": 1.0, "y": 1.0, "heading": 0}
    details = maps.host.replies["GET /maps/a1"][1]
    maps.host.replies["GET /maps/a1"] = (200, {**details, "places": [place]})
    items = maps.page.locator("#maps li")
    maps.advance(3000)
    assert items.count() == 0
    maps.host.replies["GET /maps"] = (200, {**BOTH, "maps": [{**ROW, "drawn": 2}, OTHER]})
    name = maps.page.locator("#maps .rename input")
    name.fill("Ons huis")
    maps.wait_until(lambda: maps.advance(600) or items.count() == 1, "the place")
    assert name.input_value() == "Ons huis"
