"""Nothing on a page moves by itself: the browser's own layout-shift entries, through a life."""

import json

import pytest

import gazesetup
from fakehost import OFF, picture
from layoutshift import WATCH, take
from patience import wait_until
from pluginrows import lost, mode, offer
from webperson import CARETAKER, Driver

pytestmark = pytest.mark.browser

TABLET, UPRIGHT, FLAT = (1280, 800), (390, 844), (844, 390)
SCREENS = [(TABLET, "nl"), (UPRIGHT, "nl"), (FLAT, "nl"), (UPRIGHT, "en")]
WORDS = json.loads((gazesetup.ROOT / "web/strings/nl.json").read_text("utf-8"))["messages"]
LONGEST = sorted(WORDS, key=lambda key: len(WORDS[key]["text"] + WORDS[key]["do"]))
DRIVE = ("forward", "backward", "left", "right")
FRAME = "new Promise(spied.frame)"
LONG_NAME = "Maximiliaan Alexander van den Heuvel-Ber"
MINE = {"state": "armed", "you": True, "owner": "driver"}
OTHERS = {"state": "armed", "you": False, "owner": "caretaker"}
AHEAD, HOME, FAR = mode("ahead"), mode("home"), mode("far", names={"nl": "W" * 20, "en": "iI " * 7})
# States of plug-ins: they start, work, fail, recover, and change.
PLUGINS = [
    [mode("ahead", state="starting", reason="plugin_starting"), HOME],
    [AHEAD, HOME],
    [lost(AHEAD, "plugin_wrong", 1), HOME],
    [lost(AHEAD, "plugin_setting"), lost(HOME), {**FAR, "kind": "input"}],
    [{**AHEAD, "state": "degraded", "reason": "plugin_trouble", "detail": "w" * 200}, HOME, FAR],
    [AHEAD, HOME, FAR, *(mode(f"m{n}") for n in range(9))],
    [HOME],
    [],
    [FAR, AHEAD],
]
GOING = {"mode": "home", "kind": "place", "name": "W" * 20, "state": "drives", "reason": ""}
GOING |= {"goal": {}, "left_m": 12.3}
# The host's messages, one after the other; every step is a real one.
NEWS = [
    OFF | {"motion": "stopped"},
    {"simulated": True},
    {"relay_checked": False},
    {"level": "error", "message": "board_lost", "arm_reason": "not_connected"},
    {"level": "error", "message": LONGEST[-1]},
    {"level": "warning", "message": LONGEST[-2]},
    {"level": "ok", "message": "ok", "arm_reason": LONGEST[0]},
    {"arm_reason": LONGEST[-1]},
    {"arm_reason": "none", "call": True, "heard": True},
    {"call": False, "coming": True},
    {"coming": False, "heard": False},
    {"state": "arming", "owner": "driver", "you": True},
    MINE,
    {"motion": "turn", "heading_deg": 12.0, "output_permille": [0, 834]},
    {"motion": "backward", "output_permille": [-953, 0]},
    {
        "decisions": dict(zip(DRIVE, ("blocked", "slow", "free", "unknown"), strict=True)),
        "clearance": {"forward": 12.3, "backward": None, "left": 175.0, "right": 0.0},
    },
    {
        "decisions": dict(zip(DRIVE, ("slow", "free", "blocked", "blocked"), strict=True)),
        "clearance": {"forward": 0.3, "backward": 1.0, "left": 5.0, "right": 90.0},
        "view": dict(zip(DRIVE, ("seen", "unseen", "blind", "unseen"), strict=True)),
    },
    {"override": "obstacle_forward"},
    {"override": LONGEST[-3]},
    {"override": "none"},
    {"auto": ["home", ""], "going": GOING},
    {"going": {**GOING, "state": "blocked", "reason": LONGEST[-1], "left_m": 2.1}},
    {"auto": ["", "home"], "going": {**GOING, "state": "ended", "reason": "going_stopped"}},
    {"auto": ["", ""], "going": None},
    {"auto": ["home", ""], "going": GOING},
    {"auto": ["", ""], "going": None},
    OTHERS,
    {"override": "obstacle_left"},
    {"override": "none", "call": True},
    {"owner": "driver"},
    {**MINE, "call": False, "cap_permille": 350, "bypass_ms": 12_000},
    {"level": "error", "message": "emergency", **OFF},
    {"level": "ok", "message": "ok", "bypass_ms": 0, "simulated": False, "relay_checked": True},
]


@pytest.fixture(params=SCREENS, ids=lambda one: f"{one[0][0]}x{one[0][1]}-{one[1]}")
def language(request, page):
    """The page's language, on a screen of some size."""
    (width, height), language = request.param
    page.add_init_script(WATCH)
    page.set_viewport_size({"width": width, "height": height})
    return language


class Life:
    """Runs a page through all steps, and records what moved in which step."""

    def __init__(self, person: Driver) -> None:
        self.person = person
        self.moved: list[str] = []

    def look(self, step: object) -> None:
        self.person.run_for(25)
        for shift in take(self.person.page):
            self.moved.append(f"{step}: {shift['value']:.4f} {shift['what']}")

    def advance(self, ms: int) -> None:
        """Lets `ms` pass; the browser renders every 100 ms of it."""
        for _ in range(0, ms, 100):
            self.person.advance(100)
            self.person.page.evaluate(FRAME)

    def news(self) -> None:
        for news in NEWS:
            self.person.state(**news)
            self.look(news)

    def plugins(self) -> None:
        for number, rows in enumerate(PLUGINS):
            offer(self.person.host, *rows)
            self.person.state()
            self.look(f"plug-ins {number}")

    def lose_the_link(self) -> None:
        self.person.run_for(700)
        self.look("no word from the host")
        self.person.state()
        self.look("the host is back")
        self.advance(5000)
        self.look("a while later")

    def pictures(self) -> None:
        host = self.person.host
        for sequence in (1, 2):
            host.show(picture(), sequence)
            wait_until(lambda n=str(sequence): n in host.acknowledged, "the picture")
            self.person.advance(25)
            self.look("a picture")
        self.advance(1200)
        self.look("an old picture")


def test_the_measure_finds_what_moves(page, host, language):
    person = Driver(page, host)
    person.open()
    take(page)
    page.evaluate("document.getElementById('status').style.marginTop = '40px'")
    assert take(page)


def test_nothing_on_the_drivers_page_moves(page, host, language):
    host.state.update(OFF)
    host.profiles.change({"create": LONG_NAME}, True)
    life = Life(Driver(page, host))
    person = life.person
    person.open(f"?lang={language}")
    life.look("opened")
    life.pictures()
    life.news()
    life.lose_the_link()
    person.look("stop")
    life.look("stop asked")
    person.state(stops=99)
    life.look("stop seen")
    life.advance(3500)
    life.look("stop forgotten")
    host.say({"k": "refused", "what": "cmd", "reason": "not_armed", "detail": ""})
    person.advance(200)
    life.look("refused")
    for tile in (
        "menu",
        "tile-3",
        "tile-2",
        "tile-2",
        "back",
        "tile-4",
        "back",
        "tile-5",
        "tile-5",
    ):
        page.locator(f"#{tile}").click()
        page.wait_for_timeout(50)  # the host keeps the profile
        person.state()
        life.look(tile)
    page.locator("#tile-2").click()
    wait_until(lambda: person.text("#eyes-left"), "the eye test")
    life.look("the eye test")
    for _ in range(24):  # every second that it says is on the screen
        person.advance(1000, look=(0.5, 0.5))
        page.evaluate(FRAME)
    life.look("tested")
    page.locator("#back").click()
    page.locator("#tile-1").click()
    life.look("practice")
    person.advance(500)
    page.locator("#arm").click()
    page.keyboard.press("ArrowUp")
    person.advance(100)
    life.look("practised")
    assert not life.moved, "\n".join(life.moved)


def test_nothing_on_the_drivers_page_moves_for_plug_ins(page, host, language):
    life = Life(Driver(page, host))
    person = life.person
    person.open(f"?lang={language}")
    life.look("opened")
    offer(host, *PLUGINS[0])
    wait_until(lambda: page.locator("#plugin-1").count(), "the tiles")
    person.state()
    life.look("the tiles")
    life.plugins()
    for _ in range(2):
        page.locator("#mode").click()
        life.look("another mode")
    assert person.data("mode") == "more"
    life.plugins()
    offer(host, *PLUGINS[5])
    person.state()
    assert person.data("mode") == "continuous"  # of one mode there is no page
    for _ in range(2):
        page.locator("#mode").click()
    for _ in range(5):
        page.locator("#next").click()
        life.look("next")
    person.look("plugin-1")
    life.look("a look")
    for news in (OFF, MINE, OTHERS):
        person.state(**news)
        life.look(news)
    assert not life.moved, "\n".join(life.moved)


def test_nothing_on_the_caretakers_page_moves(page, host, language):
    host.welcome["role"] = "caretaker"
    host.replies.update(CARETAKER)
    host.state.update(OFF)
    life = Life(Driver(page, host))
    person = life.person
    person.open(f"caretaker?lang={language}")
    life.look("opened")
    life.pictures()
    page.locator("#stop").click()
    life.look("the first touch, which lets sound begin")
    person.state(stops=99)
    life.advance(3500)
    life.look("stop seen")
    life.news()
    life.lose_the_link()
    page.locator("#cap").scroll_into_view_if_needed()
    take(page)
    page.locator("#cap").fill("350")
    life.look("a cap")
    page.locator("#tab-settings").click()
    wait_until(lambda: page.locator("#chair .row").count(), "the chair's settings")
    life.look("settings")
    page.locator("#profiles button").first.click()
    wait_until(lambda: len(host.profiles.as_json()["profiles"]) == 2, "somebody new")
    person.advance(100)
    life.look("somebody new")
    host.profiles.change({"save": {"id": "2", "name": LONG_NAME}}, True)
    host.profiles.change({"choose": "2"}, True)
    person.advance(200)
    life.look("somebody with a long name drives")
    page.locator("#profiles .sure").click()
    life.look("sure?")
    life.advance(5100)
    life.look("not sure")
    page.locator("#tab-modules").click()
    life.look("modules")
    life.plugins()
    page.locator("#tab-pairing").click()
    wait_until(lambda: page.locator("#devices li").count(), "the devices")
    life.look("pairing")
    page.locator("#invite button").first.click()
    wait_until(lambda: page.locator(".qr").count(), "the code")
    life.look("a code")
    life.advance(2000)
    life.look("the code's time")
    page.locator(".code-sheet .strong").click()
    life.look("done")
    page.locator("#devices .sure").first.click()
    person.advance(600)
    page.locator("#devices .sure").first.click()
    page.wait_for_timeout(50)
    life.look("revoked")
    assert not life.moved, "\n".join(life.moved)


def test_nothing_on_a_viewers_page_moves(page, host, language):
    host.welcome["role"] = "viewer"
    host.state.update(OFF)
    life = Life(Driver(page, host))
    life.person.open(f"caretaker?lang={language}")
    life.look("opened")
    life.pictures()
    life.news()
    life.lose_the_link()
    assert not life.moved, "\n".join(life.moved)


def advice_y(page):
    """Where the advice of the message begins, once there is one."""
    page.wait_for_selector("#answer[data-kind=error]")
    return page.evaluate("document.querySelector('#answer .do').getBoundingClientRect().y")


def test_nothing_on_the_pairing_page_moves(page, host, language):
    host.replies["GET /me"] = 401, {"reason": "not_paired", "detail": ""}
    host.replies["POST /pair"] = 403, {"reason": "wrong_code", "detail": ""}
    page.goto(f"{host.url}pair?lang={language}")
    wait_until(lambda: page.evaluate("document.activeElement?.id") == "code", "the page")
    moved = take(page)
    page.keyboard.press("Enter")
    advice = [advice_y(page)]
    moved += take(page)
    page.keyboard.type("AAAA-AAAA")
    page.keyboard.press("Enter")
    wait_until(lambda: host.posted, "the code")
    page.wait_for_selector("#go:enabled")  # before, Enter sends nothing
    advice.append(advice_y(page))
    moved += take(page)
    wait = {"reason": "too_many_guesses", "detail": "", "wait_s": 3}
    host.replies["POST /pair"] = 429, wait
    page.keyboard.press("Enter")
    # The request itself disables it, too.
    advice.append(advice_y(page))
    assert page.locator("#go").is_disabled()
    moved += take(page)
    page.evaluate("spied.run(4500)")
    moved += take(page)
    assert not moved, moved
    assert len(set(advice)) == 1, advice
