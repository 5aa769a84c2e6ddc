"""Kind "place": drives the chair to a place on the map. Runs a mission and feeds its data."""

from __future__ import annotations

import math
from concurrent.futures import Future
from dataclasses import dataclass, replace

import numpy as np

from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.costmap import Costmap, costmap_of
from gazechair.going.mission import DRIVING, POSE_LOST, Mission
from gazechair.going.plan import Planner, Pose
from gazechair.producers.contract import Output, Press, Producer, Sensed, Setup
from gazechair.producers.odometry_track import OdometryTrack
from gazechair.producers.pose_watch import KNOWN, LOST, PoseWatch
from gazechair.producers.ride import Ride
from gazechair.producers.track import MapTrack
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.store import MapStore, Stored

MAP_GONE, UNSEEN_BEHIND = "going_map_gone", "going_unseen_behind"
_MOST_POINTS = 40  # of a path that is shown
_STEPPED_S = 0.25  # a chair that has not been driven for longer begins a new mission


@dataclass(frozen=True)
class _Model:
    """A map as the planner needs it, which takes seconds to compute."""

    stored: Stored
    costmap: Costmap
    planner: Planner


class PlaceProducer(Producer):
    """Runs one mission after another."""

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self._store = MapStore(setup.maps)
        self._track = MapTrack()
        self._odometry = OdometryTrack()
        self._watch = PoseWatch()
        self._ride = Ride(setup.thinker)
        self._map = ""
        self._kept: tuple[object, ...] = ()  # what a press must share with the one before
        self._mission: Future[Mission | None] = Future()
        self._model: _Model | None = None  # of the newest mission; used by the thinker only
        self._goal: Pose = (0.0, 0.0, 0.0)
        self._sees_behind = False
        self._stepped_s = -math.inf

    def press(self, press: Press) -> None:
        self._sees_behind = press.may_reverse
        if not self._sees_behind:
            return
        target, before = press.target, self._kept
        self._map = str(target["map"])
        self._kept = self._map, target["drawn"], dict(press.settings)
        x_m, y_m, heading_deg = (float(target[name]) for name in ("x", "y", "heading"))
        self._goal = x_m, y_m, math.radians(heading_deg)
        self._ride.begin()
        if self._kept == before and self._drives(press.at_s):
            return  # from here: what it knows of its surroundings and speeds holds
        self._watch.begin()
        before_it = self._made_mission
        if before_it is not None:
            before_it.abandon()  # its plan would be computed before the next one
        self._mission.cancel()
        # Not within the step, which may take 20 s at most: a large map takes longer.
        self._mission = self.setup.thinker.submit(self._made, self._map, press)

    def _drives(self, now_s: float) -> bool:
        """Whether a mission drives the chair now."""
        mission = self._made_mission
        if now_s - self._stepped_s > _STEPPED_S or mission is None:
            return False
        return mission.state == DRIVING

    @property
    def _made_mission(self) -> Mission | None:
        """The newest mission; None: there is none, or it is not made yet."""
        if not self._mission.done() or self._mission.cancelled():
            return None
        return self._mission.result()

    def _made(self, name: str, press: Press) -> Mission | None:
        """The mission in that map; None: there is no such map."""
        stored = self._store.get(name)
        if stored is None or stored.map is None:
            return None
        model = self._model
        if model is None or model.stored is not stored:
            model = self._model = None  # a large one is not kept while the next is computed
            model = self._model = self._modelled(stored, stored.map)
        # A new mission: what the board refused, and who walks, are found out again. What the lidars
        # saw in the last seconds stays in the costmap, also where none of them looks now.
        numbers, footprint = ChairNumbers.of(press.settings), self.setup.footprint
        return Mission(model.costmap, model.planner, numbers, footprint, self._ride.submit)

    def _modelled(self, stored: Stored, home: HomeMap) -> _Model:
        no_go = [np.array(area.corners_m) for area in home.drawn.no_go]
        costmap = costmap_of(home.grid, self.setup.footprint, no_go)
        return _Model(stored, costmap, Planner(costmap, may_reverse=True))

    def step(self, sensed: Sensed, now_s: float) -> Output:
        self._ride.take_in(sensed)
        self._track.take(sensed.estimates, sensed.where)
        self._odometry.take(sensed.estimates)
        if not self._sees_behind:  # no turn on the spot is permitted (promise P19)
            return Output(None, "ended", UNSEEN_BEHIND)
        if not self._mission.done():
            return Output((0, 0), "thinks")
        mission = self._mission.result()
        if mission is None:
            return Output(None, "ended", MAP_GONE)
        pose = self._track.pose(self._map, now_s)
        newest = self._track.newest
        seen_s = None if pose is None else self._track.seen_s
        state = self._watch.judge(seen_s, self._odometry, now_s)
        if state == LOST or self._track.map not in ("", self._map):
            return Output(None, "ended", POSE_LOST)
        if state == KNOWN and pose is not None and newest is not None:
            at = float(pose[0]), float(pose[1]), float(pose[2])
            self._stepped_s = now_s
            output = self._ride.step(mission, self._goal, at, newest, now_s)
        elif mission.goal is None:
            return Output((0, 0), "thinks")
        else:
            output = self._ride.stand(mission, now_s)
        if output.stick is None:
            return output
        return replace(output, shown={**output.shown, "way": _path(mission)})


def _path(mission: Mission) -> list[list[float]]:
    if mission.path_to_goal is None:
        return []
    points = mission.path_to_goal.points_m[:_MOST_POINTS]
    return [[round(float(x), 2), round(float(y), 2)] for x, y in points]
