"""A real Chromium at the door: encrypted, paired by a link, sent away when revoked."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, sync_playwright

import gazesetup
from gazechair.config import configuration
from gazechair.daemon import Daemon
from gazechair.people.pairing.local import ask
from gazedemo.browser import OPTIONS
from gazedemo.pairing import invitation

pytestmark = [pytest.mark.browser, pytest.mark.e2e]
LONG_MS = 30_000


class Door:
    """A daemon without devices, encrypted, and a browser that knows nobody yet."""

    def __init__(self, folder: Path, page: Page) -> None:
        self.state = folder / "state"
        text = f'[board]\nport = "{folder}/none"\n[web]\nport = 0\ntls = true\n'
        self.daemon = Daemon(configuration.parse(text + f'state_folder = "{self.state}"\n'))
        self.daemon.start()
        self.page = page

    def open(self, path: str = "") -> None:
        self.page.goto(self.daemon.url + path)

    def at(self, path: str) -> None:
        """Waits until the browser is there."""
        self.page.wait_for_url(lambda url: url.split("#")[0].endswith(path), timeout=LONG_MS)

    def linked(self) -> None:
        """Waits until the page's control socket is alive."""
        self.page.wait_for_selector("body[data-link=ok]", timeout=LONG_MS)

    def devices(self) -> list[dict[str, Any]]:
        return list(ask(self.state, {"ask": "list"})["devices"])


@pytest.fixture
def door(tmp_path: Path) -> Iterator[Door]:
    with sync_playwright() as playwright:
        path = gazesetup.ensure_chromium()
        browser = playwright.chromium.launch(executable_path=str(path), args=list(OPTIONS))
        # This browser does not know the certificate; tests/host/web checks who is trusted.
        page = browser.new_context(ignore_https_errors=True, locale="nl-NL").new_page()
        door = Door(tmp_path, page)
        yield door
        door.daemon.stop()
        browser.close()


def test_a_link_pairs_a_browser_once_and_for_long(door: Door) -> None:
    door.open()
    door.at("/pair")
    link = invitation(door.state)
    door.page.goto(link)
    door.at("/")
    door.linked()
    assert "#" not in door.page.url
    assert [device["role"] for device in door.devices()] == ["driver"]
    (cookie,) = door.page.context.cookies()
    assert (cookie["secure"], cookie["httpOnly"], cookie["sameSite"]) == (True, True, "Strict")
    assert door.page.evaluate("document.cookie") == ""
    door.open()  # the next morning
    door.at("/")
    door.linked()


def test_a_revoked_browser_is_back_at_the_door(door: Door) -> None:
    door.page.goto(invitation(door.state))
    door.linked()
    (device,) = door.devices()
    ask(door.state, {"ask": "revoke", "id": device["id"]})
    door.at("/pair")
    door.open()
    door.at("/pair")


def test_a_wrong_code_is_said_and_a_right_one_typed(door: Door) -> None:
    door.open("pair")
    page = door.page
    page.fill("#code", "2222-2222")
    page.click("#go")
    page.wait_for_selector("#answer[data-kind=error]", timeout=LONG_MS)
    code = invitation(door.state, "driver").partition("#")[2]
    page.fill("#code", code.lower().replace("-", " "))
    page.click("#go")
    door.at("/")
    door.linked()
