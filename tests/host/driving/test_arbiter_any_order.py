"""Anything in any order: only a live press, freshly proven by the owner, ever moves the chair."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    invariant,
    rule,
    run_state_machine_as_test,
)

from gazechair.driving.messages import DISARM, EMERGENCY, STOP
from gazelink import codes


class AnyOrder(RuleBasedStateMachine):
    """Keeps its own, simpler record of which presses may move the chair."""

    def __init__(self, scene: Any) -> None:
        super().__init__()
        self.scene = scene
        self.pages = [
            self.scene.page,
            self.scene.arbiter.connect("driver", 50.0),
            self.scene.arbiter.connect("caretaker", 50.0),
            self.scene.arbiter.connect("viewer", 50.0),
        ]
        self.gone: set[int] = set()
        self.seen: set[tuple[int, int]] = set()  # presses (page, edge) made so far
        self.dead: set[tuple[int, int]] = set()  # those that may never move again
        self.proof: dict[tuple[int, int], float] = {}  # newest fresh proof of holding
        self.stopped_s: dict[int, float] = {}  # newest stop of each page
        self.edge = 0

    def kill_all(self) -> None:
        self.dead |= self.seen

    @rule(ms=st.integers(1, 500))
    def time_passes(self, ms: int) -> None:
        self.scene.now_s += ms / 1000
        self.scene.arbiter.tick(self.scene.now_s)

    @rule(who=st.integers(0, 3))
    def beats(self, who: int) -> None:
        self.scene.beat(self.pages[who])

    @rule(
        who=st.integers(0, 3),
        new=st.booleans(),
        mode=st.sampled_from([0, 1]),
        age_ms=st.one_of(st.just(0), st.integers(0, 600)),
    )
    def drives(self, who: int, new: bool, mode: int, age_ms: int = 0) -> None:
        self.edge += new
        if self.edge == 0:
            return
        page = self.pages[who]
        press = (page, self.edge)
        proven_s = self.scene.now_s - age_ms / 1000
        others_s = [stop_s for other, stop_s in self.stopped_s.items() if other != page]
        if press not in self.seen and max(others_s, default=0.0) > proven_s + 1e-6:
            self.dead.add(press)  # pressed before somebody's stop
        self.seen.add(press)
        if age_ms > 250 and press not in self.dead:
            before = self.scene.arbiter.command
            self.scene.drive(self.edge, page, mode=mode, age_ms=age_ms)
            assert self.scene.arbiter.command.same_as(before)
            return
        owner = self.scene.arbiter.owner
        self.scene.drive(self.edge, page, mode=mode, age_ms=age_ms)
        may = owner == page and self.scene.state == codes.ARMED and page not in self.gone
        if may and self.scene.session and press not in self.dead:
            self.proof[press] = max(self.proof.get(press, 0.0), proven_s)
        else:
            self.dead.add(press)

    @rule(who=st.integers(0, 3), age_ms=st.integers(251, 9999))
    def drives_late(self, who: int, age_ms: int) -> None:
        self.edge += 1
        before = self.scene.arbiter.command
        self.scene.drive(self.edge, self.pages[who], age_ms=age_ms)
        after = self.scene.arbiter.command
        assert after.same_as(before) or after.verb == codes.STOP

    @rule(who=st.integers(0, 3), what=st.sampled_from([STOP, DISARM, EMERGENCY]))
    def stops(self, who: int, what: object) -> None:
        if self.pages[who] in self.gone:
            return
        if self.scene.say(what, self.pages[who]) is not None:
            assert who == 3  # a viewer
            return
        assert self.scene.verb == codes.STOP
        self.stopped_s[self.pages[who]] = self.scene.now_s
        self.kill_all()

    @rule(who=st.integers(0, 3))
    def arms(self, who: int) -> None:
        page = self.pages[who]
        if self.scene.arm(page) is None:
            assert self.scene.verb == codes.STOP
            self.kill_all()

    @rule(who=st.integers(0, 3))
    def takes(self, who: int) -> None:
        if self.scene.take(self.pages[who]) is None:
            assert who == 2
            assert self.scene.verb == codes.STOP
            self.kill_all()

    @rule(state=st.sampled_from([codes.DISARMED, codes.ARMING, codes.ARMED]))
    def board_changes(self, state: int) -> None:
        self.scene.board(state)
        if state != codes.ARMED:
            assert not self.scene.moving
            self.kill_all()

    @rule(session=st.sampled_from([0, 7, 8]))
    def session_changes(self, session: int) -> None:
        changed = session != self.scene.session
        self.scene.session = session
        self.scene.board()
        if changed:
            self.kill_all()
            assert self.scene.verb == codes.STOP

    @rule(who=st.integers(0, 3))
    def leaves(self, who: int) -> None:
        page = self.pages[who]
        owned = self.scene.arbiter.owner == page
        self.scene.arbiter.disconnect(page)
        self.gone.add(page)
        if owned:
            assert self.scene.verb == codes.STOP
            self.kill_all()

    @invariant()
    def only_a_live_proven_press_has_time_to_live(self) -> None:
        if not self.scene.moving:
            return
        alive = [
            press
            for press, proven_s in self.proof.items()
            if press not in self.dead and self.scene.now_s - proven_s < 0.3
        ]
        assert alive
        assert self.scene.arbiter.command.owner != codes.NOBODY

    @invariant()
    def a_viewer_never_owns_the_chair(self) -> None:
        assert self.scene.arbiter.owner != self.pages[3]

    @invariant()
    def a_silent_owner_is_stopped(self) -> None:
        if self.scene.arbiter.page_silent:
            assert self.scene.verb == codes.STOP


def test_any_order_of_anything(new_scene: Callable[[], Any]) -> None:
    run_state_machine_as_test(
        lambda: AnyOrder(new_scene()),
        settings=settings(
            max_examples=60,
            stateful_step_count=40,
            deadline=None,
            suppress_health_check=[HealthCheck.too_slow],  # machines stall
        ),
    )


@pytest.mark.parametrize("state", [codes.DISARMED, codes.ARMING])
def test_a_board_not_armed_any_more_ends_the_press_however_soon_after_arming(
    new_scene: Callable[[], Any], state: int
) -> None:
    machine = AnyOrder(new_scene())
    machine.arms(0)
    machine.board_changes(codes.ARMED)
    machine.drives(0, new=True, mode=codes.CONTINUOUS)
    assert machine.scene.moving
    machine.board_changes(state)
    machine.drives(0, new=False, mode=codes.CONTINUOUS)
    machine.only_a_live_proven_press_has_time_to_live()
    machine.board_changes(codes.ARMED)
    machine.drives(0, new=False, mode=codes.CONTINUOUS)
    assert not machine.scene.moving  # armed again, it waits for a new press
    machine.drives(0, new=True, mode=codes.CONTINUOUS)
    assert machine.scene.moving
