"""Kind "place": takes the chair to a place of the map. Holds a mission, and what it goes by."""

from __future__ import annotations

import math

import numpy as np

from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.costmap import Costmap
from gazechair.going.follow import STOP, Stick
from gazechair.going.mission import ARRIVED, BLOCKED, DRIVING, LOST, PLANNING, Located, Mission
from gazechair.going.plan import Planner, Pose
from gazechair.producers.contract import Press, Producer, Said, Sensed, Setup
from gazechair.producers.track import MapTrack
from gazechair.sensing.mapping.looks import Looks
from gazechair.sensing.mapping.store import MapStore
from gazechair.sensing.odometry.odometry import Motion

POSE_LOST = "going_pose_lost"
MAP_GONE = "going_map_gone"
_WHERE_S = 1.5  # after the press, until the first pose
_BLOCKED_S = 30.0
_SCAN_S = 0.09  # from one look at what stands round the chair to the next
_MOST_POINTS = 40  # of a way that is shown
_STATES = {DRIVING: "drives", BLOCKED: "blocked", PLANNING: "thinks"}


class PlaceProducer(Producer):
    """One mission after another."""

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self._store = MapStore(setup.maps)
        self._track = MapTrack()
        self._looks = Looks()
        self._looked_s = -math.inf
        self._seen = False  # the newest estimate has a look
        self._put_out = STOP
        self._map = ""
        self._mission: Mission | None = None
        self._goal: Pose = (0.0, 0.0, 0.0)
        self._begun_s = 0.0
        self._blocked_s: float | None = None

    def press(self, press: Press) -> None:
        target = press.target
        self._map = str(target["map"])
        x_m, y_m, heading_deg = (float(target[name]) for name in ("x", "y", "heading"))
        self._goal = x_m, y_m, math.radians(heading_deg)
        self._mission = None
        self._begun_s = press.at_s
        self._blocked_s = None
        stored = self._store.get(self._map)
        if stored is None or stored.map is None:
            return
        home, footprint = stored.map, self.setup.footprint
        no_go = [np.array(area.corners_m) for area in home.drawn.no_go]
        grid = home.grid
        costmap = Costmap(grid.occupied, grid.free, grid.cell_m, grid.low_m, footprint, no_go)
        planner = Planner(costmap, press.may_reverse)
        numbers = ChairNumbers.of(press.settings)
        self._mission = Mission(costmap, planner, numbers, footprint, self.setup.thinker.submit)

    def step(self, sensed: Sensed, now_s: float) -> Said:
        self._hear(sensed)
        mission = self._mission
        if mission is None:
            return Said(None, "ended", MAP_GONE)
        pose = self._track.pose(self._map, now_s)
        newest = self._track.newest
        if pose is None or newest is None:
            if mission.goal is None and now_s - self._begun_s < _WHERE_S:
                return Said((0, 0), "thinks")
            return Said(None, "ended", POSE_LOST)
        at = float(pose[0]), float(pose[1]), float(pose[2])
        mission.locate(Located(at, newest.speed_m_s, newest.yaw_rate_deg_s, newest.time_s))
        if mission.goal is None:
            mission.go(self._goal)
        self._look(mission, at, newest.time_s)
        stick = mission.step(now_s, self._put_out)
        return self._said(mission, stick, now_s)

    def _said(self, mission: Mission, stick: Stick, now_s: float) -> Said:
        if mission.state == ARRIVED:
            return Said(None, "arrived")
        if mission.state == LOST:
            return Said(None, "ended", POSE_LOST)
        if mission.state != BLOCKED:
            self._blocked_s = None
        elif self._blocked_s is None:
            self._blocked_s = now_s
        elif now_s - self._blocked_s > _BLOCKED_S:
            return Said(None, "ended", mission.reason)
        state = _STATES.get(mission.state, "waits")
        shown = {"left_m": round(mission.left_m, 1), "way": _way(mission)}
        return Said((stick.linear_permille, stick.turn_permille), state, mission.reason, shown)

    def _hear(self, sensed: Sensed) -> None:
        for piece in sensed.pieces:
            self._looks.piece(piece)
        self._seen = False
        for estimate in sensed.estimates:
            self._seen = self._looks.estimate(estimate) or self._seen
        self._track.take(sensed.estimates, sensed.where)
        if sensed.motions:
            self._put_out = _stick(sensed.motions[-1])

    def _look(self, mission: Mission, at: Pose, time_s: float) -> None:
        """What stands round the chair, as from where it is."""
        if self._seen and time_s >= self._looked_s + _SCAN_S:
            seen = self._looks.seen()
            if seen.estimate.time_s == time_s:
                self._looked_s = time_s
                mission.scan(seen.look.points_m, time_s, at)


def _stick(motion: Motion) -> Stick:
    return Stick(motion.linear_permille or 0, motion.turn_permille or 0)


def _way(mission: Mission) -> list[list[float]]:
    if mission.way is None:
        return []
    points = mission.way.points_m[:_MOST_POINTS]
    return [[round(float(x), 2), round(float(y), 2)] for x, y in points]
