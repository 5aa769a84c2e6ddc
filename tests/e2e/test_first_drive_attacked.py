"""Attacks on the first drive: only the step's own button moves anything, letting go ends it."""

from __future__ import annotations

from typing import Any, cast
from unittest import mock

import pytest

from firstdriverig import FirstDriveRig
from gazelink import codes
from gazesim.lockstep_page import Page

pytestmark = pytest.mark.costly


@pytest.fixture
def rig() -> FirstDriveRig:
    made = FirstDriveRig()
    made.ready()
    return made


def begun(rig: FirstDriveRig, step: str) -> None:
    rig.press(step)
    rig.until(lambda: rig.guide.due is not None, 200)


def test_a_button_still_held_begins_no_other_step(rig: FirstDriveRig) -> None:
    begun(rig, "relay")

    assert rig._finish() == ""
    rig.run(400)
    assert rig.post(run="turn") == "first_hold"
    rig._holding = "turn"  # the same press, of another step now
    rig.run(50)
    assert rig.guide.due is None
    assert rig.neutral()


def test_another_caretaker_is_told_once_that_somebody_holds_a_button(rig: FirstDriveRig) -> None:
    begun(rig, "tune")
    other = Page(cast(Any, rig), "caretaker")
    edge = 1

    def holds() -> None:
        other.one_ms(rig.now_ms)
        if rig.now_ms % 25 == 0:
            other._send_fresh(k="step", step="relay", held=True, edge=edge)

    rig.watch = holds
    rig.run(200)
    assert rig.refusals == ["first_busy"]
    rig.let_go()
    assert rig._finish() == "first_let_go"
    rig.run(500)
    assert rig.guide.due is None
    assert rig.refusals == ["first_busy"]
    edge += 1
    rig.run(50)
    assert rig.guide.due is not None


# In virtual time a wait of the step's thread is where the world moves on.
@pytest.mark.parametrize("step", ["tune", "turn"])
@pytest.mark.parametrize("how", ["silent", "input_stops"])
def test_it_ends_though_the_steps_own_thread_stands_still(
    rig: FirstDriveRig, step: str, how: str
) -> None:
    waits = rig.guide._wait
    stood = False
    ended: list[bool] = []

    def stands(seconds: float) -> None:
        nonlocal stood
        if rig.neutral() or stood:
            waits(seconds)
            return
        stood = True
        if how == "silent":
            rig.forget()
        else:
            client = rig.steering.join("driver")
            rig.steering.receive(client, {"k": "stop"})
        rig.run(320 if how == "silent" else 40)
        ended.append(rig.neutral())  # an assertion here would be the step's own failure
        rig.run(1000)
        ended.append(rig.neutral())

    rig.guide._wait = stands
    begun(rig, step)
    assert rig._finish() != ""
    assert ended == [True, True]


def test_pressed_again_within_the_slice_is_no_way_on(rig: FirstDriveRig) -> None:
    begun(rig, "turn")
    again_ms = 0

    def again() -> None:
        nonlocal again_ms
        if again_ms == 0 and not rig.neutral():
            again_ms = rig.now_ms
            rig.let_go()
            rig.press("turn")

    rig.watch = again
    assert rig._finish() == "first_let_go"
    assert 0 < rig.now_ms - again_ms < 300


def test_no_step_begins_where_somebody_is_just_switching_driving_on(rig: FirstDriveRig) -> None:
    rig.caretaker.arm()
    rig.caretaker._send_fresh(k="step", step="turn", held=True, edge=1)
    rig.run(2)
    assert rig.refusals == ["setting_while_armed"]
    assert rig.guide.due is None


def test_a_refused_press_stops_nobody_who_drives(rig: FirstDriveRig) -> None:
    rig.driver.arm()
    rig.until(lambda: rig.driver.shown["state"] == "armed", 1500)
    rig.driver.press("forward")
    rig.until(lambda: not rig.stands(), 2000)
    rig.caretaker._send_fresh(k="step", step="turn", held=True, edge=1)
    rig.run(200)
    assert rig.refusals == ["setting_while_armed"]
    assert not rig.neutral()


def test_the_lidars_are_not_started_anew_under_a_driver(rig: FirstDriveRig) -> None:
    rig.watch = lambda: rig.driver.arm() if rig.now_ms % 500 == 0 else None
    assert rig.post(run="mask") == "setting_while_armed"  # armed while the lidar was watched
    assert rig.post(run="mask") == "setting_while_armed"
    assert rig.masks == []


def test_an_answer_counts_for_its_own_question(rig: FirstDriveRig) -> None:
    questions = set()

    def taps_twice() -> None:
        asks = rig.guide.status()["run"]["asks"]
        rig.guide.ask({"answer": "unplugged", "asks": "unplugged"})
        if asks == "linear":
            rig.guide.ask({"answer": "ok", "asks": "linear"})
        if asks == "turn":
            rig.guide.ask({"give_up": True})
        questions.add(asks)

    rig.watch = taps_twice
    assert rig.post(run="neutral") == "first_failed"
    assert questions == {"", "unplugged", "linear", "turn"}
    assert rig.guide.ask({"answer": "ok"}) is not None


def test_a_profile_that_is_not_stored_is_not_in_force(
    rig: FirstDriveRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(name: str, text: str) -> None:
        raise OSError

    before = rig.app.settings.profile
    monkeypatch.setattr(rig.board.files, "store", full)
    assert rig.post(run="profile", value=(before + 1) % 3) == "setting_not_stored"
    assert rig.app.settings.profile == before
    assert "profile" not in [s for s, row in rig.rows().items() if row["done"]]


@pytest.mark.parametrize("after_ms", [0, 300, 1500])
def test_a_board_that_resets_in_a_step_ends_it(rig: FirstDriveRig, after_ms: int) -> None:
    begun(rig, "tune")
    reset_ms = 0

    def resets() -> None:
        nonlocal reset_ms
        if reset_ms == 0 and rig.armed() and rig.now_ms > 1500 + after_ms:
            reset_ms = rig.now_ms
            rig.board.reset()

    rig.watch = resets
    assert rig._finish() == "first_failed"
    assert rig.guide.status()["run"]["ended"]["error"].startswith("board_")
    rig.run(3000)  # the button stays pressed
    assert reset_ms > 0
    assert not rig.armed()
    assert rig.neutral()
    assert rig.guide.due is None


def test_another_cap_does_not_cut_a_turn_short(rig: FirstDriveRig) -> None:
    begun(rig, "turn")
    done = False

    def caps() -> None:
        nonlocal done
        if not done and not rig.neutral():
            done = True
            rig.caretaker.say(k="cap", permille=300)

    rig.watch = caps
    assert rig._finish() == ""
    assert "not_owner" in rig.refusals
    left, right = rig.rows()["turn"]["turned_deg"]
    assert abs(left - 10.0) < 4.0
    assert abs(right + 10.0) < 4.0


def test_a_caretakers_speed_cap_holds_and_tuning_does_not_begin_below_full_speed(
    rig: FirstDriveRig,
) -> None:
    rig.caretaker.say(k="cap", permille=400)
    rig.run(100)
    assert rig.hold("tune") == "first_cap"

    most = 0

    def look() -> None:
        nonlocal most
        state = rig.link.state()
        if state is not None:
            most = max(most, abs(state.turn_permille))

    rig.watch = look
    rig.hold("turn")
    assert 0 < most <= 400


def test_nobody_arms_while_a_profile_is_stored(rig: FirstDriveRig) -> None:
    """Armed, the board would refuse to save it, and to set it back."""
    stored_in, tried = rig.link.setting, False

    def setting(request: int, index: int = 0, value: int = 0, timeout_s: float = 1.0) -> object:
        nonlocal tried
        if request == codes.SETTING_SAVE:
            tried = True
            rig.driver.arm()
            rig.run(100)
        return stored_in(request, index, value, timeout_s)

    rig.link.setting = setting  # type: ignore[method-assign,assignment]
    assert rig.post(run="profile", value=4) == ""
    assert tried
    assert rig.refusals == ["board_busy"]
    assert not rig.armed()
    rig.driver.arm()
    rig.until(rig.armed, 1000)
    assert rig.post(run="profile", value=1) == "setting_while_armed"


def test_who_arms_before_the_neutral_is_set_is_the_reason_that_is_told(rig: FirstDriveRig) -> None:
    def drives() -> None:
        asks = rig.guide.status()["run"]["asks"]
        if asks == "unplugged" and not rig.armed():
            if rig.now_ms % 500 == 0:
                rig.driver.arm()
        elif asks in ("unplugged", "linear") and not rig.guide._answers:
            rig.guide.ask({"answer": "+" if asks == "linear" else asks, "asks": asks})

    rig.watch = drives
    assert rig.post(run="neutral") == "setting_while_armed"


@pytest.mark.parametrize("kind", ["arm", "take", "cap"])
def test_what_comes_in_the_moment_a_step_begins_is_refused(rig: FirstDriveRig, kind: str) -> None:
    arm = rig.guide.storing.arm

    def begins() -> Any:
        rig.guide._step = "turn"
        return arm()

    with mock.patch.object(rig.guide.storing, "arm", begins):
        rig.caretaker.say(k=kind, permille=300)
        rig.run(20)
    assert rig.refusals == ["not_owner"]


def test_the_cap_of_a_step_is_that_of_its_beginning(rig: FirstDriveRig) -> None:
    cap = {"k": "cap", "permille": 300, "token": rig.control.token()}
    arm = rig.guide.storing.arm

    def capped() -> Any:
        with mock.patch.object(rig.guide.storing, "arm", arm):
            rig.control.receive(rig.caretaker.client, cap)
        return arm()

    with mock.patch.object(rig.guide.storing, "arm", capped):
        begun(rig, "turn")
    assert rig.guide.held.cap_permille == 300
