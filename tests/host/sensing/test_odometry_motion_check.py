"""A chair that moves without or against a command, creeps, or stands on one, is reported."""

from __future__ import annotations

import math
from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest

from gazechair.base.health import Health
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.odometry import doubts
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.motion_check import Checked, MotionCheck
from gazechair.sensing.odometry.obeys import Obeys
from gazechair.sensing.odometry.odometry import Odometry
from gazechair.sensing.odometry.seen import Outputs, Seen
from gazelink import codes
from host.sensing.test_odometry_doubts import (
    Command,
    Path,
    corridor,
    first,
    idle,
    pieces,
    room,
    say,
    still,
)


def moving(m_s: float, deg_s: float, since_s: float, until_s: float = math.inf) -> Path:
    def path(time_s: float) -> tuple[float, float, float]:
        passed_s = max(0.0, min(time_s, until_s) - since_s)
        return m_s * passed_s, 0.0, deg_s * passed_s

    return path


def told(drive: int, turn: int, since_s: float) -> Command:
    return lambda time_s: (drive, turn) if time_s > since_s else (0, 0)


def reasons(found: list[Estimate]) -> list[tuple[float, str]]:
    """What the health of the motion said, and when."""
    health = Health("motion")
    board = SimpleNamespace(state=codes.ARMED)
    obeys = Obeys(health, lambda: board)  # type: ignore[arg-type, return-value]
    said = [(0.0, "ok")]
    for one in found:
        obeys.judge(one)
        if health.now().reason != said[-1][1]:
            said.append((one.time_s, health.now().reason))
    return said[1:]


def told_at(found: list[Estimate], reason: str) -> float:
    """When the health said so; inf: never."""
    return next((time_s for time_s, one in reasons(found) if one == reason), math.inf)


WIDE = {"corridor": corridor(), "hall": room(40.0)}


@pytest.mark.parametrize("place", WIDE)
def test_a_turn_without_a_command_is_told_where_the_lidars_see_little(place: str) -> None:
    found = say(WIDE[place], moving(0.0, 30.0, 3.5), idle, 5.0)
    assert 3.5 < told_at(found, "motion_uncommanded") < 4.0


@pytest.mark.parametrize("place", WIDE)
def test_standing_or_rolling_where_the_lidars_see_little_tells_nothing(place: str) -> None:
    assert reasons(say(WIDE[place], moving(0.2, 0.0, 3.5), idle, 5.0)) == []


@pytest.mark.parametrize("place", WIDE)
def test_a_turn_that_is_stuck_is_told_where_the_lidars_see_little(place: str) -> None:
    found = say(WIDE[place], still, told(0, 900, 3.0), 4.5)
    assert 3.6 < told_at(found, "motion_stuck") < 4.1


def test_a_chair_that_drives_backward_when_told_forward_is_told() -> None:
    found = say(room(), moving(-0.2, 0.0, 3.3), told(1000, 0, 3.0), 5.0)
    assert 3.3 < told_at(found, "motion_uncommanded") < 3.8


def test_a_chair_that_rolls_when_told_to_turn_is_told() -> None:
    found = say(room(), moving(0.25, 5.0, 3.3), told(0, 600, 3.0), 5.0)
    assert 3.3 < told_at(found, "motion_uncommanded") < 3.8


@pytest.mark.parametrize("command", [(1000, 0), (0, -600), (1000, -300)])
def test_a_chair_that_spins_when_told_otherwise_is_told(command: tuple[int, int]) -> None:
    found = say(room(), moving(0.1, 30.0, 3.3), told(*command, 3.0), 5.0)
    assert 3.3 < told_at(found, "motion_uncommanded") < 4.0


def test_casters_that_swing_the_chair_as_it_starts_are_not_told() -> None:
    def path(time_s: float) -> tuple[float, float, float]:
        swung = min(max(0.0, time_s - 3.3) / 0.4, 1.0)
        return 0.3 * max(0.0, time_s - 3.3), 0.0, 7.5 * (1.0 - math.cos(math.pi * swung))

    assert reasons(say(room(), path, told(700, 0, 3.0), 5.0)) == []


@pytest.mark.parametrize("turn", [False, True])
def test_a_chair_that_rolls_on_when_told_the_opposite_is_not_told(turn: bool) -> None:
    def path(time_s: float) -> tuple[float, float, float]:
        """It brakes for two seconds, and then begins to go the other way."""
        gone = min(time_s, 3.0)
        for tenth in range(round(10 * max(0.0, time_s - 3.0))):
            gone += 0.1 * max(1.0 - 0.05 * tenth, -1.0)
        return (0.0, 0.0, 30.0 * gone) if turn else (-1.0 + 0.4 * gone, 0.0, 0.0)

    def command(time_s: float) -> tuple[int, int]:
        output = 800 if time_s < 3.0 else -800
        return (0, output) if turn else (output, 0)

    assert reasons(say(room(), path, command, 6.0)) == []


def test_a_turn_at_the_usual_output_that_is_stuck_is_told() -> None:
    found = say(room(), still, told(0, 500, 3.0), 5.5)
    assert 4.4 < told_at(found, "motion_stuck") < 4.8


def test_a_turn_that_is_stuck_where_it_once_turned_is_told_sooner() -> None:
    def command(time_s: float) -> tuple[int, int]:
        return 0, 500 if 1.0 < time_s < 3.0 or time_s > 5.0 else 0

    found = say(room(), moving(0.0, 12.0, 1.2, 3.3), command, 7.0)
    assert 5.6 < told_at(found, "motion_stuck") < 6.1


def test_a_slow_turn_is_not_stuck() -> None:
    assert reasons(say(room(), moving(0.0, 4.0, 3.4), told(0, 500, 3.0), 6.0)) == []


def test_a_chair_that_has_just_reversed_is_not_stuck() -> None:
    """It was told backward for a moment and has just begun to go there."""

    def path(time_s: float) -> tuple[float, float, float]:
        forward = 0.3 * min(max(0.0, time_s - 1.2), 1.8)
        return forward - 0.1 * max(0.0, time_s - 3.7), 0.0, 0.0

    found = say(room(), path, lambda t: (600 if 1.0 < t < 3.0 else -600 * (t > 3.0), 0), 5.0)
    assert reasons(found) == []


@pytest.mark.parametrize("speed", [(0.05, 0.0), (0.07, 0.0), (0.0, 5.0)])
def test_creeping_is_told_while_it_lasts_and_no_longer(speed: tuple[float, float]) -> None:
    found = say(room(), moving(*speed, 3.5, 8.0), idle, 10.0)
    told = reasons(found)
    assert [reason for _, reason in told] == ["motion_uncommanded", "ok"]
    assert 3.5 < told[0][0] < 6.0
    assert 8.0 < told[1][0] < 9.9


def test_creeping_round_is_told_in_a_hall() -> None:
    found = say(WIDE["hall"], moving(0.0, 5.0, 3.5), idle, 6.5)
    assert told_at(found, "motion_uncommanded") < 5.2


def test_a_nudge_and_a_drifting_sensor_are_no_creeping() -> None:
    def path(time_s: float) -> tuple[float, float, float]:
        return 0.03 * min(max(0.0, time_s - 3.5), 2.0), 0.0, 0.02 * time_s

    assert reasons(say(room(), path, idle, 8.0)) == []


def test_a_turn_without_a_heading_is_not_stuck() -> None:
    """Nobody measures the turn."""
    odometry, found = Odometry(), []
    for piece in pieces(room(), moving(0.0, 5.0, 1.0), 3.0):
        for time_s in np.arange(piece.times_s[0], piece.times_s[-1], 0.02):
            odometry.motion(Motion(float(time_s), None, 0, 900 if time_s > 0.5 else 0))
        estimate = odometry.piece(piece)
        assert estimate is not None
        found.append(estimate)
    assert first(found, doubts.STUCK) == math.inf


LONG_S = 10.0


def checked(
    ahead_m_s: list[float], yaw_deg_s: dict[int, float], drive: int
) -> Iterator[tuple[float, Checked]]:
    """What the check says each 0.05 s of a chair that is told to drive forward; and when."""
    check = MotionCheck()
    outputs = Outputs(drive, 0, 0, 0.0, 0.0, LONG_S, LONG_S, LONG_S)
    for k, speed in enumerate(ahead_m_s):
        at_s, yaw = 0.05 * k, yaw_deg_s.get(k, 0.0)
        seen = Seen(
            *(at_s, True, 500, 1e4 * np.eye(2), 0.9, speed, 0.02, 0.0, yaw, 0.0, 0.0, 0.0),
            *(abs(speed), speed, outputs, 0.0, 0.0, False, False, False),
        )
        yield at_s, check.judge(seen, True, True)


def test_a_chair_that_slowly_begins_to_roll_against_its_command_is_told_when_it_is_sure() -> None:
    speeds = [-0.3 * 0.05 * k for k in range(20)]  # 0.1 m/s after 0.33 s
    assert min(at_s for at_s, one in checked(speeds, {}, 700) if one.pushed) == pytest.approx(0.4)


def test_a_moment_in_which_it_seems_to_is_not_told() -> None:
    speeds = [0.1] * 10 + [-0.12] * 2 + [0.1] * 10
    assert not any(one.pushed for _, one in checked(speeds, {}, 700))


def test_one_noisy_moment_of_the_heading_does_not_make_stuck_late() -> None:
    stuck_s = [
        min(at_s for at_s, one in checked([0.0] * 40, yaw, 440) if one.stuck)
        for yaw in ({}, {15: 6.5})
    ]
    assert stuck_s[0] == stuck_s[1] <= 1.5
