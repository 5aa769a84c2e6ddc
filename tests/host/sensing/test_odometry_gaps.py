"""After a gap in the scans nobody knows how far the chair went, unless it stood."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from gazechair.base.arrays import FloatArray
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.odometry import Odometry
from gazesim import home_plans
from gazesim.home_drive import FRONT, Drive, Truth

Act = Callable[[Drive], None]


def stop(drive: Drive) -> None:
    drive.driver.route.clear()
    drive.driver.look = lambda: None  # type: ignore[method-assign]


def push(drive: Drive) -> None:
    pose = drive.driver.pose
    drive.driver.pose = replace(pose, heading_deg=pose.heading_deg + 20.0)


def go_on(_: Drive) -> None:
    pass


def gap(
    seconds: float,
    before: Act,
    at_s: float,
    within: Act,
    after_s: float = 0.2,
    reported: Callable[[Motion], Motion | None] = lambda motion: motion,
) -> list[tuple[Estimate, Truth]]:
    """Estimates with the truth; no scans for `seconds` from `at_s` on.

    `before`: at 3 s; `within`: as the gap begins; `reported`: what the board says from then on.
    """
    drive = Drive(home_plans.home(5), 5, (FRONT,), per_turn=200)
    cast = drive.home.cast_moving

    def told(time_s: float) -> bool:
        return not at_s <= time_s < at_s + seconds

    def cast_if_told(
        x_m: FloatArray, y_m: FloatArray, angles_rad: FloatArray, height_m: float
    ) -> FloatArray:
        # What nobody is told is not computed; the dice are thrown all the same.
        return cast(x_m, y_m, angles_rad, height_m) if told(drive.time_s) else np.zeros(len(x_m))

    drive.home.cast_moving = cast_if_told  # type: ignore[method-assign]
    odometry, acts, found = Odometry(), [(3.0, before), (at_s, within)], []
    for event in drive.events(at_s + seconds + after_s):
        if acts and drive.time_s >= acts[0][0]:
            acts.pop(0)[1](drive)
        if isinstance(event, Motion):
            motion = reported(event) if drive.time_s >= at_s else event
            if motion is not None:
                odometry.motion(motion)
        elif told(drive.time_s):
            estimate = odometry.piece(event)
            if estimate is not None:
                found.append((estimate, drive.truth(estimate.time_s)))
    return found


@pytest.mark.parametrize("seconds", [4.0, 60.0])
def test_a_chair_that_drove_when_the_scans_ended_begins_another_track(seconds: float) -> None:
    found = gap(seconds, go_on, 4.2, stop)
    assert max(abs(true.speed_m_s) for _, true in found) > 0.15
    tracks = {estimate.time_s > 4.2: estimate.track for estimate, _ in found}
    assert tracks == {False: 0, True: 1}
    assert abs(found[-1][0].speed_m_s) < 0.02


def test_a_chair_that_stood_keeps_its_track_and_says_how_sure_it_is() -> None:
    found = gap(4.0, stop, 5.0, go_on)
    last, true_last = [one for one in found if one[0].time_s < 5.0][-1]
    first, true = next(one for one in found if one[0].time_s > 5.0)
    assert first.track == last.track
    assert (true.x_m, true.y_m) == (true_last.x_m, true_last.y_m)
    off_m = math.hypot(first.x_m - last.x_m, first.y_m - last.y_m)
    assert off_m < 3.0 * math.hypot(first.along_sigma_m, first.across_sigma_m)
    assert off_m < 0.02


@pytest.mark.parametrize(("seconds", "within"), [(4.0, push), (30.0, go_on)])
def test_who_may_have_been_pushed_meanwhile_begins_another_track(
    seconds: float, within: Act
) -> None:
    assert gap(seconds, stop, 5.0, within)[-1][0].track == 1


@pytest.mark.parametrize(
    "reported",
    [lambda _: None, lambda motion: replace(motion, heading_deg=None)],
    ids=["the board is silent", "no heading"],
)
def test_nobody_vouches_for_a_chair_whose_board_or_heading_was_lost_too(
    reported: Callable[[Motion], Motion | None],
) -> None:
    assert gap(4.0, stop, 5.0, push, reported=reported)[-1][0].track == 1


def test_a_chair_that_drives_on_is_followed_again() -> None:
    found = gap(0.8, go_on, 3.9, go_on, 0.9)
    assert found[-1][0].track == 1
    assert abs(found[-1][1].speed_m_s) > 0.05
    assert all(
        abs(estimate.speed_m_s - true.speed_m_s) < 0.1
        for estimate, true in found
        if estimate.time_s > 5.2
    )


def test_a_short_gap_is_bridged() -> None:
    found = gap(0.6, go_on, 4.2, stop)
    assert found[-1][0].track == 0
    (last, true_last), (first, true) = found[-8], found[-1]
    moved = first.x_m - last.x_m, first.y_m - last.y_m
    assert last.time_s < 4.2 < first.time_s
    way_m = math.hypot(true.x_m - true_last.x_m, true.y_m - true_last.y_m)
    assert abs(math.hypot(*moved) - way_m) < 0.02
