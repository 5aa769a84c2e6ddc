"""Driving straight on is tuned by odometry: found, stored, left out where it cannot be measured."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gazechair.board.caretaker_settings import CaretakerSettings
from gazechair.board.events import SettingReply
from gazechair.commissioning.tune import StoppedError, TuneError
from gazechair.commissioning.tune.forward import (
    ForwardNumbers,
    ForwardRecording,
    identify,
    step_shares,
)
from gazechair.commissioning.tune.forward_rows import straight_lines, straight_rows
from gazechair.commissioning.tune.forward_runner import ForwardRunner
from gazechair.commissioning.tune.forward_store import ForwardStore
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.sensing.odometry.doubts import CORRIDOR, STUCK
from gazelink import codes
from gazelink.settings_table import TABLE, index_of
from gazemeasure.home import forward
from measuredchair import Measured
from tunerig import TuneRig, tune_rig

pytestmark = pytest.mark.costly

USUAL = [row[1] for row in TABLE]
NUMBERS = ForwardNumbers(0.36, 0.08, 0.15, 0.3, 0.6, 1.0)


def run(rig: TuneRig, measured: Measured, abort_at_ms: int = 1 << 30) -> list[ForwardRecording]:
    return ForwardRunner(rig.hands(abort_at_ms), measured).run()


def test_the_board_drives_the_chair_and_it_is_found_as_it_is() -> None:
    rig = tune_rig("4.1")
    began = rig.world.chair.x_m, rig.world.chair.y_m
    recordings = run(rig, Measured(rig))
    assert np.hypot(rig.world.chair.x_m - began[0], rig.world.chair.y_m - began[1]) < 2.0
    rig.comes_to_rest()
    rig.wait(0.5)
    assert not rig.armed()
    found, true = identify(recordings), rig.world.chair.parameters.linear
    for share in (0.4, 0.6):
        speed = true.positive * (share - true.deadband) / (1.0 - true.deadband)
        assert found.speed_m_s(share) == pytest.approx(speed, rel=0.04)
    rows = straight_rows(found, "4.1", USUAL, TurnNumbers.default("4.1"))
    step_m = forward._driven_m(
        forward._rested("4.1", 1), step_shares(600, 300, rows["step_forward_ms"])
    )
    assert step_m == pytest.approx(0.5, abs=0.03)
    for share in (0.3, 0.6, 1.0):  # of the stopping distance, the board's and the chair's
        chair = forward._rested("4.1", 1)
        forward._driven_m(chair, [share] * 400)
        speed = chair.speed_m_s
        assumed_m = speed * 0.49 + speed**2 / (2.0 * rows["p4_1_brake_mm_s2"] / 1000.0)
        assert assumed_m >= forward._driven_m(chair, [0.0] * 300)


@pytest.mark.parametrize(("doubt", "reason"), [(CORRIDOR, "do not tell"), (STUCK, "does not move")])
def test_what_is_not_known_ends_it(doubt: str, reason: str) -> None:
    rig = tune_rig()
    with pytest.raises(TuneError, match=reason):
        run(rig, Measured(rig, doubt))
    rig.comes_to_rest()
    assert not rig.armed()


def test_any_key_stops_it() -> None:
    rig = tune_rig()
    with pytest.raises(StoppedError, match="nothing was changed"):
        run(rig, Measured(rig), rig.now_ms + 2500)
    assert rig.neutral()


def test_weaker_brakes_are_stored_and_the_weakest_refused() -> None:
    turns = TurnNumbers.default("3.1")
    rows = straight_rows(NUMBERS, "3.1", USUAL, turns)
    weak = straight_rows(replace(NUMBERS, brake_m_s2=0.3), "3.1", USUAL, turns)
    assert weak["p3_1_brake_mm_s2"] < rows["p3_1_brake_mm_s2"]
    assert set(rows) == {"p3_1_forward_mm_s", "p3_1_brake_mm_s2", "step_forward_ms"}
    for name, value in rows.items():
        _, _, low, high = TABLE[index_of(name)]
        assert low <= value <= high
    measured = list(USUAL)  # by tape
    measured[index_of("p3_1_brake_mm_s2")] = 300
    measured[index_of("p3_1_forward_mm_s")] = 450
    kept = straight_rows(NUMBERS, "3.1", measured, turns)
    assert (kept["p3_1_brake_mm_s2"], kept["p3_1_forward_mm_s"]) == (300, 450)
    with pytest.raises(TuneError, match="weaker brakes"):
        straight_rows(replace(NUMBERS, brake_m_s2=0.15), "3.1", USUAL, turns)


def test_a_step_that_may_not_last_long_enough_is_told() -> None:
    slow = replace(NUMBERS, full_m_s=0.15)
    rows = straight_rows(slow, "1.2", USUAL, TurnNumbers.default("1.2"))
    printed = list(straight_lines(slow, rows, USUAL, "1.2"))
    assert "it may not last longer" in printed[-1]
    assert (
        "goes 0.50 m"
        in list(
            straight_lines(
                NUMBERS, rows | {"step_forward_ms": NUMBERS.step_ms(600, 300, 5000)}, USUAL, "1.2"
            )
        )[-1]
    )


def test_a_chair_that_did_not_drive_as_one_is_refused() -> None:
    time_s = np.arange(0.0, 4.0, 0.01)
    share = np.where((time_s > 0.5) & (time_s < 2.0), 0.6, 0.0)
    measured_s = time_s[::5]
    for way, reason in ((0.4 * (measured_s > 0.6), "as a chair"), (0.0, "hardly")):
        with pytest.raises(TuneError, match=reason):
            identify([ForwardRecording(time_s, share, measured_s, way + 0.0 * measured_s)])
    with pytest.raises(TuneError, match="too little"):
        ForwardRecording.of([(0.0, 0.0)], [], 0.0, 1.0)


class MemoryBoard:
    """Settings on a board that answers, for a caretaker's page."""

    def __init__(self) -> None:
        self.values = list(USUAL)

    def state(self) -> None:
        return None

    def setting(self, request: int, index: int = 0, value: int = 0, timeout_s: float = 1.0) -> Any:
        if request == codes.SETTING_SET:
            self.values[index] = value
        return SettingReply(request, index, self.values[index], codes.NO_REASON)


def test_a_step_goes_as_far_in_another_profile(tmp_path: Path) -> None:
    store = ForwardStore(tmp_path)
    assert store.step_ms(2, 600, 300) is None
    store.keep("3.1", NUMBERS)
    store.keep("4.1", replace(NUMBERS, full_m_s=0.45))
    board = MemoryBoard()
    board.state = lambda: SimpleNamespace(state=codes.DISARMED, faults=0)  # type: ignore[assignment]
    settings = CaretakerSettings(board, ForwardStore(tmp_path).step_ms)  # type: ignore[arg-type]
    step = index_of("step_forward_ms")
    settings.change({"profile": 3})
    assert board.values[step] == store.step_ms(3, 600, 300)
    settings.change({"profile": 2, "linear_permille": 800})
    assert board.values[step] == store.step_ms(2, 800, 300)
    settings.change({"profile": 0})  # not tuned: as it was
    assert board.values[step] == store.step_ms(2, 800, 300)
    settings.change({"profile": 3, "step_forward_ms": 1000})  # as somebody wants it
    assert board.values[step] == 1000
    (tmp_path / "forward.json").write_text('{"3.1": 5}')
    assert store.step_ms(2, 600, 300) is None


@pytest.mark.parametrize(
    "damaged",
    ["5", '{"full_m_s": "x"}', f'{{"full_m_s": {10**309}}}', '{"other": 1}'],
    ids=["number", "text", "large", "other"],
)
def test_a_damaged_profile_costs_no_other_its_numbers(tmp_path: Path, damaged: str) -> None:
    store, file = ForwardStore(tmp_path), tmp_path / "forward.json"
    store.keep("3.1", NUMBERS)
    good = store.step_ms(2, 600, 300)
    file.write_text(f'{file.read_text()[:-1]}, "4.1": {damaged}}}')
    assert store.step_ms(2, 600, 300) == good
    assert store.step_ms(3, 600, 300) is None
    store.keep("2.1", NUMBERS)
    assert store.step_ms(2, 600, 300) == good
    assert json.loads(file.read_text())["4.1"] == json.loads(damaged)


def test_numbers_that_cannot_be_read_are_not_erased(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store, file = ForwardStore(tmp_path), tmp_path / "forward.json"
    store.keep("3.1", NUMBERS)
    with monkeypatch.context() as broken:
        broken.setattr(Path, "read_bytes", _unreadable)
        assert store.step_ms(2, 600, 300) is None
        with pytest.raises(PermissionError):
            store.keep("4.1", NUMBERS)
    assert list(json.loads(file.read_text())) == ["3.1"]
    file.write_text("no JSON")
    store.keep("4.1", NUMBERS)
    assert list(json.loads(file.read_text())) == ["4.1"]
    assert (tmp_path / "forward.damaged").read_text() == "no JSON"


def _unreadable(_: Path) -> bytes:
    raise PermissionError("no")


def test_odometry_tunes_a_profile() -> None:
    off_m, assumed = forward.judged(("3.1", 0))
    assert off_m <= 0.05
    assert assumed >= 1.0
