"""Kind "person": follows a person who stands in front of the chair at the press, or comes there.

It uses only the lidar's view, no map. Scans from the seconds before the press count, so somebody
who has walked up to the chair is recognised at once.
"""

from __future__ import annotations

import math

from gazechair.following.follower import Followed, PersonFollower
from gazechair.following.person import State
from gazechair.following.request import STOP, Request
from gazechair.following.turns import Turns
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.mission import LIMIT
from gazechair.producers.contract import MotionState, Output, Press, Producer, Sensed, Setup
from gazechair.producers.pose_watch import ENDS_S, MOVED_BY_OTHERS
from gazechair.producers.track import ESTIMATE_OLD_S

SIGHT_LOST = "person_no_sight"
"""No lidar turn, or no odometry pose, in time; or others have moved the chair."""
UNSEEN = "person_unseen_behind"
"""No lidar sees behind the chair: the board permits no turn, and the chair would just stand."""
NARROW = "person_narrow"
"""The person went where the chair does not fit."""
_BEGINS_S = 1.5  # longest wait for the first turn after the press
_STATES: dict[State, MotionState] = {
    State.CHOOSING: "waits",
    State.FOLLOWS: "drives",
    State.HIDDEN: "waits",
}
_REASONS = {
    State.NOBODY: "person_nobody",
    State.CHOOSING: "person_choosing",
    State.FOLLOWS: "person_follows",
    State.HIDDEN: "person_hidden",
    State.LOST: "person_lost",
    State.UNSURE: "person_unsure",
}


class PersonProducer(Producer):
    """Follows one person after another."""

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self._turns = Turns()
        self._follower = self._made()
        self._followed = Followed(State.NOBODY, STOP, None)
        self._track: int | None = None
        self._may_turn = False
        self._begun_s = self._seen_s = 0.0

    def press(self, press: Press) -> None:
        self._numbers = ChairNumbers.of(press.settings)
        self._may_turn = press.may_reverse
        self._begin(press.at_s)

    def step(self, sensed: Sensed, now_s: float) -> Output:
        if not self._may_turn:
            return Output(None, "ended", UNSEEN)
        for piece in sensed.pieces:
            self._turns.piece(piece)
        for estimate in sensed.estimates:
            turn = self._turns.estimate(estimate)
            if turn is None:
                continue
            if turn.track != self._track or MOVED_BY_OTHERS.intersection(estimate.doubts):
                if self._followed.state is not State.CHOOSING:
                    return Output(None, "ended", SIGHT_LOST)  # odometry has restarted, or should
                self._begin(self._begun_s)
                self._track = turn.track
            self._seen_s = turn.scan.at_s
            self._followed = self._follower.look(turn.scan, turn.pose)
        late_s = now_s - max(self._seen_s, self._begun_s + _BEGINS_S - ENDS_S)
        if late_s > ENDS_S:
            return Output(None, "ended", SIGHT_LOST)
        state = self._followed.state
        if state not in _STATES:
            return Output(None, "ended", _REASONS[state])
        if late_s > ESTIMATE_OLD_S:
            return Output((0, 0), "waits", SIGHT_LOST)
        if not self._followed.fits:
            return Output((0, 0), "waits", NARROW)
        request = self._followed.request
        if state is State.FOLLOWS and not self._numbers.moves_within(
            request.linear_m_s, request.yaw_rad_s, sensed.cap_permille
        ):
            return Output((0, 0), "waits", LIMIT)
        return Output(self._stick(request), _STATES[state], _REASONS[state])

    def _made(self) -> PersonFollower:
        return PersonFollower(footprint=self.setup.footprint, submit=self.setup.thinker.submit)

    def _begin(self, at_s: float) -> None:
        self._follower = self._made()
        self._follower.choose(at_s)
        self._followed = Followed(State.CHOOSING, STOP, None)
        self._track = None
        self._begun_s, self._seen_s = at_s, -math.inf

    def _stick(self, request: Request) -> tuple[int, int]:
        numbers = self._numbers
        return (
            numbers.linear_permille(min(request.linear_m_s, numbers.most_m_s)),
            numbers.turn_permille(math.degrees(request.yaw_rad_s)),
        )
