"""Who may move the chair, and when a press ends. Virtual time; then any order of anything."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from gazechair.arbiter import Arbiter, Refusal
from gazechair.page_messages import (
    DISARM,
    EMERGENCY,
    RESET,
    STOP,
    Arm,
    Beat,
    Drive,
)
from gazelink import codes

ARM_ORDER = (codes.ARM, codes.DRIVER)


class Scene:
    """An arbiter with a connected board and one driver's page, time told by the test."""

    def __init__(self) -> None:
        self.now_s = 50.0
        self.arbiter = Arbiter(last_edge=10)
        self.state = codes.DISARMED
        self.session = 7
        self.board()
        self.page = self.arbiter.connect("driver", self.now_s)

    def board(self, state: int | None = None, edge: int = 0) -> None:
        if state is not None:
            self.state = state
        self.arbiter.board(self.session, self.state, edge, self.now_s)

    def token(self) -> int:
        return self.arbiter.issue_token(self.now_s)

    def beat(self, page: int | None = None) -> None:
        self.arbiter.receive(page or self.page, Beat(self.token()), self.now_s)

    def arm(self, page: int | None = None) -> Refusal | None:
        return self.arbiter.receive(page or self.page, Arm(self.token()), self.now_s)

    def drive(
        self,
        edge: int,
        page: int | None = None,
        verb: int = codes.FORWARD,
        mode: int = codes.CONTINUOUS,
        age_ms: int = 0,
    ) -> str | None:
        wish = Drive(verb, mode, edge, self.token() - age_ms)
        refusal = self.arbiter.receive(page or self.page, wish, self.now_s)
        return None if refusal is None else refusal.reason

    def say(self, message: object, page: int | None = None) -> Refusal | None:
        return self.arbiter.receive(page or self.page, message, self.now_s)  # type: ignore[arg-type]

    def wait(self, seconds: float, beating: bool = True) -> None:
        end_s = self.now_s + seconds
        while self.now_s < end_s - 1e-9:
            self.now_s += 0.01
            if beating:
                self.beat()
            self.arbiter.tick(self.now_s)

    @property
    def verb(self) -> int:
        return self.arbiter.command.verb

    @property
    def moving(self) -> bool:
        """A motion with time to live left."""
        command = self.arbiter.command
        return command.verb != codes.STOP and command.ttl_deadline_s > self.now_s


@pytest.fixture
def scene() -> Scene:
    return Scene()


@pytest.fixture
def armed(scene: Scene) -> Scene:
    assert scene.arm() is None
    scene.arbiter.take_orders()
    scene.board(codes.ARMING)
    scene.board(codes.ARMED)
    scene.wait(1.1)
    return scene


# Arming and owning


def test_at_first_the_board_is_told_to_stop_and_nobody_drives(scene: Scene) -> None:
    assert scene.verb == codes.STOP
    assert scene.arbiter.owner_code == codes.NOBODY


def test_who_arms_owns_the_chair(scene: Scene) -> None:
    assert scene.arm() is None
    assert scene.arbiter.take_orders() == [ARM_ORDER]
    assert scene.arbiter.owner == scene.page
    assert scene.arbiter.take_orders() == []


def test_an_order_to_arm_that_the_board_does_not_follow_lapses(scene: Scene) -> None:
    scene.arm()
    scene.wait(1.1)
    assert scene.arbiter.owner is None


def test_arming_again_at_once_after_disarming_keeps_the_owner(armed: Scene) -> None:
    armed.say(DISARM)
    armed.arm()
    armed.board(codes.DISARMED)  # the board's answer to the first order
    assert armed.arbiter.owner == armed.page
    armed.board(codes.ARMED)
    assert armed.drive(1) is None


def test_without_a_board_arming_is_refused(scene: Scene) -> None:
    scene.session = 0
    scene.board()
    refusal = scene.arm()
    assert refusal is not None
    assert (refusal.what, refusal.reason) == ("arm", "not_connected")
    assert scene.arbiter.take_orders() == []


def test_a_second_driver_is_refused_while_the_first_drives(armed: Scene) -> None:
    other = armed.arbiter.connect("driver", armed.now_s)
    refusal = armed.arm(other)
    assert refusal is not None
    assert refusal.reason == "not_owner"
    assert armed.drive(1, other) == "not_owner"
    assert not armed.moving


def test_the_caretaker_takes_over_and_the_driver_stops(armed: Scene) -> None:
    armed.drive(1)
    caretaker = armed.arbiter.connect("caretaker", armed.now_s)
    assert armed.arm(caretaker) is None
    assert armed.verb == codes.STOP
    assert armed.arbiter.take_orders() == [(codes.ARM, codes.CARETAKER)]
    assert armed.arbiter.owner_code == codes.CARETAKER
    assert armed.drive(1) == "not_owner"
    assert armed.drive(1, caretaker) is None
    assert armed.arbiter.command.owner == codes.CARETAKER


def test_an_owner_who_leaves_stops_and_disarms(armed: Scene) -> None:
    armed.drive(1)
    armed.arbiter.disconnect(armed.page, armed.now_s)
    assert armed.verb == codes.STOP
    assert armed.arbiter.take_orders() == [(codes.DISARM, codes.DRIVER)]
    assert armed.arbiter.owner is None


def test_another_page_that_leaves_changes_nothing(armed: Scene) -> None:
    other = armed.arbiter.connect("driver", armed.now_s)
    armed.drive(1)
    armed.arbiter.disconnect(other, armed.now_s)
    armed.arbiter.disconnect(999, armed.now_s)
    assert armed.moving
    assert armed.arbiter.take_orders() == []


def test_a_board_that_disarms_has_no_owner_any_more(armed: Scene) -> None:
    armed.drive(1)
    armed.board(codes.DISARMED)
    assert armed.arbiter.owner is None
    assert not armed.moving
    assert armed.drive(1) == "not_armed"


# Driving


def test_a_press_becomes_a_command_with_a_new_board_edge(armed: Scene) -> None:
    assert armed.drive(4, verb=codes.LEFT, mode=codes.STEP) is None
    command = armed.arbiter.command
    assert (command.verb, command.mode, command.edge) == (codes.LEFT, codes.STEP, 11)
    assert command.owner == codes.DRIVER
    assert command.ttl_deadline_s == pytest.approx(armed.now_s + 0.3)


def test_holding_refreshes_the_time_to_live_under_the_same_edge(armed: Scene) -> None:
    armed.drive(4)
    for _ in range(20):
        armed.wait(0.05)
        assert armed.drive(4) is None
        assert armed.arbiter.command.edge == 11
        assert armed.moving


def test_board_edges_skip_0_and_the_edge_the_board_already_has(armed: Scene) -> None:
    seen = []
    for edge in range(1, 600):
        armed.drive(edge)
        seen.append(armed.arbiter.command.edge)
        armed.board(edge=seen[-1])
    assert 0 not in seen
    assert set(seen) == set(range(1, 256))
    armed.board(edge=seen[-1] % 255 + 1)  # from another host's life
    armed.drive(1000)
    assert armed.arbiter.command.edge != seen[-1] % 255 + 1


def test_the_page_is_told_its_own_edge(armed: Scene) -> None:
    armed.drive(400)
    assert armed.arbiter.page_edge(armed.page) == 0
    armed.board(edge=armed.arbiter.command.edge)
    assert armed.arbiter.page_edge(armed.page) == 400
    assert armed.arbiter.page_edge(armed.page + 1) == 0


def test_disarmed_a_press_is_refused_once_and_stays_dead_after_arming(scene: Scene) -> None:
    assert scene.drive(1) == "not_armed"
    assert scene.drive(1) is None
    assert scene.verb == codes.STOP
    scene.arm()
    scene.board(codes.ARMED)
    assert scene.drive(1) == "needs_new_command"
    assert not scene.moving
    assert scene.drive(2) is None
    assert scene.moving


def test_a_stale_token_moves_nothing(armed: Scene) -> None:
    assert armed.drive(1, age_ms=251) == "stale_token"
    assert armed.verb == codes.STOP
    assert armed.drive(1, age_ms=-1) == "stale_token"
    assert armed.drive(1, age_ms=250) is None


def test_a_backlog_after_a_stall_does_not_drive_on(armed: Scene) -> None:
    armed.drive(1)
    armed.wait(0.4, beating=False)
    for _ in range(20):
        armed.drive(1, age_ms=400)
    assert armed.verb == codes.STOP
    assert armed.drive(1) == "needs_new_command"


def test_a_lower_edge_is_an_old_press(armed: Scene) -> None:
    armed.drive(5)
    assert armed.drive(4) == "needs_new_command"
    assert armed.arbiter.command.edge == 11


def test_one_press_cannot_change_its_mind(armed: Scene) -> None:
    armed.drive(1, verb=codes.FORWARD)
    assert armed.drive(1, verb=codes.LEFT) == "needs_new_command"
    assert armed.verb == codes.STOP


# How a press ends


@pytest.mark.parametrize("message", [STOP, DISARM, EMERGENCY])
@pytest.mark.parametrize("own", [True, False])
def test_anyones_stop_wins_at_once(armed: Scene, message: object, own: bool) -> None:
    other = armed.arbiter.connect("driver", armed.now_s)
    armed.drive(1)
    assert armed.say(message, armed.page if own else other) is None
    assert armed.verb == codes.STOP
    assert armed.drive(1) is not None
    assert not armed.moving


def test_after_a_stop_a_new_press_drives(armed: Scene) -> None:
    armed.drive(1)
    armed.say(STOP)
    assert armed.drive(1) == "needs_new_command"
    assert armed.drive(2) is None
    assert armed.moving


def test_a_press_not_refreshed_ends_and_cannot_be_revived(armed: Scene) -> None:
    armed.drive(1)
    armed.wait(0.31)
    assert not armed.moving
    assert armed.drive(1) == "needs_new_command"
    assert armed.verb == codes.FORWARD  # the board explains that it expired


def test_a_step_goes_on_without_being_refreshed(armed: Scene) -> None:
    armed.drive(1, mode=codes.STEP)
    armed.wait(1.5)
    assert (armed.verb, armed.arbiter.command.edge) == (codes.FORWARD, 11)
    assert armed.drive(1, mode=codes.STEP) == "needs_new_command"


@pytest.mark.parametrize("mode", [codes.STEP, codes.CONTINUOUS])
def test_a_silent_page_is_stopped_steps_too(armed: Scene, mode: int) -> None:
    armed.drive(1, mode=mode)
    armed.wait(0.29, beating=False)
    assert armed.verb == codes.FORWARD
    armed.wait(0.03, beating=False)
    assert armed.verb == codes.STOP
    assert armed.arbiter.page_silent
    armed.beat()
    armed.arbiter.tick(armed.now_s)
    assert not armed.arbiter.page_silent
    assert armed.verb == codes.STOP


def test_heartbeats_with_old_tokens_prove_nothing(armed: Scene) -> None:
    armed.drive(1, mode=codes.STEP)
    for _ in range(40):
        armed.wait(0.01, beating=False)
        armed.say(Beat(armed.token() - 300))
        armed.say(Beat(None))
    assert armed.verb == codes.STOP


def test_a_heartbeat_is_no_intent(armed: Scene) -> None:
    armed.drive(1)
    armed.wait(0.4)
    assert not armed.moving


@pytest.mark.parametrize("session", [0, 8])
def test_a_lost_or_new_session_ends_the_press(armed: Scene, session: int) -> None:
    armed.drive(1)
    armed.session = session
    armed.board()
    assert armed.verb == codes.STOP
    assert armed.drive(1) is not None
    assert not armed.moving


# Orders


def test_emergency_and_disarm_are_ordered_for_anyone(scene: Scene) -> None:
    scene.say(EMERGENCY)
    scene.say(DISARM)
    assert scene.arbiter.take_orders() == [
        (codes.EMERGENCY_STOP, codes.DRIVER),
        (codes.DISARM, codes.DRIVER),
    ]


def test_only_the_caretaker_resets_faults(scene: Scene) -> None:
    refusal = scene.say(RESET)
    assert refusal is not None
    assert "3 s" in refusal.detail
    assert scene.arbiter.take_orders() == []
    caretaker = scene.arbiter.connect("caretaker", scene.now_s)
    assert scene.say(RESET, caretaker) is None
    assert scene.arbiter.take_orders() == [(codes.RESET_FAULTS, codes.CARETAKER)]


def test_a_page_that_is_gone_commands_nothing(armed: Scene) -> None:
    armed.arbiter.disconnect(armed.page, armed.now_s)
    armed.arbiter.take_orders()
    for message in (STOP, EMERGENCY, DISARM, Arm(armed.token())):
        assert armed.say(message) is not None
    assert armed.drive(1) == "not_owner"
    assert armed.arbiter.take_orders() == []


# Any order of anything


class AnyOrder(RuleBasedStateMachine):
    """Keeps its own, simpler account of which presses may move the chair."""

    @initialize()
    def begin(self) -> None:
        self.scene = Scene()
        self.pages = [
            self.scene.page,
            self.scene.arbiter.connect("driver", 50.0),
            self.scene.arbiter.connect("caretaker", 50.0),
        ]
        self.gone: set[int] = set()
        self.seen: set[tuple[int, int]] = set()  # presses (page, edge) made so far
        self.dead: set[tuple[int, int]] = set()  # those that may never move again
        self.proof: dict[tuple[int, int], float] = {}  # newest fresh proof of holding
        self.edge = 0

    def kill_all(self) -> None:
        self.dead |= self.seen

    @rule(ms=st.integers(1, 500))
    def time_passes(self, ms: int) -> None:
        self.scene.now_s += ms / 1000
        self.scene.arbiter.tick(self.scene.now_s)

    @rule(who=st.integers(0, 2))
    def beats(self, who: int) -> None:
        self.scene.beat(self.pages[who])

    @rule(who=st.integers(0, 2), new=st.booleans(), mode=st.sampled_from([0, 1]))
    def drives(self, who: int, new: bool, mode: int) -> None:
        self.edge += new
        if self.edge == 0:
            return
        page = self.pages[who]
        press = (page, self.edge)
        self.seen.add(press)
        owner = self.scene.arbiter.owner
        self.scene.drive(self.edge, page, mode=mode)
        may = owner == page and self.scene.state == codes.ARMED and page not in self.gone
        if may and self.scene.session and press not in self.dead:
            self.proof[press] = self.scene.now_s
        else:
            self.dead.add(press)

    @rule(who=st.integers(0, 2), age_ms=st.integers(251, 9999))
    def drives_late(self, who: int, age_ms: int) -> None:
        self.edge += 1
        before = self.scene.arbiter.command
        self.scene.drive(self.edge, self.pages[who], age_ms=age_ms)
        after = self.scene.arbiter.command
        assert after.same_as(before) or after.verb == codes.STOP

    @rule(who=st.integers(0, 2), what=st.sampled_from([STOP, DISARM, EMERGENCY]))
    def stops(self, who: int, what: object) -> None:
        if self.pages[who] in self.gone:
            return
        self.scene.say(what, self.pages[who])
        assert self.scene.verb == codes.STOP
        self.kill_all()

    @rule(who=st.integers(0, 2))
    def arms(self, who: int) -> None:
        page = self.pages[who]
        if self.scene.arm(page) is None:
            assert self.scene.verb == codes.STOP
            self.kill_all()

    @rule(state=st.sampled_from([codes.DISARMED, codes.ARMING, codes.ARMED]))
    def board_changes(self, state: int) -> None:
        self.scene.board(state)
        if state != codes.ARMED:
            assert not self.scene.moving or self.scene.arbiter.owner is not None

    @rule(session=st.sampled_from([0, 7, 8]))
    def session_changes(self, session: int) -> None:
        changed = session != self.scene.session
        self.scene.session = session
        self.scene.board()
        if changed:
            self.kill_all()
            assert self.scene.verb == codes.STOP

    @rule(who=st.integers(0, 2))
    def leaves(self, who: int) -> None:
        page = self.pages[who]
        owned = self.scene.arbiter.owner == page
        self.scene.arbiter.disconnect(page, self.scene.now_s)
        self.gone.add(page)
        if owned:
            assert self.scene.verb == codes.STOP
            self.kill_all()

    @invariant()
    def only_a_live_proven_press_has_time_to_live(self) -> None:
        if not hasattr(self, "scene") or not self.scene.moving:
            return
        alive = [
            press
            for press, proven_s in self.proof.items()
            if press not in self.dead and self.scene.now_s - proven_s < 0.3
        ]
        assert alive
        assert self.scene.arbiter.command.owner != codes.NOBODY

    @invariant()
    def a_silent_owner_is_stopped(self) -> None:
        if hasattr(self, "scene") and self.scene.arbiter.page_silent:
            assert self.scene.verb == codes.STOP


AnyOrder.TestCase.settings = settings(
    max_examples=60,
    stateful_step_count=40,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],  # machines stall
)
test_any_order_of_anything = AnyOrder.TestCase
