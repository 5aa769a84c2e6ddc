"""P3, P4 and P13 end to end: what holds a command up, how long it may last, and who may give it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from e2e import states
from gazeboard.core import limits
from gazesim.lockstep_chair import Lockstep
from gazesim.lockstep_page import Page
from promises import END_TO_END, kept, measured

pytestmark = pytest.mark.costly

VERBS = ("forward", "left")


def note_proof(chair: Lockstep, cause: str) -> None:
    """From the page's last proof of holding until both wipers are neutral: page to wheels."""
    chair.until(chair.neutral, 600)
    ms = chair.now_ms - chair.page.proved_ms
    measured(END_TO_END, "P3", cause, ms, limits.COMMAND_TTL_MS)


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("phase_ms", [0, 17, 49])
def test_p3_a_stop_that_got_lost(verb: str, phase_ms: int) -> None:
    chair = states.driving(verb)
    chair.until(lambda: chair.page.proved_ms == chair.now_ms, 60)
    chair.run(phase_ms)
    chair.page.forget_button()  # the page lives and beats, but nobody holds a button
    note_proof(chair, "hold not refreshed, page and host alive")
    assert chair.override() == "command_expired"
    chair.needs_a_new_press(verb)


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("mode", ["continuous", "step"])
@pytest.mark.parametrize("phase_ms", [0, 1, 24, 99])
def test_p3_the_page_dies_and_its_socket_lives(verb: str, mode: str, phase_ms: int) -> None:
    chair = states.driving(verb, mode, 300, more_ms=phase_ms)
    received_ms = chair.now_ms
    chair.page.alive = False
    chair.until(chair.neutral, 600)
    ms = chair.now_ms - (chair.page.proved_ms if mode == "continuous" else received_ms)
    cause = "page dead, its socket open" + (" (a step)" if mode == "step" else "")
    # A step needs no holding: it ends by the page's silence, seen at the host's next look.
    measured(END_TO_END, "P3", cause, ms, limits.COMMAND_TTL_MS)
    chair.stays_still(500)
    chair.page.alive = True  # still holding, as it believes
    chair.needs_a_new_press(verb)


@pytest.mark.parametrize("delay_ms", [20, 60, 100, 110])
def test_p3_time_in_the_network_counts(delay_ms: int) -> None:
    chair = Lockstep()
    chair.page.delay_ms = delay_ms
    chair.drive(ms=1500)
    chair.page.alive = False
    note_proof(chair, "page dead behind a slow network")
    chair.comes_to_rest()


@pytest.mark.parametrize("stall_ms", [400, 1000, 3000])
def test_p3_a_backlog_after_a_stall_of_the_network_never_drives(stall_ms: int) -> None:
    chair = states.driving()
    chair.page.stalled = True
    note_proof(chair, "network stalled")
    chair.stays_still(stall_ms)
    chair.page.stalled = False  # the button has been held all the time
    chair.needs_a_new_press()
    chair.page.stalled = True
    chair.until(chair.neutral, 600)
    chair.stays_still(stall_ms)
    for verb in ("left", "forward", "right"):  # pressed and released while nothing gets through
        chair.page.press(verb)
        chair.stays_still(100)
        chair.page.forget_button()
    chair.page.stalled = False
    chair.stays_still(1000)
    assert chair.host is not None
    assert "stale_token" in chair.host.refusals


def test_p3_the_page_closes(driving: Lockstep) -> None:
    driving.page.close()
    neutral_ms = driving.until(driving.neutral, 10)
    measured(END_TO_END, "P3", "the page's socket closes", neutral_ms, 3)
    driving.until(lambda: not driving.armed(), 10)
    driving.stays_still(300)
    assert driving.host is not None
    driving.page.open(driving.host)
    driving.needs_a_new_press()


def test_a_stop_takes_effect_at_once(driving: Lockstep) -> None:
    driving.page.release()
    neutral_ms = driving.until(driving.neutral, 10)
    measured(END_TO_END, "P13", "stop, from the page's event", neutral_ms, 3)
    driving.comes_to_rest()
    assert driving.armed()


def test_p4_a_step_forward_ends_by_itself(chair: Lockstep) -> None:
    chair.arm()
    chair.page.press("forward", "step")
    chair.until(lambda: not chair.neutral(), 10)
    moved_ms = chair.until(chair.neutral, 3000)
    limit_ms = chair.board.app.settings.step_forward_ms + 1
    measured(END_TO_END, "P4", "a step forward", moved_ms, limit_ms)
    chair.needs_a_new_press()


def test_p4_a_turn_that_never_arrives(chair: Lockstep) -> None:
    numbers = chair.world.chair.parameters
    blocked = replace(numbers.turn, positive=0.0)  # the wheels: it does not turn at all
    chair.world.chair.parameters = replace(numbers, turn=blocked)
    chair.arm()
    chair.page.press("left", "step")
    chair.until(lambda: not chair.neutral(), 10)
    moved_ms = chair.until(lambda: chair.override() == "time_limit", 8000)
    assert chair.neutral()
    chair.world.chair.parameters = numbers
    limit_ms = chair.board.app.settings.step_turn_limit_ms + 1
    measured(END_TO_END, "P4", "a turn that never arrives", moved_ms, limit_ms)
    chair.needs_a_new_press()


def test_p13_anyones_stop_wins(driving: Lockstep) -> None:
    assert driving.host is not None
    other = Page(driving.host)
    other.say(k="stop")
    other.one_ms(driving.now_ms + 1)
    neutral_ms = driving.until(driving.neutral, 10)
    measured(END_TO_END, "P13", "another page's stop, from its arrival", neutral_ms, 3)
    driving.needs_a_new_press()


def test_p13_only_the_owner_moves(driving: Lockstep) -> None:
    driving.page.release()
    driving.until(driving.neutral, 3)
    driving.comes_to_rest()
    other = driving.another_page()
    other.press("forward")
    driving.stays_still(500)
    other.arm()
    driving.stays_still(500)
    assert driving.host.refusals.count("not_owner") >= 2
    driving.page.press("forward")
    driving.until(lambda: not driving.neutral(), 10)


def test_p13_the_caretaker_takes_over_and_it_stops_first(driving: Lockstep) -> None:
    caretaker = driving.another_page("caretaker")
    caretaker.take()
    neutral_ms = driving.until(driving.neutral, 10)
    measured(END_TO_END, "P13", "the caretaker takes over", neutral_ms, 4)
    driving.stays_still(1000)  # the driver goes on holding
    assert driving.armed()
    caretaker.press("forward")
    driving.until(lambda: not driving.neutral(), 10)
    kept(END_TO_END, "P13", "only the owner moves")


def test_p12_nonsense_on_the_pages_socket_moves_nothing(chair: Lockstep) -> None:
    chair.arm()
    assert chair.host is not None
    texts = [
        "",
        "null",
        "[]",
        "{",
        '{"k":"cmd"}',
        '{"k":"cmd","verb":"forward","mode":"continuous","edge":0,"token":1}',
        '{"k":"cmd","verb":"up","mode":"continuous","edge":9,"token":1}',
        '{"k":"cmd","verb":"forward","mode":"continuous","edge":1e9,"token":NaN}',
        "x" * 5000,
        "[" * 200,
    ]
    for k in range(500):
        chair.host.inbox.append((chair.page.client, texts[k % len(texts)]))
        chair.stays_still(2)
    assert chair.armed()
    chair.page.press("forward")
    chair.until(lambda: not chair.neutral(), 10)
    kept(END_TO_END, "P12", "nonsense on the page's socket")
