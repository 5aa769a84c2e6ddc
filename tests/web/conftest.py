"""The pages in a real Chromium, with a simulated clock and person."""

import socket
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Browser, Page

from fakehost import OFF, FakeHost
from patience import wait_until
from plugintiles import AHEAD, tiled
from webperson import CARETAKER, Driver, save
from webscanner import Scanner, opened

# Counts what reached the page, lets a test speak on the page's own sockets, and repeats there what
# came before: the host's states and the pointer's moves, each after some ms on the page's clock.
# What a test waits for, the page waits for in one call: a thousand questions cost much.
SPY = """
window.spied = {token: 0, revision: null, sockets: [], x: -1, move: null};
spied.frame = requestAnimationFrame.bind(window);  // the browser's own
const realTimeout = setTimeout;
const soon = () => new Promise((late) => realTimeout(late, 1000, false));
let check = null;
const news = () => check && realTimeout(() => check?.());  // when the page has taken it in
addEventListener("pointermove", (event) => {
  spied.x = event.clientX;
  if (event.isTrusted) spied.move = event;
  news();
}, true);
const control = (open) => spied.sockets.findLast((s) => s.url.endsWith("control") && open(s));
spied.say = (data) => {
  control((s) => s.readyState === 1)?.dispatchEvent(new MessageEvent("message", { data }));
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
// Lets time pass. Its sum outlives the page, as Playwright's own log of the clock does.
spied.run = (ms) => {
  window.name = Number(window.name) + ms;
  return __pwClock.controller.runFor(ms);
};
// The page takes in the state with this token and the looks at `xs`, then lets `ms` pass with what
// is to come. False when that state or look did not come: Chromium moves with its next frame.
spied.take = async (token, xs, coming) => {
  const taken = () => spied.token >= token && xs.every((x) => Math.abs(spied.x - x) < 1);
  if (!taken()) {
    const come = new Promise((done) => (check = () => taken() && done(true)));
    const came = await Promise.race([come, soon()]);
    check = null;
    if (!came) return false;
  }
  if (!coming) return true;
  await spied.answered();
  for (const [at, text] of coming.sent) setTimeout(spied.say, at, text);
  for (const [at, x, y] of coming.moves) at ? setTimeout(spied.look, at, x, y) : spied.look(x, y);
  await spied.run(coming.ms);
  return true;
};
// The page begins, and tries to reach its host. True while its socket is open.
spied.reach = async () => {
  const ready = () => document.body?.dataset.ready;
  if (!ready()) {
    const begun = new Promise((done) => {
      const watch = new MutationObserver(() => ready() && done(watch.disconnect()));
      watch.observe(document, { subtree: true, attributeFilter: ["data-ready"] });
    });
    await Promise.race([begun, soon()]);
  }
  await spied.run(25);
  const socket = control(() => true);
  const settled = new Promise((done) => {
    for (const kind of ["open", "close"]) socket?.addEventListener(kind, done);
  });
  if (socket?.readyState === 0) await Promise.race([settled, soon()]);
  return socket?.readyState === 1;
};
const Plain = WebSocket;
window.WebSocket = class extends Plain {
  constructor(url) {
    super(url);
    spied.sockets.push(this);
    this.addEventListener("message", ({data}) => {
      if (typeof data === "string") spied.token = JSON.parse(data).token ?? spied.token;
      news();
    });
  }
};
const plainFetch = window.fetch;
spied.pending = new Set();  // what is not yet answered
// What was asked has been answered; not that which a test holds back.
spied.answered = () => Promise.race([Promise.all(spied.pending), soon()]);
window.fetch = async (...asked) => {
  const coming = plainFetch(...asked);
  const whole = coming.then((answer) => answer.clone().text()).catch(() => null);
  spied.pending.add(whole);
  whole.then(() => spied.pending.delete(whole));
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
# The time that has passed on a page before this one in the same window.
PASSED = "__pwClock.controller.log('runFor', 0, Number(window.name))"


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


@pytest.fixture(scope="session")
def listener() -> Iterator[socket.socket]:
    """One address for the hosts of all tests, so that the browser knows their files already."""
    with socket.create_server(("127.0.0.1", 0)) as found:
        yield found


@pytest.fixture
def host(listener: socket.socket) -> Iterator[FakeHost]:
    fake = FakeHost(listener)
    yield fake
    fake.stop()


@pytest.fixture(scope="session")
def opener(chromium: Browser, listener: socket.socket) -> Iterator[Page]:
    """Opens the tests' pages: in its own process, which keeps what they load. 1920x1080."""
    context = chromium.new_context(viewport={"width": 1920, "height": 1080}, locale="nl-NL")
    context.add_init_script(SPY)
    stays = context.new_page()
    stays.clock.install(time=0)
    stays.clock.pause_at(100)  # no machine stalls for that long until then
    context.add_init_script(PASSED)
    here = FakeHost(listener)
    stays.goto(f"{here.url}static/icon.svg")
    here.stop()
    yield stays
    context.close()


@pytest.fixture
def page(opener: Page, host: FakeHost) -> Iterator[Page]:
    """A fresh one with a stopped clock; its host outlives it; any error on it fails the test.

    What its clock does belongs to the opener's other pages as well: time passes by `spied.run`.
    """
    with opener.context.expect_page() as opened:
        opener.evaluate("void open('about:blank')")
    fresh = opened.value
    wrong: list[str] = []
    fresh.on("pageerror", lambda error: wrong.append(str(error)))
    fresh.on("console", lambda line: wrong.append(line.text) if "Security" in line.text else None)
    yield fresh
    fresh.close()
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
def scanner(page: Page, host: FakeHost) -> Scanner:
    """Armed, and this page drives; the switch is the space bar."""
    return opened(page, host)


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
