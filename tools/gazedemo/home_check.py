"""The check of the demo in a home: an auto motion to the kitchen, through the page."""

from __future__ import annotations

import contextlib
import json
import math
import time
from pathlib import Path
from typing import Any

from gazedemo import home
from gazedemo.browser import Driver, open_page
from gazedemo.check import CheckFailed
from gazedemo.stack import Stack
from gazesim import plans

_GOAL = "Keuken"
_NEAR_M, _NEAR_DEG = 0.15, 5.0
_POSE_S = 90.0
_ARMED_S = 6.0
_ARRIVES_S = 240.0
_LOOK_S = 0.4  # between two eye movements
_PRESSES = 40  # a machine that stalls for 150 ms ends a press, as it should
_TRIES = 12


Riding = contextlib.AbstractContextManager[object]


class HomeCheck:
    """Drives to the kitchen through the page, in real processes; checks the simulator's truth."""

    def __init__(self, stack: Stack, driver: Driver, artefacts: Path, ride: Riding) -> None:
        """`ride`: entered for the time from the first press to the arrival."""
        self._stack = stack
        self._ride = ride
        self._sim = stack.control()
        self._driver = driver
        self._artefacts = artefacts
        self.figures: dict[str, Any] = {"pressed_again": 0}

    def run(self) -> dict[str, Any]:
        """Run the whole check; returns the figures. Raises CheckFailed."""
        try:
            self._find_itself()
            self._driver.arm(_TRIES, _ARMED_S)
            with self._ride:
                self._go()
            self._judge()
        except (TimeoutError, AssertionError, RuntimeError) as error:
            self._driver.screenshot(self._artefacts / "failed-home.png")
            seen = {"figures": self.figures, "truth": self._sim.truth()}
            raise CheckFailed(f"{error}; {json.dumps(seen)}") from error
        return self.figures

    def _find_itself(self) -> None:
        driver = self._driver
        driver.wait(lambda: driver.data("link") == "ok", 20, "the page is linked to the host")
        start_s = time.monotonic()
        what = "the chair knows where it is, and its places are tiles"
        driver.wait(lambda: driver.data("more") == "true", _POSE_S, what)
        self.figures["found_itself_s"] = round(time.monotonic() - start_s, 1)

    def _find_tile(self) -> str:
        """Switch driving on until the goal's tile can be pressed; returns the tile."""
        end_s = time.monotonic() + _POSE_S
        while time.monotonic() < end_s:
            if self._driver.data("state") != "armed":
                self._driver.arm(_TRIES, _ARMED_S)  # a machine that stalls ends driving
            with contextlib.suppress(RuntimeError):  # driving has just ended: the tiles are gone
                if tile := self._tile():
                    return tile
            self._driver.page.wait_for_timeout(100)
        raise TimeoutError(f"no tile {_GOAL}")

    def _tile(self) -> str:
        """The tile of the goal, on the page of modes; "" when it cannot be pressed."""
        driver = self._driver
        if not driver.page.locator("#mode").is_visible():
            return ""
        for _ in range(_TRIES):
            if driver.data("mode") == "more":
                break
            driver.click("mode")
            driver.page.wait_for_timeout(100)
        for number in (1, 2, 3):
            tile = f"#plugin-{number}"
            able = driver.page.locator(f"{tile}:not(.unable)").is_visible()
            if able and _GOAL in driver.text(tile):
                return tile[1:]
        return ""

    def _go(self) -> None:
        """Press its tile; look at the page while it drives; resume when it has stopped."""
        driver = self._driver
        start_s = time.monotonic()
        shot = False
        looks_at = 0
        state: dict[str, Any] = {}
        for press in range(_PRESSES):
            tile = self._find_tile()
            driver.press(tile)
            driver.release()
            self.figures["pressed_again"] = press
            pressed_s = time.monotonic()
            while True:
                looks_at = 1 - looks_at
                driver.page.mouse.move(668 + 30 * looks_at, 461)
                driver.page.wait_for_timeout(1000 * _LOOK_S)
                state = self._state()
                if state["state"] == "arrived":
                    self.figures["drive_s"] = round(time.monotonic() - start_s, 1)
                    return
                if state["state"] == "drives" and not shot and self._moved(1.5):
                    driver.screenshot(self._artefacts / "going.png")
                    shot = True
                if time.monotonic() - start_s > _ARRIVES_S:
                    raise TimeoutError(f"not there after {_ARRIVES_S:g} s: {state}")
                if state["state"] == "ended" and time.monotonic() - pressed_s > 2.0:
                    self.figures.setdefault("ended", []).append(state["reason"])
                    break
        raise AssertionError(f"it ended {_PRESSES} times: {state}")

    def _state(self) -> dict[str, Any]:
        """The newest news of the auto motion on the page."""
        return {"state": self._driver.data("going"), "reason": self._driver.data("why")}

    def _moved(self, far_m: float) -> bool:
        x, y, _ = plans.room(home.ROOM).start
        truth = self._sim.truth()
        return math.dist((x, y), (truth["x_m"], truth["y_m"])) > far_m

    def _judge(self) -> None:
        truth = self._sim.wait(lambda t: abs(t["speed_m_s"]) < 0.01, 5, "the chair stands")
        _, x, y, heading = plans.FLAT_PLACES[_GOAL]
        off_m = math.dist((x, y), (truth["x_m"], truth["y_m"]))
        off_deg = abs(math.remainder(truth["heading_deg"] - heading, 360.0))
        self.figures["off_m"] = round(off_m, 3)
        self.figures["off_deg"] = round(off_deg, 1)
        self.figures["contacts"] = truth["collisions"]
        self._driver.screenshot(self._artefacts / "arrived.png")
        assert truth["collisions"] == 0, "it touched something"
        assert off_m <= _NEAR_M, f"{off_m:.2f} m from the kitchen's place"
        assert off_deg <= _NEAR_DEG, f"{off_deg:.1f} degrees from its heading"


def check(
    stack: Stack, chromium: str | Path, artefacts: Path, ride: Riding | None = None
) -> dict[str, Any]:
    """Run it on a running stack; returns the figures, raises CheckFailed. `ride`: see HomeCheck."""
    home.allow(stack)
    with open_page(chromium, stack.invitation()) as driver:
        return HomeCheck(stack, driver, artefacts, ride or contextlib.nullcontext()).run()
