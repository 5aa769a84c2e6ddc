"""The demo's own check: drives the chair through the page in a real Chromium, end to end."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from gazeboard.core.limits import WIPER_NEUTRAL
from gazedemo.browser import Driver, open_page
from gazedemo.sim_control import SimControl
from gazedemo.stack import Stack

NEUTRAL = (WIPER_NEUTRAL, WIPER_NEUTRAL)
_HOST_SILENT_MS = 100.0  # promise P2; the cable's last bytes are still in transit when it is pulled
_SIM_STEP_MS = 5.0  # the simulator's own sampling of the wipers may add this
_TRIES = 4
_ARMED_S = 4.0
_SHOWN_S = 2.0  # the board's reason is on the page by then, on a busy PC too
# Reasons that appear when a PC stalls for a moment: the driver presses again, as a person would.
# Each such press is counted in the figures.
_STALLS = (
    "host_silent",
    "service_stalled",
    "tick_stalled",
    "needs_new_command",
    "command_expired",
    "stale_token",
)


class CheckFailed(Exception):
    """Raised when a step fails; the text names the step and what was observed."""


class PressEnded(AssertionError):
    """Raised when a press had ended before the step ended it: the PC stalled."""


class Check:
    """Runs the steps in order; `figures` is what --check prints."""

    def __init__(self, stack: Stack, driver: Driver, artefacts: Path) -> None:
        self._stack = stack
        self._sim: SimControl = stack.control()
        self._driver = driver
        self._artefacts = artefacts
        self._pulled = False  # the cable is or was out: the page is disarmed without any stall
        self.figures: dict[str, Any] = {"pressed_again": 0}

    def run(self) -> dict[str, Any]:
        """All steps; CheckFailed at the first that fails."""
        for step in (self.simulation_is_shown, self.arm):
            self._do(step, 1)
        for step in (
            self.hold_forward_and_leave,
            self.step_left,
            self.stop_before_the_wall,
            self.pull_the_cable_and_plug_it_in,
        ):
            self._do(step, _TRIES)
        return self.figures

    def _do(self, step: Callable[[], None], tries: int) -> None:
        """Do it; begin it again, as a driver would, when this PC's stall has ended its press."""
        for tries_left in range(tries - 1, -1, -1):
            try:
                step()
                return
            except (TimeoutError, AssertionError, RuntimeError) as error:
                if not tries_left or not self._stall_ended_it(error):
                    self._fail(step, error)
            try:
                self._recover()
            except (TimeoutError, RuntimeError) as error:
                self._fail(step, error)

    def _fail(self, step: Callable[[], None], error: Exception) -> NoReturn:
        self._driver.screenshot(self._artefacts / f"failed-{step.__name__}.png")
        raise CheckFailed(f"{step.__name__}: {error}") from error

    def _recover(self) -> None:
        """End the step's press, plug the cable in, and switch driving on again."""
        self._driver.release()
        self._driver.rest()
        self._sim.do("plug_cable")
        self._board_is_back()
        self._pulled = False
        self._again()

    def _board_is_back(self) -> None:
        self._driver.wait(
            lambda: self._stack.health()["board"]["state"] == "ok", 20, "the board is back"
        )

    def simulation_is_shown(self) -> None:
        """The page is connected, shows a picture and marks the simulation."""
        driver = self._driver
        driver.wait(lambda: driver.data("link") == "ok", 20, "the page is linked to the host")
        driver.wait(lambda: driver.data("picture") == "fresh", 20, "a picture is shown")
        assert driver.data("simulated") == "true", "no SIMULATIE banner"

    def arm(self) -> None:
        """Request driving until the board is armed."""
        start_s = time.monotonic()
        self.figures["pressed_again"] += self._driver.arm(_TRIES, _ARMED_S)
        self.figures.setdefault("arm_s", round(time.monotonic() - start_s, 2))

    def hold_forward_and_leave(self) -> None:
        """Hold Vooruit: the chair moves. Leave: the wipers are neutral at once."""
        self._mode("continuous")
        start = self._sim.truth()
        self.hold("forward", lambda truth: truth["speed_m_s"] > 0.15, "the chair drives forward")
        self._driver.screenshot(self._artefacts / "driving.png")
        mark = self._sim.do("wiper_log", since=0)["last"]
        released_s = time.monotonic()
        self._driver.release()
        self._driver.rest()
        took_ms = self._neutral_ms(mark, released_s, 2, "neutral wipers after leaving")
        self.figures["leave_to_neutral_ms"] = round(took_ms, 1)
        end = self._sim.wait(lambda t: t["speed_m_s"] == 0, 5, "the chair stands")
        self.figures["forward_m"] = round(_distance(start, end), 2)
        assert self.figures["forward_m"] > 0.1, "it did not get anywhere"

    def step_left(self) -> None:
        """Links in step mode: about 10 degrees, then it stops by itself."""
        self._mode("step")
        before = self._sim.truth()["heading_deg"]
        start_s = time.monotonic()
        self._driver.click("left")
        self._sim.wait(lambda t: tuple(t["wipers"]) != NEUTRAL, 3, "the turn begins")
        self._sim.wait(self._standing, 10, "the turn ends")
        turned = self._sim.truth()["heading_deg"] - before
        self.figures["step_turn_deg"] = round(turned, 1)
        self.figures["step_turn_s"] = round(time.monotonic() - start_s, 2)
        assert 7.0 <= turned <= 13.0, f"turned {turned:.1f} degrees, not about 10"
        self._mode("continuous")

    def stop_before_the_wall(self) -> None:
        """Hold Vooruit towards a wall: override on the page, the chair stands before it."""
        driver = self._driver
        self._sim.do("teleport", x_m=0.3, y_m=0.8, heading_deg=90)
        self._quiet()
        self.hold("forward", lambda truth: truth["speed_m_s"] > 0.1, "it drives at the wall")
        driver.wait(lambda: "obstacle" in self._banner(), 20, "the page shows the override")
        driver.screenshot(self._artefacts / "override.png")
        truth = self._sim.wait(self._standing, 5, "the chair stands before the wall")
        driver.release()
        driver.rest()
        self.figures["wall_clearance_m"] = round(truth["clearance_m"], 2)
        self.figures["override_text"] = " ".join(driver.text("#banner").split())
        assert not truth["collided"], "it touched the wall"
        assert truth["clearance_m"] > 0.0, "it stands in the wall"

    def pull_the_cable_and_plug_it_in(self) -> None:
        """Pull the board's cable while driving; plug it in; drive again after arming."""
        driver = self._driver
        self._sim.do("teleport", x_m=0.0, y_m=0.2, heading_deg=0)
        self._quiet()
        self.hold("forward", lambda truth: truth["speed_m_s"] > 0.1, "the chair drives")
        mark = self._sim.do("wiper_log", since=0)["last"]
        self._pulled = True
        pulled_s = time.monotonic()
        self._sim.do("pull_cable")
        took_ms = self._neutral_ms(mark, pulled_s, 3, "neutral without the cable")
        self.figures["cable_to_neutral_ms"] = round(took_ms, 1)
        limit_ms = _HOST_SILENT_MS + _SIM_STEP_MS
        self.figures["cable_within_promise"] = took_ms <= limit_ms
        shown_s = driver.wait(
            lambda: driver.page.locator("#status[data-level=error]").count() == 1,
            10,
            "the page says that the board is gone",
        )
        self.figures["cable_said_after_s"] = round(shown_s, 2)
        driver.screenshot(self._artefacts / "cable-pulled.png")
        driver.release()
        driver.rest()
        plugged_s = time.monotonic()
        self._sim.do("plug_cable")
        self._board_is_back()
        self.figures["replug_to_ready_s"] = round(time.monotonic() - plugged_s, 2)
        assert tuple(self._sim.wipers()) == NEUTRAL, "it moved by itself"
        self._pulled = False
        self._quiet()
        self.arm()
        self.hold("forward", lambda truth: truth["speed_m_s"] > 0.1, "it drives again")
        driver.release()
        driver.rest()
        self._sim.wait(self._standing, 5, "the chair stands")

    # -- small things

    def _mode(self, mode: str) -> None:
        if self._driver.data("mode") != mode:
            self._driver.click("mode")
        self._driver.wait(lambda: self._driver.data("mode") == mode, 5, f"mode {mode}")

    def _again(self) -> None:
        """What a driver does after a stall of the PC: waits a moment, switches driving on."""
        self.figures["pressed_again"] += 1
        self._quiet()
        if self._disarmed():
            self.arm()

    def hold(self, target: str, condition: Callable[[dict[str, Any]], bool], what: str) -> None:
        """Hold a target until the simulator's truth meets `condition`."""
        for tries_left in range(_TRIES - 1, -1, -1):
            self._driver.press(target)
            try:
                self._sim.wait(condition, 3, what)
                return
            except TimeoutError:
                # A stall of the PC ended the press; the page may no longer show its reason.
                if tries_left == 0:
                    raise
            self._driver.release()
            self._driver.rest()
            self._again()

    def _neutral_ms(self, mark: int, since_s: float, limit_s: float, what: str) -> float:
        """Wait for neutral wipers; ms from `since_s` to the first neutral after `mark`.

        Raises PressEnded when they were neutral before `since_s`.
        """
        self._sim.wait(lambda t: tuple(t["wipers"]) == NEUTRAL, limit_s, what)
        entries = self._sim.do("wiper_log", since=mark)["entries"]
        times_s = [float(e[1]) for e in entries if (e[2], e[3]) == NEUTRAL]
        if not times_s or times_s[0] < since_s:
            raise PressEnded(f"{what}: they were neutral before")
        return 1000 * (times_s[0] - since_s)

    def _disarmed(self) -> bool:
        return self._driver.data("state") == "disarmed"

    def _stalled(self) -> bool:
        return self._banner() in _STALLS

    def _stall_ended_it(self, error: Exception) -> bool:
        """Whether a stall ended the press: by the error, or on the page now or in a moment."""
        if isinstance(error, PressEnded):
            return True
        if self._pulled:
            return False
        try:
            self._driver.wait(lambda: self._disarmed() or self._stalled(), _SHOWN_S, "a stall")
        except TimeoutError:
            return False
        return True

    def _banner(self) -> str:
        key: str = self._driver.page.evaluate("document.getElementById('banner').dataset.key ?? ''")
        return key

    def _quiet(self) -> None:
        """Wait a moment without a request, as between two looks; ends an old override."""
        self._driver.page.wait_for_timeout(500)

    def _standing(self, truth: dict[str, Any]) -> bool:
        still = abs(truth["speed_m_s"]) < 0.01 and abs(truth["yaw_rate_deg_s"]) < 0.5
        return still and tuple(truth["wipers"]) == NEUTRAL


def _distance(a: dict[str, Any], b: dict[str, Any]) -> float:
    return float(((a["x_m"] - b["x_m"]) ** 2 + (a["y_m"] - b["y_m"]) ** 2) ** 0.5)


def check(stack: Stack, chromium: str | Path, artefacts: Path) -> dict[str, Any]:
    """Run the whole check on a running stack; returns the figures, raises CheckFailed."""
    with open_page(chromium, stack.invitation()) as driver:
        return Check(stack, driver, artefacts).run()
