"""The first drive by the page's messages alone: a fresh board becomes a driving chair."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from firstdriverig import AHEAD_MM, EYE, FirstDriveRig, marks
from gazechair.commissioning.tune import tuning
from gazechair.commissioning.tune.forward import ForwardNumbers
from gazechair.commissioning.tune.forward_runner import PRESSES
from gazechair.commissioning.tune.forward_store import ForwardStore
from gazechair.commissioning.tune.identify import Fit
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.procedure import PULSES
from gazechair.commissioning.tune.recording import Recording
from gazechair.first_drive.facts import STEPS
from gazechair.picture.floor_store import FloorStore
from gazelink import codes
from gazelink.settings_table import PROFILES, TABLE, index_of
from gazemeasure.turn.tuning import truth
from gazesim.floor_view import Eye, Floor, FloorView
from gazesim.profiles import undisturbed

pytestmark = pytest.mark.costly


def done(rig: FirstDriveRig) -> list[str]:
    return [step for step, row in rig.rows().items() if row["done"]]


def calibrate_neutral(rig: FirstDriveRig) -> str:
    """With a meter that shows the right voltage two counts higher on the turn channel."""
    typed = {"unplugged": ["unplugged"], "linear": ["ok"], "turn": ["+", "+", "ok"]}
    typed["save"] = ["save"]

    def types() -> None:
        asks = rig.guide.status()["run"]["asks"]
        if typed.get(asks) and not rig.guide._answers:
            rig.guide.ask({"answer": typed[asks].pop(0), "asks": asks})

    rig.watch = types
    try:
        return rig.post(run="neutral")
    finally:
        rig.watch = lambda: None


def found(recordings: Sequence[Recording], believed: TurnNumbers) -> Fit:
    """In place of ten seconds of computing, which test_tune_chair tests: the chair as it is."""
    assert len(recordings) == len(PULSES)
    certain = TurnNumbers(*[0.01] * 8)
    return Fit(truth(undisturbed("3.1")), 0.05, 0.01, certain)


def test_the_turns_are_tuned_where_nothing_measures_straight_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tuning, "identify", found)
    rig = FirstDriveRig(tmp_path)
    rig.ready()
    rig.knows_place = False
    assert rig.post(run="profile", value=2) == ""
    rig.ready()
    assert rig.hold("tune") == "", rig.guide.status()["run"]
    assert rig.kept == []
    assert rig.caretaker.shown["tuned"] is True
    assert not rig.armed()


def test_a_fresh_board_is_led_to_a_driving_chair(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tuning, "identify", found)
    rig = FirstDriveRig(tmp_path)
    rig.ready()
    assert list(rig.rows()) == list(STEPS)
    assert done(rig) == ["versions"]
    assert rig.caretaker.shown["tuned"] is False

    assert rig.post(run="mask") == ""
    assert rig.masks[-1][0].mask == ((123.0, -123.0),)
    assert rig.post(run="distance", value=AHEAD_MM - 200) == "first_apart"
    assert rig.post(run="distance", value=AHEAD_MM + 20) == ""
    assert calibrate_neutral(rig) == ""
    assert rig.rows()["neutral"]["counts"] == [170, 172]
    assert rig.post(run="heading") == "sensor_not_calibrated"
    rig.run(15_000)  # the simulated sensor needs so long
    assert rig.post(run="heading") == ""
    assert rig.post(run="profile", value=2) == ""

    # What moves the chair needs the held button.
    for step in ("relay", "tune", "turn"):
        assert rig.post(run=step) == "first_hold"
    rig.run(1000)
    rig.ready()
    assert rig.hold("relay") == "", rig.guide.status()["run"]
    assert not rig.armed()
    drove: list[bool] = []

    def looks() -> None:
        if rig.guide.moving:
            drove.append(rig.armed())
            assert rig.guide.holds_settings

    rig.watch = looks
    assert rig.hold("tune") == "", rig.guide.status()["run"]
    rig.watch = lambda: None
    # Between its two parts, too, it holds the settings.
    assert [drove[at : at + 2] for at in range(len(drove))].count([False, True]) == 2
    assert not rig.guide.holds_settings
    run = rig.guide.status()["run"]
    assert run["pulses"] >= len(PULSES)
    assert run["straight"] == len(PRESSES)
    assert not rig.armed()
    assert rig.caretaker.shown["tuned"] is True
    # Straight on, too: what is found is this chair's speed, which is no textbook's.
    ((profile, straight),) = rig.kept
    true = rig.world.chair.parameters.linear
    share = (0.6 - true.deadband) / (1.0 - true.deadband)
    assert profile == PROFILES[2]
    assert straight.speed_m_s(0.6) == pytest.approx(true.positive * share, rel=0.1)
    assert rig.hold("turn") == "", rig.guide.status()["run"]
    left, right = rig.rows()["turn"]["turned_deg"]
    assert left == pytest.approx(10.0, abs=2.0)
    assert right == pytest.approx(-10.0, abs=2.0)
    assert "person" not in done(rig)
    assert rig.post(run="camera", value=marks()) == ""
    rig.control.change_profile({"choose": "1"}, "caretaker")

    rig.driver.arm()
    rig.until(lambda: rig.driver.shown["state"] == "armed", 1000)
    rig.driver.press("forward")
    rig.until(lambda: not rig.stands(), 2000)
    rig.run(1200)
    assert done(rig) == list(STEPS)
    rig.driver.release()

    again = FirstDriveRig(tmp_path)
    again.board.files.texts.update(rig.board.files.texts)
    assert {"mask", "distance", "camera", "person"} <= set(done(again))


def test_a_step_forward_goes_as_far_in_another_profile(tmp_path: Path) -> None:
    numbers = ForwardNumbers(0.36, 0.08, 0.15, 0.3, 0.6, 1.0)
    store = ForwardStore(tmp_path)
    store.keep(PROFILES[2], numbers)
    store.keep(PROFILES[3], replace(numbers, full_m_s=0.45))
    rig = FirstDriveRig(tmp_path)
    rig.ready()
    values = [one[1] for one in TABLE]
    usual = values[index_of("linear_permille")], values[index_of("step_ramp_ms")]

    def step_ms() -> int:
        reply = rig.link.setting(codes.SETTING_GET, index_of("step_forward_ms"))
        assert reply is not None
        return reply.value

    for profile in (3, 2):
        assert rig.post(run="profile", value=profile) == ""
        assert step_ms() == store.step_ms(profile, *usual)
    # One that a caretaker has set stays while the profile does.
    rig.link.setting(codes.SETTING_SET, index_of("step_forward_ms"), 1234)
    assert rig.post(run="profile", value=2) == ""
    assert step_ms() == 1234


# While it arms, in a pulse, between two.
@pytest.mark.parametrize("how", ["let_go", "silent", "stop", "gone"])
@pytest.mark.parametrize("after_ms", [60, 1000])
def test_what_moves_ends_with_the_held_button(how: str, after_ms: int) -> None:
    rig = FirstDriveRig()
    rig.ready()
    rig.press("tune")
    rig.run(40)
    began_ms = rig.now_ms
    ended_ms = 0

    def end() -> None:
        nonlocal ended_ms
        if rig.now_ms - began_ms < 1500 + after_ms or ended_ms:
            return
        ended_ms = rig.now_ms
        if how == "let_go":
            rig.let_go()
        elif how == "silent":
            rig.forget()
        elif how == "stop":
            rig.driver.say(k="stop")
        else:
            rig.forget()
            rig.caretaker.close()

    rig.watch = end
    assert rig._finish() == "first_let_go"
    assert rig.now_ms - ended_ms < 300 + 300  # proof, and the last orders
    rig.comes_to_rest()
    rig.run(500)
    assert rig.neutral()
    assert not rig.armed()
    # The same press never moves anything again.
    rig.run(300)
    assert rig.guide.due is None


@pytest.mark.parametrize("own", [False, True])
def test_a_step_pressed_before_somebody_elses_stop_never_begins(own: bool) -> None:
    rig = FirstDriveRig()
    rig.ready()
    orders: list[int] = []
    send = rig.link.order

    def record(action: int, owner: int) -> None:
        orders.append(action)
        send(action, owner)

    rig.link.order = record  # type: ignore[method-assign]
    token = rig.steering.token()
    rig.run(80)
    if own:  # sent before the press, as one connection keeps the order
        rig.control.receive(rig.caretaker.client, {"k": "stop"})
    else:
        rig.control.receive(rig.driver.client, {"k": "stop"})
        rig.run(10)
        rig.control.receive(rig.caretaker.client, {"k": "stop"})
    rig.run(20)
    step = {"k": "step", "step": "tune", "held": True, "edge": 1, "token": token, "since": 0}
    refusals = rig.control.receive(rig.caretaker.client, step)
    assert [one["reason"] for one in refusals] == ([] if own else ["first_hold"])
    assert (rig.guide.due is not None) == own
    if not own:
        rig.run(300)
        assert codes.ARM not in orders


def test_nor_does_one_whose_first_message_came_too_late() -> None:
    rig = FirstDriveRig()
    rig.ready()
    token = rig.steering.token()
    rig.run(80)
    rig.control.receive(rig.driver.client, {"k": "stop"})
    rig.run(220)
    step = {"k": "step", "step": "tune", "held": True, "edge": 1, "token": token}

    def held(since_ms: int) -> list[str]:
        refusals = rig.control.receive(rig.caretaker.client, {**step, "since": since_ms})
        return [str(one["reason"]) for one in refusals]

    assert held(0) == ["stale_token"]
    assert held(200) == ["first_hold"]
    assert rig.guide.due is None


def test_it_refuses_with_the_reason() -> None:
    rig = FirstDriveRig()
    assert rig.rows()["tune"]["refused"] == "not_connected"
    rig.ready()
    rig.sees = False
    rig.run(500)
    assert rig.hold("tune") == "obstacle_data_old"
    rig.sees = True
    rig.run(500)
    rig.driver.say(k="emergency")
    rig.run(300)
    assert rig.hold("turn") == "emergency"
    rig.caretaker.reset()
    rig.run(1500)
    rig.driver.arm()
    rig.until(rig.armed, 1500)
    for step in ("neutral", "heading", "profile"):
        assert rig.post(run=step, value=1) == "setting_while_armed", step
    assert rig.hold("relay") == "setting_while_armed"
    rig.driver._send_fresh(k="step", step="relay", held=True, edge=99)
    rig.run(20)
    assert rig.refusals[-1] == "not_allowed"


def test_nobody_else_begins_to_drive_while_a_step_moves_the_chair() -> None:
    rig = FirstDriveRig()
    rig.ready()
    rig.press("tune")
    rig.run(40)

    def tries() -> None:
        if rig.now_ms % 200 == 0 and rig.guide.moving:
            rig.driver.arm()
        if rig.armed():
            assert rig.app.safety.owner == codes.CARETAKER
        if rig.now_ms > 6000:
            rig.let_go()

    rig.watch = tries
    assert rig._finish() == "first_let_go"
    assert "not_owner" in rig.refusals


def test_marks_calibrate_the_camera_while_driving_is_off(tmp_path: Path) -> None:
    rig = FirstDriveRig(tmp_path)
    row = rig.rows()["camera"]
    assert (row["size"], row["found"], row["refused"]) == ([640, 480], None, "")
    assert rig.post(run="camera", value=marks()) == ""
    row = rig.rows()["camera"]
    assert row["done"]
    assert row["found"]["residual_mm"] < 20
    # Where 2 m ahead is drawn, it is seen.
    (line,) = (one["px"] for one in row["lines"] if one["m"] == 2.0)
    u, v = EYE.pixel(2.0, 0.0)
    assert min(abs(x - u / 640) + abs(y - v / 480) for x, y in line) < 0.02
    stored = FloorStore(tmp_path).get()

    rig.ready()
    rig.driver.arm()
    rig.until(rig.armed, 1500)
    assert rig.rows()["camera"]["refused"] == "setting_while_armed"
    assert rig.post(run="camera", value=marks()) == "setting_while_armed"
    rig.driver.say(k="disarm")
    rig.run(500)
    rig.picture = FloorView(Eye(640, 360), Floor()).jpeg(0.0, 0.0, 0.0)
    row = rig.rows()["camera"]
    assert (row["done"], row["found"]["fits"], row["lines"]) == (False, False, [])
    rig.picture = None
    assert rig.rows()["camera"]["refused"] == "camera_lost"
    assert rig.post(run="camera", value=marks()) == "camera_lost"
    assert FloorStore(tmp_path).get() == stored
    assert "camera" not in FirstDriveRig().rows()


@pytest.mark.parametrize(
    "value",
    [
        None,
        {},
        "marks",
        marks() * 3,
        [[0.5, 0.5, 100.0]] * 7,
        [[0.5, 0.5, 100.0, "1"]] * 7,
        [[0.5, 0.5, 100.0, True]] * 7,
        [[0.5, 0.5, float("nan"), 0.0]] * 7,
        [[0.5, 0.5, float("inf"), 0.0]] * 7,
        [[0.5, 0.5, 10**400, 0]] * 7,
    ],
    ids=lambda value: repr(value)[:24],
)
def test_what_is_no_list_of_marks_is_refused(tmp_path: Path, value: object) -> None:
    rig = FirstDriveRig(tmp_path)
    assert rig.post(run="camera", value=value) == "setting_out_of_range"
    assert FloorStore(tmp_path).get() is None


@pytest.mark.parametrize(
    ("error_key", "rows"),
    [
        ("floor_few_taps", marks()[:5]),
        ("floor_taps_in_line", [[u, v, x, 0] for u, v, x, _ in marks()]),
        ("floor_wrong_units", [[u, v, x / 100, y / 100] for u, v, x, y in marks()]),
        ("floor_left_right_swapped", [[u, v, x, -y] for u, v, x, y in marks()]),
        ("floor_forward_left_swapped", [[u, v, y, x] for u, v, x, y in marks()]),
        ("floor_residual", [*marks()[:6], [*marks()[6][:2], 200, 100]]),
        ("floor_residual", [[u, v * (n < 5), x, y] for n, (u, v, x, y) in enumerate(marks())]),
        ("floor_tap_outside", [*marks()[:6], [1.2, 0.5, 200, 0]]),
    ],
)
def test_marks_that_cannot_be_right_are_refused_with_the_reason(
    tmp_path: Path, error_key: str, rows: list[list[float]]
) -> None:
    rig = FirstDriveRig(tmp_path)
    assert rig.post(run="camera", value=rows) == "first_failed"
    ended = rig.guide.status()["run"]["ended"]
    assert ended["error"] == error_key
    assert json.loads(json.dumps(ended, allow_nan=False)) == ended
    assert FloorStore(tmp_path).get() is None
    assert not rig.rows()["camera"]["done"]
