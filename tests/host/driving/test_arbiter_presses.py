"""What a press does, and how it ends. Virtual time."""

from __future__ import annotations

from typing import Any

import pytest

from gazechair.driving.messages import DISARM, EMERGENCY, STOP, Beat
from gazelink import codes

# Driving


def test_a_press_becomes_a_command_with_a_new_board_edge(armed: Any) -> None:
    assert armed.drive(4, verb=codes.LEFT, mode=codes.STEP) is None
    command = armed.arbiter.command
    assert (command.verb, command.mode, command.edge) == (codes.LEFT, codes.STEP, 11)
    assert command.owner == codes.DRIVER
    assert command.ttl_deadline_s == pytest.approx(armed.now_s + 0.3)


def test_the_way_through_the_network_is_part_of_the_time_to_live(armed: Any) -> None:
    assert armed.drive(4, age_ms=120) is None
    assert armed.arbiter.command.ttl_deadline_s == pytest.approx(armed.now_s + 0.18, abs=0.001)
    assert armed.drive(4, age_ms=40) is None
    fresher_s = armed.now_s + 0.26
    assert armed.arbiter.command.ttl_deadline_s == pytest.approx(fresher_s, abs=0.001)
    assert armed.drive(4, age_ms=200) is None  # an older proof, overtaken, takes nothing away
    assert armed.arbiter.command.ttl_deadline_s == pytest.approx(fresher_s, abs=0.001)


def test_holding_refreshes_the_time_to_live_under_the_same_edge(armed: Any) -> None:
    armed.drive(4)
    for _ in range(20):
        armed.wait(0.05)
        assert armed.drive(4) is None
        assert armed.arbiter.command.edge == 11
        assert armed.moving


def test_board_edges_skip_0_and_the_edge_the_board_already_has(armed: Any) -> None:
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


def test_the_page_is_told_its_own_edge(armed: Any) -> None:
    armed.drive(400)
    assert armed.arbiter.page_edge(armed.page) == 0
    armed.board(edge=armed.arbiter.command.edge)
    assert armed.arbiter.page_edge(armed.page) == 400
    assert armed.arbiter.page_edge(armed.page + 1) == 0


def test_disarmed_a_press_is_refused_once_and_stays_dead_after_arming(scene: Any) -> None:
    assert scene.drive(1) == "not_armed"
    assert scene.drive(1) is None
    assert scene.verb == codes.STOP
    scene.arm()
    scene.board(codes.ARMED)
    assert scene.drive(1) == "needs_new_command"
    assert not scene.moving
    assert scene.drive(2) is None
    assert scene.moving


def test_a_stale_token_moves_nothing(armed: Any) -> None:
    assert armed.drive(1, age_ms=251) == "stale_token"
    assert armed.verb == codes.STOP
    assert armed.drive(1, age_ms=-3) == "stale_token"  # ahead of the host's clock: made up
    assert armed.drive(1, age_ms=250) is None


def test_a_backlog_after_a_stall_does_not_drive_on(armed: Any) -> None:
    armed.drive(1)
    armed.wait(0.4, beating=False)
    for _ in range(20):
        armed.drive(1, age_ms=400)
    assert armed.verb == codes.STOP
    assert armed.drive(1) == "needs_new_command"


def test_a_lower_edge_is_an_old_press(armed: Any) -> None:
    armed.drive(5)
    assert armed.drive(4) == "needs_new_command"
    assert armed.arbiter.command.edge == 11


def test_one_press_cannot_change_its_mind(armed: Any) -> None:
    armed.drive(1, verb=codes.FORWARD)
    assert armed.drive(1, verb=codes.LEFT) == "needs_new_command"
    assert armed.verb == codes.STOP


# How a press ends


@pytest.mark.parametrize("message", [STOP, DISARM, EMERGENCY])
@pytest.mark.parametrize("own", [True, False])
def test_anyones_stop_wins_at_once(armed: Any, message: object, own: bool) -> None:
    other = armed.arbiter.connect("driver", armed.now_s)
    armed.drive(1)
    assert armed.say(message, armed.page if own else other) is None
    assert armed.verb == codes.STOP
    assert armed.drive(1) is not None
    assert not armed.moving


@pytest.mark.parametrize("last", ["own", "same", "gone"])
def test_a_press_made_before_somebodys_stop_never_drives(armed: Any, last: str) -> None:
    care = armed.arbiter.connect("caretaker", armed.now_s)
    armed.drive(1)
    armed.say(STOP, care)
    armed.now_s += 0.02
    if last == "gone":
        armed.arbiter.disconnect(care)
    armed.say(STOP, care if last == "same" else armed.page)
    assert armed.drive(2, age_ms=120) == "needs_new_command"
    assert not armed.moving
    armed.now_s += 0.2
    assert armed.drive(3, age_ms=120) is None
    assert armed.moving


@pytest.mark.parametrize("stop_s", [0.1, 0.32])
def test_so_does_one_that_began_with_a_message_too_late_and_is_still_held(
    armed: Any, stop_s: float
) -> None:
    """The stop comes before that message, or between it and the next."""
    care = armed.arbiter.connect("caretaker", armed.now_s)
    began_s = armed.now_s

    def at(moment_s: float) -> None:
        armed.now_s = began_s + moment_s

    if stop_s < 0.3:
        at(stop_s)
        armed.say(STOP, care)
    at(0.3)
    assert armed.drive(2, age_ms=300) == "stale_token"
    if stop_s > 0.3:
        at(stop_s)
        armed.say(STOP, care)
    at(0.5)
    assert armed.drive(2, age_ms=50) == "needs_new_command"
    assert not armed.moving
    assert armed.drive(3, age_ms=50) is None


def test_late_for_another_reason_it_drives_when_it_is_proven(armed: Any) -> None:
    care = armed.arbiter.connect("caretaker", armed.now_s)
    armed.say(STOP, care)
    armed.now_s += 0.5
    assert armed.drive(2, age_ms=300) == "stale_token"
    assert armed.drive(2, age_ms=100) is None
    assert armed.moving


def test_the_drivers_own_stop_does_not_count_against_a_press_sent_after_it(armed: Any) -> None:
    care = armed.arbiter.connect("caretaker", armed.now_s)
    armed.say(STOP, care)
    armed.now_s += 0.2
    armed.say(STOP)
    assert armed.drive(1, age_ms=120) is None
    assert armed.moving


def test_after_a_stop_a_new_press_drives(armed: Any) -> None:
    armed.drive(1)
    armed.say(STOP)
    assert armed.drive(1) == "needs_new_command"
    assert armed.drive(2) is None
    assert armed.moving


def test_a_press_not_refreshed_ends_and_cannot_be_revived(armed: Any) -> None:
    armed.drive(1)
    armed.wait(0.31)
    assert not armed.moving
    assert armed.drive(1) == "needs_new_command"
    assert armed.verb == codes.FORWARD  # the board explains that it expired


def test_a_step_goes_on_without_being_refreshed(armed: Any) -> None:
    armed.drive(1, mode=codes.STEP)
    armed.wait(1.5)
    assert (armed.verb, armed.arbiter.command.edge) == (codes.FORWARD, 11)
    assert armed.drive(1, mode=codes.STEP) == "needs_new_command"


@pytest.mark.parametrize("mode", [codes.STEP, codes.CONTINUOUS])
def test_a_silent_page_is_stopped_steps_too(armed: Any, mode: int) -> None:
    armed.drive(1, mode=mode)
    armed.wait(armed.arbiter.page_silent_s - 0.01, beating=False)
    assert armed.verb == codes.FORWARD
    armed.wait(0.02, beating=False)
    assert armed.verb == codes.STOP
    assert armed.arbiter.page_silent
    armed.beat()
    armed.arbiter.tick(armed.now_s)
    assert not armed.arbiter.page_silent
    assert armed.verb == codes.STOP


def test_heartbeats_with_old_tokens_prove_nothing(armed: Any) -> None:
    armed.drive(1, mode=codes.STEP)
    for _ in range(40):
        armed.wait(0.01, beating=False)
        armed.say(Beat(armed.token() - 300))
        armed.say(Beat(None))
    assert armed.verb == codes.STOP


def test_a_heartbeat_is_no_intent(armed: Any) -> None:
    armed.drive(1)
    armed.wait(0.4)
    assert not armed.moving


@pytest.mark.parametrize("session", [0, 8])
def test_a_lost_or_new_session_ends_the_press(armed: Any, session: int) -> None:
    armed.drive(1)
    armed.session = session
    armed.board()
    assert armed.verb == codes.STOP
    assert armed.drive(1) is not None
    assert not armed.moving
