"""Tiles of the modes that plug-ins bring, in a real Chromium: held and let go as a direction is."""

import pytest

from fakehost import picture
from pagelooks import OVERFLOWING, REST, SCREENS
from patience import wait_until
from pluginrows import WELL, lost, mode, offer
from webperson import Driver
from webscanner import opened

pytestmark = pytest.mark.browser

OFF = {"state": "disarmed", "you": False, "owner": "nobody"}
AHEAD, HOME, FOLLOW = mode("ahead"), mode("home"), mode("follow")
TWENTY = [mode(f"mode{n}") for n in range(20)]
TILE = {"forward": "Vooruit", "plugin-0": "Ahead"}
SHOWN = "() => [...document.querySelectorAll('.target')].filter(e => e.offsetWidth).map(e => e.id)"
HELD = "() => document.querySelector('.holding')?.id ?? null"


def tiled(person, *rows):
    """The page has taken these plug-ins."""
    offer(person.host, *rows)
    names = [row["names"]["nl"] for row in rows if row["kind"] == "mode"]
    wait_until(lambda: person.page.locator("#plugin-1").count(), "the tiles")
    first = names[0] if names else ""
    wait_until(lambda: person.page.locator("#plugin-1 .label").text_content() == first, first)
    person.state()
    person.forget()


@pytest.fixture
def ride(driver):
    """Armed, and one mode can be chosen."""
    tiled(driver, AHEAD)
    return driver


def shown(person):
    return person.page.evaluate(SHOWN)


def moves(person):
    """What moved or stopped since the last call, without repetitions."""
    kinds = []
    for m in person.heard("cmd", "mode", "stop"):
        what = (m["k"], m.get("verb") or m.get("mode"), m.get("edge"))
        if not kinds or kinds[-1] != what:
            kinds.append(what)
    person.forget()
    return kinds


def more(person):
    """Opens the page of modes."""
    for _ in range(2):
        person.page.locator("#mode").click()
    person.advance(50)
    assert person.data("mode") == "more"


class Fingers:
    """Touches, each with a name."""

    def __init__(self, person):
        self.session = person.page.context.new_cdp_session(person.page)
        self.person = person
        self.down = {}

    def put(self, name, target):
        x, y = self.person.spot(target)
        self.down[name] = {"x": x, "y": y, "id": name}
        self._say("touchStart", *self.down.values())

    def lift(self, name):
        self._say("touchEnd", self.down.pop(name))

    def _say(self, kind, *points):
        self.session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


# Nothing for who has none


def test_without_plug_ins_nothing_is_fetched_and_nothing_is_there(page, host):
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    person = Driver(page, host)
    person.open()
    person.advance(500)
    assert [url for url in asked if "plugin" in url or "menu.js" in url] == []
    assert page.locator(".plugin").count() == 0


# Held and let go


def begin(person, target, by):
    """Begins to hold a tile."""
    if by == "gaze":
        person.hover(target)
        person.advance(100, look=target)
    elif by == "touch":
        person.fingers = Fingers(person)
        person.fingers.put(1, target)
    elif by == "mouse":
        person.page.mouse.move(*person.spot(target))
        person.page.mouse.down()
    else:
        person.page.locator(f"#{target}").focus()
        person.page.keyboard.down("Enter")


def end(person, by):
    if by == "touch":
        person.fingers.lift(1)
    elif by == "mouse":
        person.page.mouse.up()
    elif by == "key":
        person.page.keyboard.up("Enter")


@pytest.mark.parametrize("by", ["gaze", "touch", "mouse", "key"])
def test_a_mode_is_held_with_fresh_tokens_and_let_go_as_soon_as_vooruit_is(ride, by):
    took = {}
    for target, kind in (("forward", "cmd"), ("plugin-0", "mode")):
        ride.advance(400, look=(0.5, 0.55))
        ride.forget()
        begin(ride, target, by)
        ride.advance(500, look=target if by == "gaze" else None)
        said = ride.heard("cmd", "mode")
        assert {m["k"] for m in said} == {kind}
        assert len({m["edge"] for m in said}) == 1
        assert len(said) >= 10
        assert all(m["since"] <= 500 for m in said)
        if kind == "mode":
            assert {m["mode"] for m in said} == {"ahead"}
        assert ride.page.evaluate(HELD) == target
        ride.forget()
        end(ride, by)
        began = ride.host.now_ms
        while not ride.heard("stop"):
            ride.advance(25, look=(0.5, 0.55) if by == "gaze" else None)
            assert ride.host.now_ms - began < 1000
        took[target] = ride.host.now_ms - began
        assert ride.page.evaluate(HELD) is None
    assert took["plugin-0"] == took["forward"] <= 225


@pytest.mark.parametrize("how", ["blur", "pagehide"])
def test_a_page_without_its_person_lets_a_mode_go(ride, how):
    begin(ride, "plugin-0", "touch")
    ride.advance(100)
    ride.forget()
    ride.page.evaluate(f"dispatchEvent(new Event('{how}'))")
    assert ride.heard("mode", "stop", "disarm") == [{"k": "stop"}, {"k": "disarm"}]


def test_a_frozen_pointer_and_a_lost_link_let_it_go(ride):
    ride.hover("plugin-0")
    ride.forget()
    ride.advance(600)
    assert moves(ride)[-1] == ("stop", None, None)
    begin(ride, "plugin-0", "touch")
    ride.advance(100)
    ride.run_for(700)
    assert moves(ride)[-1] == ("stop", None, None)
    ride.state()
    ride.advance(500)
    assert moves(ride) == []


def test_in_step_mode_a_mode_is_held_all_the_same(ride):
    ride.page.locator("#mode").click()
    assert ride.data("mode") == "step"
    ride.hover("plugin-0")
    ride.advance(600, look="plugin-0")
    assert len(ride.heard("mode")) > 10
    ride.forget()
    ride.advance(300, look=(0.5, 0.55))
    assert moves(ride) == [("stop", None, None)]


def test_looking_from_a_mode_at_a_direction_and_back_steers_as_from_a_direction(ride):
    said = {}
    for target in ("forward", "plugin-0"):
        ride.forget()
        ride.hover(target)
        ride.advance(300, look="left")
        ride.advance(300, look=target)
        said[target] = [kind for kind, *_ in moves(ride)]
        ride.advance(500, look=(0.5, 0.55))
    assert said["plugin-0"].count("mode") == said["forward"].count("cmd") - 1 == 2
    turned = [kind.replace("mode", "cmd") for kind in said["plugin-0"]]
    assert turned == said["forward"]


@pytest.mark.parametrize(("first", "second"), [("forward", "plugin-0"), ("plugin-0", "forward")])
def test_of_two_fingers_the_newest_counts_and_lifting_it_stops(ride, first, second):
    fingers = Fingers(ride)
    fingers.put(1, first)
    ride.advance(300)
    fingers.put(2, second)
    ride.advance(300)
    names = {"forward": ("cmd", "forward"), "plugin-0": ("mode", "ahead")}
    assert moves(ride) == [(*names[first], 1), (*names[second], 2)]
    fingers.lift(2)
    ride.advance(500)
    assert moves(ride) == [("stop", None, None)]
    fingers.lift(1)
    ride.advance(500)
    assert moves(ride) == []


def test_stop_under_a_second_finger_ends_it_for_good(ride):
    fingers = Fingers(ride)
    fingers.put(1, "plugin-0")
    ride.advance(300)
    ride.forget()
    fingers.put(2, "stop")
    ride.advance(1000)
    assert moves(ride) == [("stop", None, None)]


def test_nothing_is_held_before_driving_is_on(ride):
    ride.state(**OFF)
    ride.advance(100)
    assert "plugin-0" not in shown(ride)
    assert "help" in shown(ride)
    ride.page.keyboard.press("Enter")
    assert ride.heard("mode") == []


@pytest.mark.parametrize("backward", [False, True], ids=["", "backward"])
def test_while_somebody_else_drives_hulp_is_there_and_is_pressed(driver, backward):
    driver.host.welcome["backward"] = backward
    tiled(driver, *TWENTY[:5])
    for page in ("directions", "modes"):
        if page == "modes":
            more(driver)
        assert "help" not in shown(driver)
        driver.state(you=False, owner="caretaker")
        driver.advance(50)
        assert "help" in shown(driver)
        assert not {"plugin-0", "backward", "next"} & set(shown(driver))
        driver.forget()
        x, y = driver.spot("help")
        driver.page.mouse.click(x, y)
        assert driver.heard("call")
        driver.state(you=True, owner="driver")
        driver.advance(50)


def test_practice_counts_it_and_sends_nothing(ride):
    ride.state(**OFF)
    ride.page.locator("#menu").click()
    ride.page.locator("#tile-1").click()
    ride.page.locator("#arm").click()
    begin(ride, "plugin-0", "mouse")
    ride.advance(300)
    assert ride.heard("mode", "cmd") == []
    assert "ahead 1" in ride.text("#score")
    ride.page.mouse.up()


def test_it_is_reached_by_scanning_with_one_switch(page, host):
    scanner = opened(page, host)
    tiled(scanner, AHEAD, HOME)
    scanner.wait_for("forward", "left", "right")
    scanner.wait_for("plugin-0")  # alone in its row: one press takes it
    scanner.forget()
    scanner.down()
    scanner.advance(1000)
    assert len(scanner.heard("mode")) >= 18
    scanner.up()
    scanner.advance(75)
    assert moves(scanner) == [("mode", "ahead", 1), ("stop", None, None)]
    more(scanner)
    scanner.wait_for("plugin-1", "plugin-2")


# A mode that does not work


def test_a_mode_that_dies_while_held_ends_and_does_not_go_on_by_itself(ride):
    begin(ride, "plugin-0", "touch")
    ride.advance(300)
    ride.forget()
    offer(ride.host, lost(AHEAD))
    ride.advance(50)
    assert moves(ride)[-1] == ("stop", None, None)
    assert ride.page.evaluate(HELD) is None
    assert "is gestopt" in ride.text("#plugin-0")
    ride.advance(500)
    offer(ride.host, AHEAD)
    ride.advance(2000)
    assert moves(ride) == []  # the finger never left
    assert ride.text("#plugin-0 .small") == ""
    ride.fingers.lift(1)
    begin(ride, "plugin-0", "touch")
    ride.advance(100)
    assert moves(ride) == [("mode", "ahead", 2)]


def test_a_gaze_that_stays_on_it_chooses_nothing_when_it_is_back(ride):
    ride.hover("plugin-0")
    ride.advance(100, look="plugin-0")
    offer(ride.host, lost(AHEAD))
    ride.advance(300, look="plugin-0")
    ride.forget()
    offer(ride.host, AHEAD)
    ride.advance(2000, look="plugin-0")
    assert moves(ride) == []
    ride.hover("plugin-0")
    assert moves(ride) == [("mode", "ahead", 2)]


def test_one_that_does_not_work_cannot_be_chosen_and_says_why(ride):
    offer(ride.host, lost(AHEAD, "plugin_hangs"))
    ride.advance(100)
    ride.hover("plugin-0")
    ride.advance(2000, look="plugin-0")
    begin(ride, "plugin-0", "touch")
    ride.advance(500)
    assert moves(ride) == []
    assert "Deze rijwijze werkt nu niet." in ride.text("#banner")
    assert ride.page.locator("#plugin-0").get_attribute("aria-disabled") == "true"
    assert "antwoordt niet" in ride.text("#plugin-0")


@pytest.mark.parametrize("by", ["gaze", "touch"])
def test_what_becomes_of_modes_holds_up_no_other_motion(driver, by):
    tiled(driver, AHEAD, HOME)
    begin(driver, "forward", by)
    for rows in ([lost(AHEAD), HOME], [AHEAD, lost(HOME)], [AHEAD], [HOME, FOLLOW], [], [AHEAD]):
        offer(driver.host, *rows)
        driver.advance(300, look="forward" if by == "gaze" else None)
    assert moves(driver) == [("cmd", "forward", 1)]


def test_the_corner_names_it_until_it_works_and_says_more_important_things_first(ride):
    offer(ride.host, lost(AHEAD, again=ride.host.token + 8000), HOME)
    ride.advance(100)
    assert "Ahead\u2069 is gestopt." in ride.page.locator("#status").text_content()
    assert "Nieuwe poging binnen 10 s." in ride.text("#status")
    assert ride.page.locator("#status").get_attribute("data-level") == "wait"
    ride.advance(4000)
    assert "Nieuwe poging binnen 5 s." in ride.text("#status")
    ride.advance(5000)
    assert "Wordt nu opnieuw gestart." in ride.text("#status")
    ride.state(level="warning", message="camera_lost")
    ride.advance(50)
    assert "gestopt" not in ride.text("#status")
    ride.state(level="ok", message="ok")
    ride.advance(50)
    assert "gestopt" in ride.text("#status")
    offer(ride.host, AHEAD, HOME)
    ride.advance(50)
    assert "Alles in orde." in ride.text("#status")


def test_what_somebody_must_repair_is_a_warning_and_a_start_says_nothing(ride):
    offer(ride.host, lost(AHEAD, "plugin_setting"), mode("home", state="starting", reason=""))
    ride.advance(50)
    assert ride.page.locator("#status").get_attribute("data-level") == "warning"
    assert "Vraag wie de stoel inricht." in ride.text("#status")
    offer(ride.host, mode("ahead", state="starting", reason="plugin_starting"))
    ride.advance(50)
    assert "Alles in orde." in ride.text("#status")
    assert "start op" in ride.text("#plugin-0")


def test_an_input_that_fails_is_named_too_and_has_no_tile(driver):
    pad = {**mode("gamepad"), "kind": "input", "state": "degraded", "reason": "plugin_trouble"}
    tiled(driver, pad)
    driver.advance(100)
    assert "meldt een probleem." in driver.text("#status")
    assert not [name for name in shown(driver) if name.startswith("plugin")]
    assert "help" in shown(driver)


# How many, and where


def boxes(person):
    return {name: person.page.locator(f"#{name}").bounding_box() for name in shown(person)}


@pytest.mark.parametrize("size", SCREENS, ids=str)
@pytest.mark.parametrize("backward", [False, True], ids=["", "backward"])
def test_twenty_modes_have_pages_of_three_and_every_page_keeps_the_rules(
    page, host, size, backward
):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    host.welcome["backward"] = backward
    person = Driver(page, host)
    person.open()
    before = boxes(person)
    tiled(person, *TWENTY)
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
            seen.append(page.locator(f"#{name} .label").text_content())
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
    assert person.heard("mode")[0]["mode"] == "long"


# Parts that do not come


@pytest.mark.parametrize("file", ["plugin_tiles.js", "plugins.js", "plugin_tiles.css", "nl-plug"])
def test_a_part_that_does_not_come_is_told_and_holds_up_nothing(page, host, file):
    page.route(f"**/{file}*", lambda route: route.abort())
    offer(host, AHEAD)
    person = Driver(page, host)
    person.open()
    host.show(picture(), 1)
    wait_until(lambda: host.acknowledged, "the picture")
    person.wait_until(
        lambda: person.advance(100) or "niet geladen" in person.text("#status"), "what is missing"
    )
    assert page.locator("#status").get_attribute("data-level") == "wait"
    person.forget()
    person.look("stop")
    assert person.heard("stop")
    person.advance(400, look=(0.5, 0.55))
    person.hover("forward")
    assert person.heard("cmd")
    page.unroute(f"**/{file}*")
    person.wait_until(lambda: person.advance(500) or "plugin-0" in shown(person), "the tiles")
    assert person.text("#plugin-0 .label") == "Ahead"
    person.advance(100)
    assert "Alles in orde." in person.text("#status")


def test_a_part_that_never_answers_holds_up_neither_stop_nor_the_picture(page, host):
    waiting = []
    page.route("**/plugin_tiles.js", lambda route: waiting.append(route))
    offer(host, AHEAD)
    person = Driver(page, host)
    person.open()
    host.show(picture(), 1)
    wait_until(lambda: host.acknowledged, "the picture")
    person.look("stop")
    assert person.heard("stop")
    for route in waiting:
        route.abort()


def test_a_menu_that_does_not_come_is_told_and_is_there_at_the_next_try(driver):
    driver.page.route("**/menu.js", lambda route: route.abort())
    driver.state(**OFF)
    driver.page.locator("#menu").click()
    driver.wait_until(
        lambda: driver.advance(50) or "niet geladen" in driver.text("#banner"), "what is missing"
    )
    assert driver.data("view") == "drive"
    driver.page.unroute("**/menu.js")
    driver.page.locator("#menu").click()
    wait_until(lambda: driver.data("view") == "menu", "the menu")
    driver.page.route("**/eyes.js", lambda route: route.abort())
    driver.advance(5000)
    driver.page.locator("#tile-2").click()
    driver.wait_until(
        lambda: driver.advance(50) or "niet geladen" in driver.text("#banner"), "what is missing"
    )
    assert driver.data("view") == "menu"
