"""A small stand-in for the host, and the driver's page in a real Chromium with a clock of ours."""

import io
import json
import os
import struct
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from flask import Flask, Response, send_from_directory
from flask_sock import Sock
from PIL import Image, ImageDraw
from playwright.sync_api import Browser, Page, sync_playwright
from simple_websocket import ConnectionClosed, Server
from werkzeug.serving import make_server

import gazesetup

WEB = Path(__file__).parents[2] / "web"
PATIENCE_S = 30.0
CHROMIUM_OPTIONS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
WELCOME = {
    "k": "welcome",
    "role": "driver",
    "simulated": False,
    "backward": False,
    "dwell_ms": 600,
    "leave_grace_ms": 200,
    "heartbeat_ms": 50,
    "pointer_stale_ms": 500,
}
ARMED = {
    "k": "state",
    "state": "armed",
    "motion": "stopped",
    "override": "none",
    "arm_reason": "none",
    "decisions": dict.fromkeys(("forward", "backward", "left", "right"), "free"),
    "level": "ok",
    "message": "ok",
    "board": "ok",
    "lidar": "ok",
    "camera": "ok",
    "owner": "driver",
    "you": True,
    "edge": 0,
    "heading_deg": 0.0,
    "wipers": [170, 170],
    "simulated": False,
}
# Counts what reached the page, and lets a test speak on the page's own sockets.
SPY = """
window.spied = {token: 0, sockets: []};
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
"""


def wait_until(condition: Callable[[], Any], what: str) -> Any:
    """The condition's first true value; the test fails when it does not come."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        if value := condition():
            return value
        time.sleep(0.005)
    pytest.fail(f"waited {PATIENCE_S:.0f} s in vain for {what}")


def picture(width: int = 1280, height: int = 720, shade: int = 0) -> bytes:
    """A JPEG of a bright corridor, so that screenshots show the page over a camera picture."""
    image = Image.new("RGB", (width, height), (226 - shade, 222 - shade, 210 - shade))
    draw = ImageDraw.Draw(image)
    x, y = width // 2, int(height * 0.42)
    draw.polygon([(0, height), (width, height), (x + 130, y + 60), (x - 130, y + 60)], "#a98c66")
    draw.rectangle([x - 130, y - 130, x + 130, y + 60], fill="#cfd6d8")
    draw.rectangle([x - 50, y - 90, x + 50, y + 60], fill="#7d5a3c")
    for side in (-1, 1):
        draw.line([(x + side * 130, y - 130), (x + side * width, -300)], "#b7b2a4", 4)
        draw.line([(x + side * 130, y + 60), (x + side * x, height)], "#8d8775", 4)
    out = io.BytesIO()
    image.save(out, "JPEG", quality=80)
    return out.getvalue()


class FakeHost:
    """Serves the real page; the test says what the host would say and reads what it hears."""

    def __init__(self) -> None:
        self.welcome: dict[str, Any] = dict(WELCOME)
        self.state: dict[str, Any] = dict(ARMED)
        self.heard: list[dict[str, Any]] = []
        self.acknowledged: list[str] = []
        self.accepting = True
        self.token = 0
        self._marks = 0
        self._sockets: dict[str, list[Server]] = {"control": [], "video": []}
        self._lock = threading.Lock()
        self._server = make_server("127.0.0.1", 0, self._application(), threaded=True)
        self.url = f"http://127.0.0.1:{self._server.server_port}/"
        self._thread = threading.Thread(target=self._server.serve_forever, name="fake host")
        self._thread.start()

    def _application(self) -> Flask:
        app = Flask("fakehost", static_folder=str(WEB), static_url_path="/static")
        sock = Sock(app)

        @app.get("/")
        def page() -> Response:
            return send_from_directory(WEB, "index.html")

        @app.get("/strings/<name>")
        def strings(name: str) -> Response:
            return send_from_directory(WEB / "strings", name)

        @app.after_request
        def strict(answer: Response) -> Response:
            answer.headers["Content-Security-Policy"] = (
                "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:;"
                " connect-src 'self'"
            )
            return answer

        @sock.route("/ws/control")
        def control(ws: Server) -> None:
            self._serve(ws, "control", lambda text: self.heard.append(json.loads(text)))

        @sock.route("/ws/video")
        def video(ws: Server) -> None:
            self._serve(ws, "video", self.acknowledged.append)

        return app

    def _serve(self, ws: Server, kind: str, hear: Callable[[str], None]) -> None:
        if not self.accepting:
            return
        with self._lock:
            if kind == "control":
                ws.send(json.dumps(self.welcome))
            self._sockets[kind].append(ws)
        try:
            while True:
                hear(ws.receive())
        finally:
            with self._lock:
                self._sockets[kind].remove(ws)

    def say(self, message: dict[str, Any]) -> None:
        self._send("control", json.dumps(message))

    def say_state(self, **changes: Any) -> int:
        """Sends the state with these changes and a fresh token; returns the token."""
        self.state.update(changes)
        self.token += 1
        self.say({**self.state, "token": self.token})
        return self.token

    def show(self, jpeg: bytes, sequence: int, age_ms: int = 0) -> None:
        self._send("video", struct.pack("<II", sequence, age_ms) + jpeg)

    def connected(self, kind: str) -> bool:
        return bool(self._sockets[kind])

    def cut(self) -> None:
        """Closes every socket and takes no new one, as a host that died."""
        self.accepting = False
        for ws in [*self._sockets["control"], *self._sockets["video"]]:
            ws.close()
        wait_until(lambda: not self.connected("control"), "the sockets to close")

    def _send(self, kind: str, data: str | bytes) -> None:
        with self._lock:
            for ws in self._sockets[kind]:
                try:
                    ws.send(data)
                except ConnectionClosed:
                    continue  # its own thread takes it off the list

    def stop(self) -> None:
        self.cut()
        self._server.shutdown()
        self._thread.join(PATIENCE_S)
        self._server.server_close()


class Driver:
    """A person before the page: looks, presses, waits. Time passes only in advance()."""

    def __init__(self, page: Page, host: FakeHost) -> None:
        self.page = page
        self.host = host
        self._wiggle = 0

    def open(self, query: str = "") -> None:
        """Loads the page and waits for its link."""
        self.page.goto(self.host.url + query)
        self.connect()

    def connect(self) -> None:
        """Lets time pass until the page says that its link is alive."""

        def linked() -> bool:
            self.page.clock.run_for(25)
            if self.host.connected("control"):
                self.host.say_state()
            return self.data("link") == "ok" and self.host.connected("video")

        wait_until(linked, "the page's link")

    def data(self, name: str) -> str:
        return self.page.evaluate("name => document.body.dataset[name]", name)

    def text(self, selector: str) -> str:
        return self.page.locator(selector).inner_text()

    def state(self, **changes: Any) -> None:
        """The host's state changes, and the page has taken it in."""
        token = self.host.say_state(**changes)
        wait_until(lambda: self.page.evaluate("spied.token") >= token, "a state to arrive")

    def advance(self, ms: int, look: str | tuple[float, float] | None = None) -> None:
        """Lets `ms` pass; with `look` the pointer keeps trembling on a target or share of screen."""
        for step in range(0, ms, 25):
            if step % 100 == 0:
                self.state()
            if look is not None:
                self.look(look)
            self.page.clock.run_for(min(25, ms - step))

    def spot(self, where: str | tuple[float, float]) -> tuple[float, float]:
        """Centre of a target, or a point given in shares of the screen (px)."""
        if isinstance(where, str):
            box = self.page.locator(f"#{where}").bounding_box()
            assert box is not None, f"{where} is not shown"
            return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        size = self.page.viewport_size
        assert size is not None
        return where[0] * size["width"], where[1] * size["height"]

    def look(self, where: str | tuple[float, float]) -> None:
        """One pointer event there; a gaze trembles, so no two are at the same place."""
        x, y = self.spot(where)
        self._wiggle ^= 1
        self.page.mouse.move(x + 3 * self._wiggle, y)

    def hover(self, target: str) -> None:
        """Looks at the middle first, long enough to be at rest, then dwells on the target."""
        self.advance(350, look=(0.5, 0.6))
        self.advance(650, look=target)

    def heard(self, *kinds: str) -> list[dict[str, Any]]:
        """All messages of these kinds that the page has sent until now."""
        self.host._marks += 1
        mark = {"k": "mark", "n": self.host._marks}
        self.page.evaluate(
            "text => spied.sockets.findLast(s => s.url.endsWith('control') && s.readyState === 1)"
            "?.send(text)",
            json.dumps(mark),
        )
        wait_until(lambda: mark in self.host.heard, "the page's messages")
        return [message for message in self.host.heard if message["k"] in kinds]

    def forget(self) -> None:
        """Forgets what was heard until now."""
        self.heard()
        self.host.heard.clear()

    def screenshot(self, name: str) -> Path:
        folder = Path(os.environ.get("GAZECHAIR_ARTEFACTS", gazesetup.ROOT / ".local/artefacts"))
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name}.png"
        self.page.screenshot(path=path)
        return path


@pytest.fixture
def host() -> Iterator[FakeHost]:
    fake = FakeHost()
    yield fake
    fake.stop()


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    try:
        path = gazesetup.ensure_chromium()
    except gazesetup.NotAvailable as error:
        pytest.skip(str(error))
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(path), args=CHROMIUM_OPTIONS)
        yield browser
        browser.close()


@pytest.fixture
def page(chromium: Browser) -> Iterator[Page]:
    """A fresh profile at 1920x1080 whose clock stands still; what goes wrong fails the test."""
    context = chromium.new_context(viewport={"width": 1920, "height": 1080})
    context.add_init_script(SPY)
    fresh = context.new_page()
    wrong: list[str] = []
    fresh.on("pageerror", lambda error: wrong.append(str(error)))
    fresh.on("console", lambda line: wrong.append(line.text) if "Security" in line.text else None)
    fresh.clock.install(time=0)
    fresh.clock.pause_at(1)
    yield fresh
    context.close()
    assert wrong == []


@pytest.fixture
def driver(page: Page, host: FakeHost) -> Driver:
    """The page, open and linked; the chair is armed and this page drives it."""
    person = Driver(page, host)
    person.open()
    return person
