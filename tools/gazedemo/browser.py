"""A real Chromium that operates the driver's page: presses and releases targets, reads the page."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

# Playwright's own list, which this one replaces, plus the address bar's suggestions and a spare
# renderer for a next page: for each page they would start a process that takes as long as the page.
_WITHOUT = (
    "AimEnabled",
    "AvoidCorsURLLoaderRestartOnRedirect",
    "AvoidUnnecessaryBeforeUnloadCheckSync",
    "DestroyProfileOnBrowserClose",
    "HttpsFirstBalancedModeAutoEnable",
    "HttpsUpgrades",
    "LensOverlay",
    "MediaRouter",
    "NetworkTimeServiceQuerying",
    "OptimizationHints",
    "PaintHolding",
    "PreconnectToSearch",
    "SpareRendererForSitePerProcess",
    "ThirdPartyStoragePartitioning",
    "WebUIOmniboxAimPopup",
    "WebUIOmniboxPopup",
)
OPTIONS = (
    f"--disable-features={','.join(_WITHOUT)}",
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


class Driver:
    """A person with a mouse: presses and holds. Times are wall-clock seconds."""

    def __init__(self, page: Page) -> None:
        self.page = page

    def data(self, name: str) -> str:
        """A fact the page keeps on its body: state, mode, link, picture, simulated."""
        value: str = self.page.evaluate("name => document.body.dataset[name]", name)
        return value

    def text(self, selector: str) -> str:
        """The text of an element as a person reads it."""
        return self.page.locator(selector).inner_text()

    def press(self, target: str) -> None:
        """Press the mouse button on a target and hold it."""
        box = self.page.locator(f"#{target}").bounding_box()
        if box is None:
            raise RuntimeError(f"the page shows no target {target!r}")
        self.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        self.page.mouse.down()

    def release(self) -> None:
        """Release."""
        self.page.mouse.up()

    def rest(self) -> None:
        """Move the pointer to the empty rest zone."""
        size = self.page.viewport_size
        assert size is not None
        self.page.mouse.move(size["width"] * 0.5, size["height"] * 0.6)

    def click(self, target: str) -> None:
        """Press and release, then rest."""
        self.press(target)
        self.release()
        self.rest()

    def arm(self, tries: int, limit_s: float) -> int:
        """Press until the page says that driving is on; the number of presses that did not do it.

        The target switches driving off, too: it is never pressed while driving is on.
        TimeoutError with the page's hint after `tries` presses of `limit_s` each.
        """
        for late in range(tries):
            if self.data("state") != "armed":
                self.click("arm")
            with contextlib.suppress(TimeoutError):
                self.wait(lambda: self.data("state") == "armed", limit_s, "armed")
                return late
        raise TimeoutError(f"not armed: {self.text('#hint')}")

    def wait(self, condition: Callable[[], bool], limit_s: float, what: str) -> float:
        """Wait for `condition`; returns the seconds it took. Raises TimeoutError naming `what`."""
        start_s = time.monotonic()
        while not condition():
            if time.monotonic() - start_s > limit_s:
                shown = f"state {self.data('state')}, link {self.data('link')}"
                status = " ".join(self.text("#status").split())
                raise TimeoutError(f"not within {limit_s:g} s: {what}; page: {shown}, {status!r}")
            self.page.wait_for_timeout(20)
        return time.monotonic() - start_s

    def screenshot(self, path: Path) -> None:
        """Save a picture of the page."""
        path.parent.mkdir(parents=True, exist_ok=True)
        self.page.screenshot(path=path)


@contextlib.contextmanager
def open_page(
    chromium: str | Path, url: str, size: tuple[int, int] = (1366, 768)
) -> Iterator[Driver]:
    """The page at `url`, for instance an invitation, in a fresh headless Chromium."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(chromium), args=list(OPTIONS))
        try:
            page = browser.new_page(viewport={"width": size[0], "height": size[1]})
            page.goto(url)
            page.wait_for_url(lambda address: "/pair" not in address)  # the page pairs itself first
            yield Driver(page)
        finally:
            browser.close()
