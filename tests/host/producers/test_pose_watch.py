"""A pose that is not known for a moment makes the chair stand; for longer, the motion is over."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gazechair.producers.odometry_track import OdometryTrack
from gazechair.producers.pose_watch import (
    AGAIN_S,
    DOUBTED,
    ENDS_S,
    KNOWN,
    LOST,
    STANDS_S,
    PoseWatch,
)
from gazechair.sensing.odometry import doubts
from gazechair.sensing.odometry.estimate import Estimate

PERIOD_S = 0.05
ROLLING = Estimate(0.0, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.01, 0.01, 0.1, 0.02, 1.0, (), 1)
STANDING = replace(ROLLING, speed_m_s=0.0)


class Ride:
    """A motion that is judged every 50 ms."""

    def __init__(self) -> None:
        self.now_s = 100.0
        self.track = OdometryTrack()
        self.watch = PoseWatch()

    def step(self, known: bool, estimate: Estimate | None = ROLLING) -> str:
        self.now_s += PERIOD_S
        if estimate is not None:
            self.track.take([replace(estimate, time_s=self.now_s)])
        return self.watch.judge(self.now_s if known else None, self.track, self.now_s)

    def run(self, known: bool, for_s: float, estimate: Estimate | None = ROLLING) -> list[str]:
        return [self.step(known, estimate) for _ in range(round(for_s / PERIOD_S))]


@pytest.fixture
def ride() -> Ride:
    made = Ride()
    assert made.run(True, 1.0) == [KNOWN] * 20
    return made


@pytest.mark.parametrize("estimate", [STANDING, None], ids=["unsure", "late"])
def test_a_moment_of_doubt_passes_once_the_pose_is_known_for_a_while(
    ride: Ride, estimate: Estimate | None
) -> None:
    for _ in range(2):  # counted anew
        assert set(ride.run(False, ENDS_S - PERIOD_S, estimate)) == {DOUBTED}
        assert set(ride.run(True, AGAIN_S, STANDING)) == {DOUBTED}
        ride.run(True, 2 * PERIOD_S, STANDING)
        assert set(ride.run(True, 10.0)) == {KNOWN}


def test_a_pose_that_is_known_for_moments_only_is_lost_as_well(ride: Ride) -> None:
    sent: list[str] = []
    while LOST not in sent:
        sent += ride.run(False, 0.2, STANDING)
        sent += ride.run(True, AGAIN_S - PERIOD_S, STANDING)
        assert KNOWN not in sent
        assert len(sent) * PERIOD_S < STANDS_S + 1.0


@pytest.mark.parametrize("estimate", [STANDING, None], ids=["unsure", "late"])
def test_a_pose_that_stays_unknown_is_lost_within_half_a_second(
    ride: Ride, estimate: Estimate | None
) -> None:
    """Of when it was last seen there (promise P20); and stays lost, as there is no new press."""
    sent = ride.run(False, 1.0, estimate)
    assert (sent.index(LOST) + 1) * PERIOD_S == pytest.approx(ENDS_S, abs=PERIOD_S + 1e-6)
    assert (sent.index(LOST) + 1) * PERIOD_S <= 0.5
    assert set(sent[sent.index(LOST) :]) == {LOST}


def test_a_pose_that_was_old_when_it_was_known_is_lost_sooner(ride: Ride) -> None:
    old_s = 0.2
    for _ in range(20):
        ride.now_s += PERIOD_S
        assert ride.watch.judge(ride.now_s - old_s, ride.track, ride.now_s) == KNOWN
    sent = ride.run(False, 1.0, None)
    assert (sent.index(LOST) + 1) * PERIOD_S <= 0.5 - old_s + 1e-6


def test_the_first_pose_of_a_motion_is_waited_for(ride: Ride) -> None:
    ride.watch.begin()
    assert set(ride.run(False, STANDS_S - 0.1, None)) == {DOUBTED}
    assert ride.run(False, 0.3, None)[-1] == LOST


@pytest.mark.parametrize(
    "moved",
    [
        replace(STANDING, track=2),
        replace(STANDING, doubts=(doubts.CARRIED,)),
        replace(STANDING, doubts=(doubts.PUSHED,)),
        replace(STANDING, doubts=(doubts.LOST,)),
        replace(STANDING, x_m=0.15),
        replace(STANDING, heading_deg=7.0),
    ],
    ids=["odometry began again", "carried", "pushed", "lost", "aside", "turned"],
)
@pytest.mark.parametrize("known", [False, True])
def test_a_chair_that_others_have_moved_does_not_go_on_by_itself(
    ride: Ride, moved: Estimate, known: bool
) -> None:
    assert set(ride.run(False, 0.3, STANDING)) == {DOUBTED}
    assert LOST in ride.run(known, 0.1, moved)


def test_another_motion_does_not_inherit_the_doubt(ride: Ride) -> None:
    ride.run(False, STANDS_S + 1.0)
    ride.watch.begin()
    assert ride.step(True, replace(ROLLING, track=9)) == KNOWN
