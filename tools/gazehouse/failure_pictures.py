"""Takes the pictures of docs/when-it-fails.md: each failure is caused in the simulated chair."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import gazesetup
from gazechair.base.languages import label, message
from gazedemo.browser import Driver, open_page
from gazedemo.check import Check
from gazedemo.stack import Stack
from gazehouse.failures import FAILURES, Failure, picture

_DRIVER = (1024, 576)
_PHONE = (390, 844)
_LIMIT_S = 60.0
_HELD_S = 4.0
# Faults of the computer itself, in all of the host's processes.
_FULL = "import gazechair.blackbox.writer as writer\nwriter.KEPT_FREE = 1 << 60\n"
_HOT = """\
from pathlib import Path
import gazechair.base.machine as machine
machine.Machine.__init__.__defaults__ = (Path({folder!r}),)
"""
_FIRST_LIDAR = '[[lidar]]\nname = "front"'
_SECOND_LIDAR = """
[[lidar]]
name = "rear"
kind = "s2"
port = "{folder}/none"
x_m = -0.4
heading_deg = 180.0
mask = [[95, -95]]
"""


class _Scene:
    """One stack, its driver and its caretaker."""

    def __init__(self, stack: Stack, driver: Driver, caretaker: Driver, site: Path) -> None:
        self.stack = stack
        self.driver = driver
        self.caretaker = caretaker
        self._site = site
        self._check = Check(stack, driver, gazesetup.LOCAL / "artefacts")
        self._config = stack.folder / "gazechair.toml"
        self._plain = self._config.read_text("utf-8")

    @contextlib.contextmanager
    def fault(self, name: str) -> Iterator[None]:
        """A fault of the simulator."""
        self.stack.control().do("inject", fault=name)
        yield
        self.stack.control().do("clear", fault=name)

    @contextlib.contextmanager
    def restarted(self, site: str = "", config: str = "") -> Iterator[None]:
        """Restart the host on another computer, or with another configuration."""
        self._restart(site, config or self._plain)
        yield
        self._restart("", self._plain)

    @contextlib.contextmanager
    def stopped(self) -> Iterator[None]:
        """The host sends nothing."""
        os.kill(self.stack.pid("host"), signal.SIGSTOP)
        yield
        os.kill(self.stack.pid("host"), signal.SIGCONT)

    @contextlib.contextmanager
    def slow(self) -> Iterator[None]:
        """The host stalls for a moment every second."""

        def stutter() -> None:
            os.kill(self.stack.pid("host"), signal.SIGSTOP)
            time.sleep(0.4)
            os.kill(self.stack.pid("host"), signal.SIGCONT)

        with _repeated(stutter, 0.6):
            yield

    @contextlib.contextmanager
    def held_up(self) -> Iterator[None]:
        """The tablet stalls for a moment while the driver holds Vooruit."""
        self._check.arm()
        self._check.hold("forward", lambda truth: truth["speed_m_s"] > 0.15, "the chair drives")
        busy = f"const end = performance.now() + {1000 * _HELD_S}; while (performance.now() < end);"
        self.driver.page.evaluate(f"setTimeout(() => {{ {busy} }}, 0)")
        yield
        self.driver.release()

    @contextlib.contextmanager
    def called(self) -> Iterator[None]:
        """The driver calls while no caretaker's page is open."""
        self.caretaker.page.goto("about:blank")
        self.driver.page.wait_for_timeout(4000)
        self.driver.click("help")
        yield
        self.driver.click("help")

    @contextlib.contextmanager
    def plugin_killed(self) -> Iterator[None]:
        """Its process ends, as often as it is started."""

        def kill() -> None:
            for pid in _children(self.stack.pid("host"), b'"name": "ahead"'):
                os.kill(pid, signal.SIGKILL)

        with _repeated(kill, 0.1):
            yield

    def hot(self) -> contextlib.AbstractContextManager[None]:
        """A computer at 96 degrees Celsius."""
        zone = self._site / "thermal" / "thermal_zone0"
        zone.mkdir(parents=True)
        (zone / "temp").write_text("96000\n")
        return self.restarted(_HOT.format(folder=str(zone.parent)))

    def one_of_two(self) -> contextlib.AbstractContextManager[None]:
        """A second lidar that is configured but missing."""
        more = _SECOND_LIDAR.format(folder=self.stack.folder)
        return self.restarted(config=self._plain.replace("[lidar]", _FIRST_LIDAR) + more)

    def _restart(self, site: str, config: str) -> None:
        os.kill(self.stack.pid("host"), signal.SIGTERM)
        while self.stack.ended("host") is None:
            self.driver.page.wait_for_timeout(50)
        (self._site / "sitecustomize.py").write_text(site)
        self._config.write_text(config, "utf-8")
        self.stack.start_host()


_Cause = Callable[[_Scene], contextlib.AbstractContextManager[None]]
CAUSES: dict[str, tuple[_Cause, str]] = {
    "no camera": (lambda scene: scene.fault("camera_off"), "driver"),
    "no heading": (lambda scene: scene.fault("imu_nak"), "driver"),
    "no lidar": (lambda scene: scene.fault("lidar_stall"), "driver"),
    "one of two lidars": (_Scene.one_of_two, "driver"),
    "no network": (_Scene.stopped, "driver"),
    "no tablet": (_Scene.held_up, "caretaker"),
    "no caretaker": (_Scene.called, "driver"),
    "disk full": (lambda scene: scene.restarted(_FULL), "caretaker"),
    "host too slow": (_Scene.slow, "driver"),
    "host too hot": (_Scene.hot, "driver"),
    "board restarting": (lambda scene: scene.fault("cable_pulled"), "driver"),
    "a plug-in failing": (_Scene.plugin_killed, "driver"),
}


def take(stack: Stack, chromium: str | Path, site: Path, only: tuple[str, ...] = ()) -> list[Path]:
    """Take all, or `only` those; returns the files. `site` is in the path of the host's Python."""
    taken = []
    with (
        open_page(chromium, stack.invitation(), _DRIVER) as driver,
        _second_page(driver, stack.invitation("caretaker", "nl")) as caretaker,
    ):
        scene = _Scene(stack, driver, caretaker, site)
        for failure in FAILURES:
            if failure.key and (not only or failure.what in only):
                taken.append(_take(scene, failure))
    return taken


def _take(scene: _Scene, failure: Failure) -> Path:
    cause, who = CAUSES[failure.what]
    person = scene.driver if who == "driver" else scene.caretaker
    scene.driver.wait(lambda: _quiet(scene.driver), _LIMIT_S, f"all is well before {failure.what}")
    with cause(scene):
        words = _words(failure.key)
        path = picture(failure)
        path.parent.mkdir(exist_ok=True)
        shown = False
        while not shown:  # a computer that stalls may show something else in between
            person.wait(lambda: words in person.text("body"), _LIMIT_S, words)
            if person is scene.caretaker:
                person.wait(lambda: _quiet(person), _LIMIT_S, "a picture")
            person.page.screenshot(path=path, type="jpeg", quality=60)
            shown = words in person.text("body")
    return path


def _quiet(driver: Driver) -> bool:
    return driver.data("link") == "ok" and driver.data("picture") == "fresh"


def _words(key: str) -> str:
    try:
        return message("nl", key)[0]
    except KeyError:
        return label("nl", key)


@contextlib.contextmanager
def _second_page(driver: Driver, url: str) -> Iterator[Driver]:
    """A second page in the same browser, with its own cookies."""
    browser = driver.page.context.browser
    assert browser is not None
    page = browser.new_page(viewport={"width": _PHONE[0], "height": _PHONE[1]})
    page.goto(url)
    page.wait_for_url(lambda address: "/pair" not in address)
    yield Driver(page)
    page.close()


@contextlib.contextmanager
def _repeated(cause: Callable[[], None], pause_s: float) -> Iterator[None]:
    """Cause it repeatedly on a separate thread."""
    ended = threading.Event()

    def run() -> None:
        while not ended.wait(pause_s):
            cause()

    thread = threading.Thread(target=run, name="cause")
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def _children(parent: int, words: bytes) -> Iterator[int]:
    """Processes of `parent` whose command line has these words."""
    for pid in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError):
            stat = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
            if int(stat[1]) == parent and words in Path(f"/proc/{pid}/cmdline").read_bytes():
                yield int(pid)
