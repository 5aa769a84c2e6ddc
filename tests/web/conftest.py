"""The pages in a real Chromium, with a simulated clock and person."""

from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Browser, Page

from fakehost import OFF, FakeHost
from patience import wait_until
from plugintiles import AHEAD, tiled
from webperson import CARETAKER, Driver, save

# Counts what reached the page, lets a test speak on the page's own sockets, and repeats there what
# came before: the host's states and the pointer's moves, each after some ms on the page's clock.
SPY = """
window.spied = {token: 0, revision: null, sockets: [], x: -1, move: null};
spied.frame = requestAnimationFrame.bind(window);  // the browser's own
addEventListener("pointermove", (event) => {
  spied.x = event.clientX;
  if (event.isTrusted) spied.move = event;
}, true);
spied.say = (data) => {
  const open = (s) => s.url.endsWith("control") && s.readyState === 1;
  spied.sockets.findLast(open)?.dispatchEvent(new MessageEvent("message", { data }));
};
spied.look = (clientX, clientY) => {
  const { pointerId, pointerType, isPrimary, buttons, target } = spied.move;
  // While a button is down, the element that it was pressed on keeps the pointer.
  const there = buttons ? target : document.elementFromPoint(clientX, clientY);
  there.dispatchEvent(new PointerEvent("pointermove", {
    pointerId, pointerType, isPrimary, buttons, clientX, clientY, button: -1,
    bubbles: true, cancelable: true, composed: true,
  }));
};
spied.plan = ({ said, moves }) => {
  for (const [ms, text] of said) setTimeout(spied.say, ms, text);
  for (const [ms, x, y] of moves) ms ? setTimeout(spied.look, ms, x, y) : spied.look(x, y);
};
const Plain = WebSocket;
window.WebSocket = class extends Plain {
  constructor(url) {
    super(url);
    spied.sockets.push(this);
    this.addEventListener("message", ({data}) => {
      if (typeof data === "string") spied.token = JSON.parse(data).token ?? spied.token;
    });
  }
};
const plainFetch = window.fetch, realTimeout = setTimeout;
spied.asked = new Set();  // what is not yet answered
// What was asked has been answered; not that which a test holds back.
spied.answered = () => Promise.race([
  Promise.all(spied.asked), new Promise((late) => realTimeout(late, 1000)),
]);
window.fetch = async (...asked) => {
  const coming = plainFetch(...asked);
  const whole = coming.then((answer) => answer.clone().text()).catch(() => null);
  spied.asked.add(whole);
  whole.then(() => spied.asked.delete(whole));
  const answer = await coming;
  const read = () => Response.prototype.json.call(answer);
  answer.json = async () => {
    const body = await read();
    if (asked[0] === "/profiles") spied.revision = body.revision ?? spied.revision;
    return body;
  };
  return answer;
};
"""


@pytest.fixture(scope="module")
def serve() -> Iterator[Callable[[], FakeHost]]:
    """Starts hosts, and stops them all when the file's tests are done."""
    started: list[FakeHost] = []

    def start() -> FakeHost:
        started.append(FakeHost())
        return started[-1]

    yield start
    for fake in started:
        fake.stop()


@pytest.fixture
def host(serve: Callable[[], FakeHost]) -> FakeHost:
    return serve()


@pytest.fixture
def page(chromium: Browser) -> Iterator[Page]:
    """A fresh profile at 1920x1080 with a stopped clock; any error on the page fails the test."""
    context = chromium.new_context(viewport={"width": 1920, "height": 1080}, locale="nl-NL")
    context.add_init_script(SPY)
    fresh = context.new_page()
    wrong: list[str] = []
    fresh.on("pageerror", lambda error: wrong.append(str(error)))
    fresh.on("console", lambda line: wrong.append(line.text) if "Security" in line.text else None)
    fresh.clock.install(time=0)
    fresh.clock.pause_at(100)  # no machine stalls for that long until then
    yield fresh
    context.close()
    assert wrong == []


@pytest.fixture
def artefact(page: Page) -> Callable[[str], None]:
    """Saves a picture of the page under a name."""
    return lambda name: save(page, name)


@pytest.fixture
def driver(page: Page, host: FakeHost) -> Driver:
    """The page, open and linked; the chair is armed and this page drives it."""
    person = Driver(page, host)
    person.open()
    return person


@pytest.fixture
def menu(driver: Driver) -> Driver:
    """The driver's page with its menu open."""
    driver.state(**OFF)
    driver.page.locator("#menu").click()
    wait_until(lambda: driver.data("view") == "menu", "the menu")
    driver.advance(100, look=(0.5, 0.66))  # off its tiles, so that the gaze chooses none
    return driver


@pytest.fixture
def caretaker(page: Page, host: FakeHost) -> Driver:
    """The caretaker's page on a phone; the driver drives."""
    page.set_viewport_size({"width": 390, "height": 844})
    host.welcome["role"] = "caretaker"
    host.replies.update(CARETAKER)
    host.state.update(you=False, owner="driver")
    person = Driver(page, host)
    person.open("caretaker")
    return person


@pytest.fixture
def ride(driver: Driver) -> Driver:
    """A page that drives, and one mode can be chosen."""
    tiled(driver, AHEAD)
    return driver


@pytest.fixture(scope="module")
def plain_page(chromium, serve):
    """A page that only loads modules; nothing on it runs by itself."""
    page = chromium.new_page()
    page.goto(serve().url + "static/icon.svg")
    yield page
    page.close()
