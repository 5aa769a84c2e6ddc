"""A person before a page in a Chromium, and what the host answers a caretaker."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from playwright.sync_api import Page

from fakehost import FakeHost
from patience import wait_until

DEVICE = {"id": "3fa2b1", "role": "driver", "name": "tablet", "created": 0, "last_used": 0}
PHONE = {**DEVICE, "id": "9c01aa", "role": "caretaker", "name": "phone", "you": True}
ALERT = {
    "number": 3,
    "key": "alert_overruled",
    "kind": "stuck",
    "at": 1_790_000_000,
    "sentence": "Ik zit vast in het park",
    "detail": "",
    "count": 1,
    "state": "open",
    "by": "",
    "deliveries": {"anna": {"state": "failed", "detail": "no network"}},
}
SETTINGS = {
    "profile": {"value": 2, "low": 0, "high": 4, "default": 2},
    "linear_permille": {"value": 600, "low": 50, "high": 1000, "default": 600},
    "step_forward_ms": {"value": 2000, "low": 100, "high": 5000, "default": 2000},
    "step_turn_q4_deg": {"value": 160, "low": 32, "high": 1440, "default": 160},
}
CODE = {
    "code": "K7QM-2XWD",
    "role": "driver",
    "valid_s": 300,
    "url": "https://192.168.1.5:8080/pair",
}
# What the host answers a caretaker.
CARETAKER = {
    "GET /settings": (200, {"settings": SETTINGS}),
    "POST /settings": (200, {"settings": SETTINGS}),
    "GET /alerts": (200, {"revision": 1, "routes": ["anna"], "alerts": [ALERT]}),
    "POST /alerts": (
        200,
        {"revision": 2, "routes": ["anna"], "alerts": [{**ALERT, "state": "acknowledged"}]},
    ),
    "GET /pairing": (200, {"devices": [{**DEVICE, "you": False}, PHONE]}),
    "POST /pairing/code": (200, {**CODE, "qr": ["1010" * 6, "0110" * 6] * 12}),
    "POST /pairing/revoke": (200, {"devices": [PHONE]}),
}

# Where an element is, null when it is not shown: one question to the browser, not three.
BOX = """selector => {
  const { x, y, width, height } = document.querySelector(selector)?.getBoundingClientRect() ?? {};
  return width && height ? { x, y, width, height } : null;
}"""
# A page without a word from its host for 500 ms takes its link as lost.
PART_MS = 400


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
            self.host.now_ms += 25
            if not self.page.evaluate("spied.reach()") or not self.host.connected("control"):
                return False
            return self._takes(self.host.say_state(), []) and self.data("link") == "ok"

        wait_until(linked, "the page's link")
        wait_until(
            lambda: self.host.connected("video") or self.page.evaluate("false"),
            "the link of its picture",
        )

    def run_for(self, ms: int) -> None:
        """Lets `ms` pass on the page's clock and the host's; the host says nothing."""
        self.host.now_ms += ms
        self.page.evaluate("ms => spied.run(ms)", ms)

    def wait_until(self, condition: Callable[[], Any], what: str) -> None:
        """Lets Playwright deliver events (requests, routes), which it does only during calls."""
        wait_until(lambda: self.page.evaluate("true") and condition(), what)

    def answered(self) -> None:
        """Everything that the page has asked of the host is answered."""
        answered = "spied.answered().then(() => spied.pending.size === 0)"
        self.wait_until(lambda: self.page.evaluate(answered), "the answers")

    def data(self, name: str) -> str:
        return self.page.evaluate("name => document.body.dataset[name]", name)

    def text(self, selector: str) -> str:
        return self.page.locator(selector).inner_text()

    def state(self, **changes: Any) -> None:
        """The host's state changes, and the page has taken it in."""
        self._taken_in(self.host.say_state(**changes), [])

    def takes_profiles(self) -> None:
        """Waits until the page has read the profiles as the host has them now."""
        wait_until(
            lambda: self.page.evaluate("spied.revision") == self.host.profiles.revision,
            "the page to read the profiles",
        )

    def advance(self, ms: int, look: str | tuple[float, float] | None = None) -> None:
        """Lets `ms` pass; with `look` the pointer keeps trembling where that is now.

        The host says its state every 100 ms, and the pointer moves every 50 ms. Of every
        PART_MS the first state comes from the host and the first move of all from the browser;
        the others happen on the page, on its own clock.
        """
        spot = None if look is None else self.spot(look)
        there = [] if spot is None else [self._tremble(*spot)]
        for start in range(0, ms, PART_MS):
            part_ms = min(PART_MS, ms - start)
            token = self.host.say_state()
            sent = [[at, self.host.coming_state(at)] for at in range(100, part_ms, 100)]
            moves = [] if spot is None else self._trembles(part_ms, *spot)
            self._taken_in(token, there, {"sent": sent, "moves": moves, "ms": part_ms})
            self.host.now_ms += part_ms
            there = []

    def spot(self, where: str | tuple[float, float]) -> tuple[float, float]:
        """Centre of a target, or a point given in shares of the screen (px)."""
        if isinstance(where, str):
            box = wait_until(lambda: self.page.evaluate(BOX, f"#{where}"), f"{where} to be shown")
            return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        size = self.page.viewport_size
        assert size is not None
        return where[0] * size["width"], where[1] * size["height"]

    def look(self, where: str | tuple[float, float]) -> None:
        """One pointer event there; a gaze trembles, so no two are at the same place."""
        self._tremble(*self.spot(where))

    def _taken_in(
        self, token: int, there: list[float], coming: dict[str, Any] | None = None
    ) -> None:
        # A page whose time passes without any move would take the gaze as lost.
        wait_until(lambda: self._takes(token, there, coming), "state and look to arrive")

    def _takes(self, *news: Any) -> bool:
        taken: bool = self.page.evaluate("news => spied.take(...news)", news)
        return taken

    def _tremble(self, x: float, y: float) -> float:
        """Moves the pointer there in the browser; returns its x."""
        self._wiggle ^= 1
        self.page.mouse.move(x + 3 * self._wiggle, y)
        return x + 3 * self._wiggle

    @staticmethod
    def _trembles(ms: int, x: float, y: float) -> list[list[float]]:
        """Moves on the page, [in ms, x, y]: never to where the browser's own pointer is."""
        return [[at, x + (1 if at % 100 else 4), y] for at in range(0, ms, 50)]

    def hover(self, target: str) -> None:
        """Looks at the middle first, long enough to be at rest, then dwells on the target."""
        self.advance(350, look=(0.5, 0.6))
        self.advance(650, look=target)

    def keyed(self, kind: str, key: str, code: str) -> None:
        """A key event as of a keyboard whose keys have other names while another one is down."""
        self.page.evaluate(
            "([kind, key, code]) => document.activeElement.dispatchEvent("
            "new KeyboardEvent(kind, {key, code, bubbles: true, cancelable: true}))",
            [kind, key, code],
        )

    def received(self, *kinds: str) -> list[dict[str, Any]]:
        """All messages of these kinds that the page has sent until now."""
        self.host._marks += 1
        mark = {"k": "mark", "n": self.host._marks}
        self.page.evaluate(
            "text => spied.sockets.findLast(s => s.url.endsWith('control') && s.readyState === 1)"
            "?.send(text)",
            json.dumps(mark),
        )
        wait_until(lambda: mark in self.host.received, "the page's messages")
        return [message for message in self.host.received if message["k"] in kinds]

    def newest(self) -> dict[str, Any]:
        """The newest message that moves or stops the chair."""
        return self.received("cmd", "stop")[-1]

    def forget(self) -> None:
        """Discards the messages received until now."""
        self.received()
        self.host.received.clear()

    def screenshot(self, name: str) -> None:
        save(self.page, name)


def save(page: Page, name: str) -> None:
    """Keeps a picture of the page in the folder GAZECHAIR_ARTEFACTS, for people to look at."""
    folder = os.environ.get("GAZECHAIR_ARTEFACTS")
    if folder:
        Path(folder).mkdir(parents=True, exist_ok=True)
        page.screenshot(path=Path(folder) / f"{name}.png")
