"""A running mission: its inputs other than the pose, and the producer's output for it."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor, Future

from gazechair.going.follow import STOP, Stick
from gazechair.going.mission import ARRIVED, BLOCKED, DRIVING, LOST, PLANNING, Mission
from gazechair.going.plan import Pose
from gazechair.going.planning import Planned
from gazechair.going.rolled import Located
from gazechair.going.stuck import apart
from gazechair.producers.contract import MotionState, Output, Sensed
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.mapping.locating.looks import Looks
from gazechair.sensing.odometry.estimate import Estimate

POSE_DOUBTED = "going_pose_doubted"
"""Why it stands, a key of the string tables: its pose is not known for the moment."""
_BLOCKED_S = 30.0
SCAN_S = 0.09
"""Least time between two views of the chair's surroundings that are used."""
_STATES: dict[str, MotionState] = {DRIVING: "drives", BLOCKED: "blocked", PLANNING: "thinks"}


class Ride:
    """Runs one mission after another."""

    def __init__(self, thinker: Executor) -> None:
        self._thinker = thinker
        self._thought: Future[Planned] | None = None
        self.looks = Looks()
        self.seen = False
        """True if the newest estimate comes with a view of the surroundings."""
        self._looked_s = -math.inf
        self._put_out = STOP
        self._cap_permille = 1000
        self._blocked: tuple[float, Pose] | None = None
        """When it was first blocked since it last moved, and where, by Mission.rolled."""

    def begin(self) -> None:
        """Begin another mission."""
        self._blocked = None

    def submit(self, work: Callable[[], Planned]) -> Future[Planned]:
        """Plan; replaces a queued plan, which belongs to an older mission."""
        if self._thought is not None:
            self._thought.cancel()
        self._thought = self._thinker.submit(work)
        return self._thought

    def take_in(self, sensed: Sensed) -> None:
        """Process new data."""
        for piece in sensed.pieces:
            self.looks.piece(piece)
        self.seen = False
        for estimate in sensed.estimates:
            self.seen = self.looks.estimate(estimate) or self.seen
        self._cap_permille = sensed.cap_permille
        if sensed.motions:
            self._put_out = _stick(sensed.motions[-1])

    def step(
        self, mission: Mission, goal: Pose, at: Pose, newest: Estimate, now_s: float
    ) -> Output:
        """`at`: the pose of `newest` in the mission's frame."""
        mission.locate(Located(at, newest.speed_m_s, newest.yaw_rate_deg_s, newest.time_s))
        mission.cap_permille = self._cap_permille
        if mission.goal != goal:
            mission.go(goal)
        self._look(mission, at, newest.time_s)
        return self._output(mission, mission.step(now_s, self._put_out), now_s)

    def stand(self, mission: Mission, now_s: float) -> Output:
        """A step without a pose: the chair stands, and keeps its path."""
        mission.locate(None)
        return self._output(mission, mission.step(now_s, self._put_out), now_s)

    def _output(self, mission: Mission, stick: Stick, now_s: float) -> Output:
        if mission.state == ARRIVED:
            return Output(None, "arrived")
        if self._blocked is not None and apart(self._blocked[1], mission.rolled.pose):
            self._blocked = None
        if mission.state == BLOCKED:
            self._blocked = self._blocked or (now_s, mission.rolled.pose)
            if now_s - self._blocked[0] > _BLOCKED_S:
                return Output(None, "ended", mission.reason)
        state = _STATES.get(mission.state, "waits")
        reason = POSE_DOUBTED if mission.state == LOST else mission.reason
        shown = {} if mission.path_to_goal is None else {"left_m": round(mission.left_m, 1)}
        return Output((stick.linear_permille, stick.turn_permille), state, reason, shown)

    def _look(self, mission: Mission, at: Pose, time_s: float) -> None:
        """Give the mission the chair's surroundings, seen from its pose."""
        if self.seen and time_s >= self._looked_s + SCAN_S:
            seen = self.looks.seen()
            if seen.estimate.time_s == time_s:
                self._looked_s = time_s
                mission.scan(seen.look.points_m, seen.look.origins_m, time_s, at)


def _stick(motion: Motion) -> Stick:
    return Stick(motion.linear_permille or 0, motion.turn_permille or 0)
