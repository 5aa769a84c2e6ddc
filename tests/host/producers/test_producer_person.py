"""Kind "person": its output while it chooses, follows, and without a view or a pose."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gazechair.base.footprint import Footprint
from gazechair.config.settings import LidarConfig
from gazechair.driving.messages import LOWEST_CAP_PERMILLE
from gazechair.going.mission import LIMIT
from gazechair.producers import exchange
from gazechair.producers.contract import Output, Press, Sensed, Setup
from gazechair.producers.person import NARROW, SIGHT_LOST, UNSEEN, PersonProducer
from gazechair.producers.pose_watch import ENDS_S
from gazechair.producers.runner import Runner
from gazechair.producers.track import ESTIMATE_OLD_S
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Lidars, Piece
from gazechair.sensing.odometry import doubts
from gazechair.sensing.odometry.estimate import Estimate
from gazelink.settings_table import TABLE, profile_row
from gazesim import rays
from gazesim.producer_chair import Inline

_LIDAR_M, _HALL_M, _HALF_S = 0.5, 6.0, 0.05
_SETTINGS = {row[0]: row[1] for row in TABLE}


class Chair:
    """A chair that stands in a round hall. `person`: distance ahead of its axle, None: nobody."""

    def __init__(self) -> None:
        self.producer = PersonProducer(Setup(Footprint(), Path("none"), thinker=Inline()))
        self.now_s = 100.0
        self.person: float | None = 3.4
        self.aside_m = 0.0  # to the left
        self.track = 1
        self.doubts: tuple[str, ...] = ()
        self.gap_m = math.inf  # between two pillars right before its front
        self._way = 0.0
        self._random = np.random.default_rng(3)
        self.sent = Output(None)
        self.cap_permille = 1000

    def press(self, sees_behind: bool = True, **settings: int) -> None:
        chosen = {**_SETTINGS, **settings}
        self.producer.press(Press(7, {}, chosen, sees_behind, self.now_s))

    def half(self, number: int) -> tuple[Piece, Estimate]:
        """Half a turn that ends now."""
        directions = -180.0 * number - np.linspace(0.0, 179.5, 360)
        angles = np.radians(directions)
        here = np.full(len(angles), _LIDAR_M), np.zeros(len(angles))
        swing = 0.17 * math.sin(math.pi * self._way / 0.35)
        legs = []
        if self.person is not None:
            legs = [
                (self.person + side * swing, self.aside_m + side * 0.09, 0.055)
                for side in (1.0, -1.0)
            ]
        if self.gap_m < math.inf:
            legs += [(0.9, side * (0.5 * self.gap_m + 0.2), 0.2) for side in (1.0, -1.0)]
        seen = rays.cast_discs(*here, angles, np.array(legs, dtype=np.float64).reshape(-1, 3))
        along = here[0] * np.cos(angles)
        hall = -along + np.sqrt(along**2 - _LIDAR_M**2 + _HALL_M**2)
        metres = np.minimum(seen, hall) + self._random.normal(0.0, 0.006, len(angles))
        times = self.now_s + np.linspace(-_HALF_S, -0.0001, len(angles))
        piece = Piece(directions, metres, times, (_LIDAR_M, 0.0), 720)
        sure = (0.0, 0.0, 0.1, 0.02, 1.0, self.doubts)
        return piece, Estimate(piece.middle_s, *(0.0,) * 6, *sure, self.track)

    def later(self, walk_m_s: float = 0.0) -> None:
        """Half a turn later."""
        self.now_s += _HALF_S
        if self.person is not None:
            self.person += walk_m_s * _HALF_S
            self._way += abs(walk_m_s) * _HALF_S

    def runs(self, seconds: float, walk_m_s: float = 0.0, requested: bool = True) -> list[Output]:
        """Run; returns the output of each step."""
        found, kept = [], Sensed()
        for number in range(round(seconds / _HALF_S)):
            self.later(walk_m_s)
            piece, estimate = self.half(number)
            kept.pieces.append(piece)
            kept.estimates.append(estimate)
            kept.cap_permille = self.cap_permille
            if requested:
                found.append(self.producer.step(kept, self.now_s))
                kept = Sensed()
        self.waiting = kept
        return found

    def blind(self, seconds: float) -> list[Output]:
        """Run without lidar, or without odometry."""
        found = []
        for _ in range(round(seconds / _HALF_S)):
            self.now_s += _HALF_S
            found.append(self.producer.step(Sensed(), self.now_s))
        return found

    def follows(self) -> None:
        """A person comes, stands there, and walks on."""
        self.press()
        self.runs(3.0, -0.5)
        self.runs(2.6)
        sent = self.runs(2.0, 0.4)[-1]
        assert sent.state == "drives"
        assert sent.stick is not None
        assert sent.stick[0] > 100


@pytest.fixture
def chair() -> Chair:
    return Chair()


def test_stands_until_somebody_stands_before_it_then_follows(chair: Chair) -> None:
    chair.press()
    sent = chair.runs(4.0, -0.39)
    assert {(one.stick, one.state, one.reason) for one in sent} == {
        ((0, 0), "waits", "person_choosing")
    }
    assert chair.runs(2.6)[-1].state == "drives"
    sent = chair.runs(2.0, 0.4)
    assert sent[-1].stick is not None
    assert sent[-1].stick[0] > 100


def test_who_came_before_the_press_need_not_come_again(chair: Chair) -> None:
    chair.person = 2.55
    chair.runs(1.4, -0.5, requested=False)
    received = chair.waiting
    chair.runs(1.8, requested=False)
    received.pieces += chair.waiting.pieces
    received.estimates += chair.waiting.estimates
    chair.press()
    chair.producer.step(received, chair.now_s)
    assert chair.runs(0.5)[-1].state == "drives"


class _Pressed:
    """The producer in its runner, with a lidar behind the chair, too; `states`: of its reports."""

    def __init__(self, chair: Chair) -> None:
        self._chair = chair
        self.states: list[str] = []
        self._press = 0
        mounts = (_LIDAR_M, 0.0), (-_LIDAR_M, 180.0)
        rows = [LidarConfig(x_m=x_m, heading_deg=heading) for x_m, heading in mounts]
        lidars = Lidars(tuple(rows))
        self._runner = Runner(chair.producer, lidars, self, Inline(), lambda: chair.now_s)

    def data(self, payload: bytes) -> None:
        """What it reports."""
        self.states.append(exchange.unpack(payload).state)

    def runs(self, seconds: float, walk_m_s: float = 0.0, press: int = 0) -> None:
        """Run, pressed if `press`."""
        chair = self._chair
        for number in range(round(seconds / _HALF_S)):
            chair.later(walk_m_s)
            piece, estimate = chair.half(number)
            for lidar, before_s in ((1, 0.02), (0, 0.0)):
                first_s, last_s = (float(piece.times_s[k]) - before_s for k in (0, -1))
                seen = piece.directions_deg, piece.distances_m
                self._runner.received(HalfTurn(lidar, *seen, first_s, last_s), chair.now_s)
                at_s = piece.middle_s - before_s
                self._runner.received(replace(estimate, time_s=at_s), chair.now_s)
            for late_s in (0.04, 0.02, 0.0):
                self._runner.received(Motion(chair.now_s - late_s, None, 0, 0), chair.now_s)
            more = {"target": {}, "settings": _SETTINGS, "may_reverse": True, "cap_permille": 1000}
            self._runner.on_message({"at_s": chair.now_s, "press": press, **more})
            self._runner.tick(chair.now_s)


def test_with_two_lidars_who_stands_there_at_the_press_is_followed_at_once(chair: Chair) -> None:
    """What both have seen in the seconds before the press counts, the person's steps too."""
    chair.person = 2.55
    pressed = _Pressed(chair)
    pressed.runs(1.4, -0.5)
    pressed.runs(1.8)
    pressed.runs(0.5, press=1)
    assert pressed.states[-1] == "drives"


def test_with_an_output_limit_in_the_deadband_it_stands_and_says_so(chair: Chair) -> None:
    deadband = profile_row(_SETTINGS["profile"], "deadband_permille")
    chair.press(**{deadband: 300, "linear_permille": 150})
    sent = [*chair.runs(3.0, -0.5), *chair.runs(2.6), *chair.runs(2.0, 0.4)]
    assert (sent[-1].stick, sent[-1].state, sent[-1].reason) == ((0, 0), "waits", LIMIT)
    assert {one.stick[0] for one in sent if one.stick is not None} == {0}


def test_with_a_speed_cap_too_low_to_turn_to_the_person_it_says_so_until_it_is_raised(
    chair: Chair,
) -> None:
    """Before, it requested a turn that moves no chair, and "followed"."""
    chair.follows()
    chair.runs(1.0)
    chair.cap_permille = 150
    for _ in range(20):
        chair.aside_m += 0.8 * _HALF_S
        chair.runs(2.0 * _HALF_S, -0.55)
    sent = chair.runs(1.0)[-1]
    assert (sent.stick, sent.state, sent.reason) == ((0, 0), "waits", LIMIT)
    chair.cap_permille = 1000
    sent = chair.runs(0.2)[-1]
    assert sent.state == "drives"
    assert sent.stick is not None
    assert sent.stick[1] > 0


def test_with_a_speed_cap_in_the_deadband_it_stands_and_says_so_until_it_is_raised(
    chair: Chair,
) -> None:
    chair.follows()
    chair.cap_permille = LOWEST_CAP_PERMILLE
    sent = chair.runs(0.5)[-1]
    assert (sent.stick, sent.state, sent.reason) == ((0, 0), "waits", LIMIT)
    chair.cap_permille = 1000
    assert chair.runs(0.5, 0.4)[-1].state == "drives"


def test_nobody_comes(chair: Chair) -> None:
    chair.person = None
    chair.press()
    sent = chair.runs(16.0)
    assert (sent[-1].stick, sent[-1].state, sent[-1].reason) == (None, "ended", "person_nobody")
    assert all(one.stick in ((0, 0), None) for one in sent)


def test_out_of_sight_stands_then_ends_and_says_why(chair: Chair) -> None:
    chair.follows()
    chair.person = None
    sent = chair.runs(1.5)
    assert sent[3].stick == (0, 0)  # with the first whole turn
    assert sent[10].reason == "person_hidden"
    assert (sent[-1].stick, sent[-1].state, sent[-1].reason) == (None, "ended", "person_lost")


def test_stands_and_says_so_where_the_chair_does_not_fit(chair: Chair) -> None:
    """The person leaves between two things that stand there; the chair is wider."""
    chair.gap_m = 0.6
    chair.press()
    chair.runs(3.0, -0.5)
    chair.runs(2.6)
    sent = chair.runs(4.0, 0.15)
    assert (sent[-1].stick, sent[-1].state, sent[-1].reason) == ((0, 0), "waits", NARROW)


def test_without_a_lidar_or_odometry_it_stands_then_ends(chair: Chair) -> None:
    chair.follows()
    sent = chair.blind(1.5)
    late, over = round(ESTIMATE_OLD_S / _HALF_S), round(ENDS_S / _HALF_S)
    assert sent[late].reason == SIGHT_LOST
    ended = [one.stick for one in sent].index(None)
    assert late < ended <= over
    assert all(one.stick == (0, 0) for one in sent[late:ended])
    assert (sent[-1].stick, sent[-1].state, sent[-1].reason) == (None, "ended", SIGHT_LOST)


def test_without_a_lidar_from_the_start_it_says_so(chair: Chair) -> None:
    chair.press()
    sent = chair.blind(2.0)
    assert all(one.stick in ((0, 0), None) for one in sent)
    assert sent[-1].reason == SIGHT_LOST


def test_a_chair_that_does_not_see_behind_itself_says_so_at_once(chair: Chair) -> None:
    chair.press(sees_behind=False)
    assert chair.runs(0.1)[0] == Output(None, "ended", UNSEEN)


def test_odometry_that_begins_afresh_ends_it(chair: Chair) -> None:
    chair.follows()
    chair.track = 2
    assert Output(None, "ended", SIGHT_LOST) in chair.runs(0.2)
    chair.press()  # anew: whoever stands there is chosen anew
    assert chair.runs(0.3)[-1].reason == "person_choosing"


@pytest.mark.parametrize("doubt", [doubts.CARRIED, doubts.LOST, doubts.PUSHED])
def test_a_chair_that_others_move_ends_it(chair: Chair, doubt: str) -> None:
    chair.follows()
    chair.doubts = (doubts.LITTLE,)
    assert chair.runs(0.2, 0.4)[-1].state == "drives"  # an empty hall: the person is seen
    chair.doubts = (doubt,)
    assert Output(None, "ended", SIGHT_LOST) in chair.runs(0.2, 0.4)


def test_nobody_is_chosen_while_others_move_the_chair(chair: Chair) -> None:
    chair.press()
    chair.doubts = (doubts.PUSHED,)
    sent = [*chair.runs(3.0, -0.5), *chair.runs(2.6)]
    assert {(one.stick, one.reason) for one in sent} == {((0, 0), "person_choosing")}
    chair.doubts, chair.person = (), 3.4
    chair.runs(3.0, -0.5)
    assert chair.runs(2.6)[-1].state == "drives"


def test_the_same_piece_again_is_no_sight(chair: Chair) -> None:
    chair.follows()
    piece, estimate = chair.half(0)
    sent = []
    for _ in range(20):
        chair.now_s += _HALF_S
        sent.append(chair.producer.step(Sensed([piece], [estimate]), chair.now_s))
    assert all(one.stick in ((0, 0), None) for one in sent[8:])
    assert sent[-1].reason == SIGHT_LOST
