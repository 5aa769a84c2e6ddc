"""Page to wipers in virtual time: control, arbiter and link protocol with the real firmware."""

from __future__ import annotations

from typing import Any

import pytest

from gazeboard.io.joystick import permille
from gazechair.base.health import OK, HealthRegistry
from gazechair.board.board_commands import Clearance
from gazechair.config.settings import Config
from gazechair.driving.control import Control
from gazelink import codes
from gazesim.chair_rig import ChairRig
from gazesim.lockstep_link import LockstepLink


class Chain(ChairRig):
    """The chair with control and link of the real host, a page, and simulated clearances."""

    def __init__(self) -> None:
        super().__init__()
        self.link = LockstepLink(self.cable, self.now_s, iter(range(7, 99)).__next__)
        parts = HealthRegistry(self.now_s)
        for name in ("board", "lidar", "camera"):
            parts.part(name).set(OK)
        self.control = Control(Config(), self.link, parts, clock=self.now_s)
        self.page = self.control.connect("driver")
        self.page_alive = True
        self.scanning = True
        self.blocked = 0
        self.held: tuple[str, str, int] | None = None
        self.refusals: list[str] = []

    def host_ms(self) -> None:
        self.link.one_ms()
        if self.scanning and self.now_ms % 100 == 0:
            self.control.clearance(Clearance(self.blocked, codes.SIMULATED, self.now_s() - 0.03))
        if self.now_ms % 25 == 0:
            self.control.update()
        if self.page_alive and self.now_ms % 100 == 0:
            self.say(k="hb", token=self.look()["token"])
        if self.page_alive and self.held and self.now_ms % 50 == 0:
            self._hold()

    def look(self) -> dict[str, Any]:
        return self.control.snapshot(self.page)

    def say(self, **message: Any) -> None:
        for refusal in self.control.receive(self.page, message):
            self.refusals.append(refusal["reason"])

    def ready(self) -> None:
        """Run until the page has armed the board."""
        self.until(lambda: self.look()["arm_reason"] == "none", 3000)
        self.say(k="arm", token=self.look()["token"])
        self.until(lambda: self.look()["state"] == "armed", 1000)

    def hold_button(self, verb: str, edge: int, mode: str = "continuous") -> None:
        """The driver presses a button and holds it."""
        self.held = (verb, mode, edge)
        self._hold()

    def _hold(self) -> None:
        assert self.held is not None
        verb, mode, edge = self.held
        token = self.look()["token"]
        self.say(k="cmd", verb=verb, mode=mode, edge=edge, token=token)

    def let_go(self) -> None:
        """The driver leaves the button."""
        self.held = None
        self.say(k="stop")


@pytest.fixture
def chain() -> Chain:
    chain = Chain()
    chain.ready()
    return chain


@pytest.fixture
def driving(chain: Chain) -> Chain:
    chain.hold_button("forward", 1)
    chain.until(lambda: not chain.neutral(), 5)
    chain.run(500)
    assert not chain.neutral(), chain.why()
    return chain


def test_a_press_moves_the_wipers_within_3_ms_and_a_release_ends_it(chain: Chain) -> None:
    chain.run(200)
    chain.hold_button("forward", 1)
    assert chain.until(lambda: not chain.neutral(), 3) <= 3
    chain.run(2000)
    assert chain.wipers()[0] > 170
    seen = chain.look()
    assert (seen["motion"], seen["edge"], seen["simulated"]) == ("forward", 1, True)
    assert seen["output_permille"] == [permille(count, 170) for count in chain.wipers()]
    chain.let_go()
    assert chain.until(chain.neutral, 3) <= 3


@pytest.mark.parametrize("fitted", [1, 0])
def test_the_page_knows_before_arming_whether_the_relay_is_monitored(fitted: int) -> None:
    chain = Chain()
    chain.app.settings.relay_fitted = fitted
    chain.ready()
    assert chain.look()["relay_checked"] == bool(fitted)
    chain.run(1000)
    assert chain.look()["relay_checked"] == bool(fitted)


def test_nothing_moves_before_arming(chain: Chain) -> None:
    fresh = Chain()
    fresh.hold_button("forward", 1)
    for _ in range(2000):
        fresh.one_ms()
        assert fresh.neutral()
    assert set(fresh.refusals) <= {"not_armed"}


def test_a_hold_no_longer_proven_ends_within_300_ms(driving: Chain) -> None:
    driving.held = None  # no stop, only heartbeats
    assert driving.until(driving.neutral, 301) <= 301
    driving.run(30)
    assert driving.look()["override"] == "command_expired"
    driving.hold_button("forward", 1)
    driving.run(500)
    assert driving.neutral()
    driving.hold_button("forward", 2)
    driving.run(5)
    assert not driving.neutral()


def test_a_step_ends_by_itself_and_needs_a_new_press(chain: Chain) -> None:
    chain.hold_button("forward", 1, "step")
    chain.run(100)
    chain.held = None
    assert not chain.neutral()
    took_ms = chain.until(chain.neutral, 2500)
    assert 1700 < took_ms < 2100
    chain.run(500)
    assert chain.neutral()
    chain.hold_button("forward", 2, "step")
    chain.run(20)  # a step begins gently: the first count takes some ms
    assert not chain.neutral()


def test_a_step_of_a_page_fallen_silent_is_cut_short(chain: Chain) -> None:
    chain.hold_button("forward", 1, "step")
    chain.run(100)
    chain.page_alive = False
    assert chain.until(chain.neutral, 400) <= 400
    chain.run(30)
    assert chain.look()["message"] == "page_silent"


def test_an_obstacle_overrules_with_its_reason_and_ends_the_press(driving: Chain) -> None:
    driving.blocked = 1 << codes.DIR_FORWARD
    driving.until(driving.neutral, 105)
    driving.run(30)
    seen = driving.look()
    assert seen["override"] == "obstacle_forward"
    assert seen["decisions"]["forward"] == "blocked"
    assert (seen["level"], seen["message"]) == ("warning", "obstacle_forward")
    driving.blocked = 0
    driving.run(1000)
    assert driving.neutral()
    driving.hold_button("forward", 2)
    driving.run(5)
    assert not driving.neutral()


def test_a_lidar_gone_silent_blocks_by_its_age(driving: Chain) -> None:
    driving.scanning = False
    assert driving.until(driving.neutral, 301) <= 301
    driving.run(30)
    assert driving.look()["message"] == "obstacle_data_old"


def test_a_pulled_cable_stops_and_plugging_back_drives_only_when_armed_anew(
    driving: Chain,
) -> None:
    driving.cable.pull()
    assert driving.until(driving.neutral, 100) <= 100
    driving.run(1500)
    assert driving.look()["arm_reason"] == "not_connected"
    assert driving.app.safety.state == codes.DISARMED
    driving.cable.plug()
    driving.run(1000)
    assert driving.link.sessions == 2
    assert driving.neutral()
    driving.ready()
    driving.run(500)  # still holding the old press
    assert driving.neutral()
    driving.hold_button("forward", 2)
    driving.run(5)
    assert not driving.neutral()


def test_a_board_reset_while_driving_begins_a_new_session_disarmed(driving: Chain) -> None:
    driving.board.boot()
    for _ in range(2500):
        driving.one_ms()
        assert driving.neutral()
    assert driving.link.sessions == 2
    assert driving.look()["state"] == "disarmed"
    driving.ready()
    driving.hold_button("forward", 2)
    driving.run(5)
    assert not driving.neutral()


def test_a_closed_page_stops_and_disarms(driving: Chain) -> None:
    driving.page_alive = False
    driving.control.disconnect(driving.page)
    assert driving.until(driving.neutral, 3) <= 3
    assert driving.until(lambda: driving.app.safety.state == codes.DISARMED, 3) <= 3


def test_an_emergency_is_latched_and_the_driver_cannot_reset_it(driving: Chain) -> None:
    driving.say(k="emergency")
    assert driving.until(driving.neutral, 3) <= 3
    driving.run(500)
    driving.say(k="reset", token=driving.control.token())
    driving.run(500)
    seen = driving.look()
    assert (seen["arm_reason"], seen["message"]) == ("emergency", "emergency")
    assert "not_allowed" in driving.refusals
    caretaker = driving.control.connect("caretaker")
    assert (
        driving.control.receive(caretaker, {"k": "reset", "token": driving.control.token()}) == []
    )
    driving.let_go()
    driving.run(1000)
    assert driving.look()["arm_reason"] == "none"


def test_the_caretaker_takes_over_while_driving(driving: Chain) -> None:
    caretaker = driving.control.connect("caretaker")
    token = driving.control.snapshot(caretaker)["token"]
    assert driving.control.receive(caretaker, {"k": "take", "token": token}) == []
    assert driving.until(driving.neutral, 3) <= 3
    driving.run(200)  # the driver goes on holding
    assert driving.neutral()
    assert driving.look()["owner"] == "caretaker"
    assert "not_owner" in driving.refusals
