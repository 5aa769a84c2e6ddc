"""A ride ends when its mission has been blocked for long, whatever it tries meanwhile."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from gazechair.going.follow import STOP, Stick
from gazechair.going.mission import BLOCKED, DRIVING, WAITING
from gazechair.going.plan import NO_WAY, Pose
from gazechair.going.rolled import Rolled
from gazechair.producers.contract import Sensed
from gazechair.producers.ride import Ride
from gazechair.sensing.odometry.estimate import Estimate

GOAL: Pose = (4.0, 2.0, 0.0)


class Tries:
    """A mission whose plans all come to nothing: every 12 s it drives, waits, and is blocked."""

    path_to_goal = None
    cap_permille = 1000
    reason = NO_WAY

    def __init__(self, moves: bool) -> None:
        self.goal: Pose | None = None
        self.state = BLOCKED
        self.rolled = Rolled()
        self._moves = moves

    def go(self, goal: Pose) -> None:
        self.goal = goal

    def locate(self, _located: object) -> None:
        pass

    def step(self, now_s: float, _put_out: Stick) -> Stick:
        self.state = (DRIVING, WAITING, BLOCKED)[int(now_s % 12.0 / 4.0)]
        if self._moves and self.state == DRIVING:
            self.rolled.on(0.1, 0.0, 0.05)
        return STOP


@pytest.mark.parametrize(("moves", "ends"), [(False, True), (True, False)])
def test_plans_that_move_nothing_do_not_make_it_last_for_ever(moves: bool, ends: bool) -> None:
    ride = Ride(ThreadPoolExecutor(1))
    ride.begin()
    mission: Any = Tries(moves)
    for n in range(round(120.0 / 0.05)):
        now_s = 0.05 * n
        at = Estimate(now_s, *(0.0,) * 10, 1.0, (), 1)
        sent = ride.step(mission, GOAL, (0.0, 0.0, 0.0), at, now_s)
        if sent.stick is None:
            break
    assert (sent.state == "ended") is ends
    if ends:
        assert 38.0 < now_s < 46.0
        assert sent.reason == NO_WAY


def test_the_speed_cap_reaches_the_mission() -> None:
    ride = Ride(ThreadPoolExecutor(1))
    mission: Any = Tries(False)
    ride.take_in(Sensed(cap_permille=321))
    ride.step(mission, GOAL, (0.0, 0.0, 0.0), Estimate(0.0, *(0.0,) * 10, 1.0, (), 1), 0.0)
    assert mission.cap_permille == 321
