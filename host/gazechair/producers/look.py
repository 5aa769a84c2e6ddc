"""Kind "look": drives the chair to a floor spot that was looked at in the picture.

The lidars' view from the standing chair serves as the map, in odometry's frame, with the no-go
areas of the stored map that the chair is known to be in. The path is planned before the press, so
that the pages can show it.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between, compose, from_frame, to_frame
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.costmap import Costmap, costmap_of
from gazechair.going.look import UNSEEN, goal, seen_from_here
from gazechair.going.mission import POSE_LOST, Mission
from gazechair.going.plan import NoPath, Path, Planner, Pose
from gazechair.picture.floor import FloorCamera, NoSpot, gaze_px
from gazechair.picture.floor_store import FloorStore
from gazechair.picture.newest import Shot
from gazechair.picture.pixels import size_px
from gazechair.producers.contract import (
    CHANGED,
    KEPT_S,
    UNCALIBRATED,
    Ask,
    MotionState,
    Output,
    Press,
    Sensed,
    Setup,
    SpotProducer,
)
from gazechair.producers.moved_by_others import MovedByOthers
from gazechair.producers.odometry_track import OdometryTrack
from gazechair.producers.over_picture import over_picture, spot_over_picture
from gazechair.producers.pose_watch import KNOWN, LOST, PoseWatch
from gazechair.producers.ride import SCAN_S, Ride
from gazechair.producers.track import MapTrack
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.stored.places import Area
from gazechair.sensing.mapping.stored.store import MapStore

# Reasons, keys of the string tables.
NO_PICTURE, NO_PLACE, NOT_NOW = "look_no_picture", "look_no_place", "look_not_now"
UNSEEN_BEHIND = "look_unseen_behind"
_GAZE_DEG, _TABLET_M = 1.0, 0.29  # of one sample of a gaze, on a tablet that wide
_DWELL = 0.5  # fraction of it left in the mean over a dwell
_SCANS = 3  # of a standing chair
_CHOOSES_S = 4.0  # longest wait for a standing chair, scans and a picture
_AREAS_S = 0.25  # from one look at the stored map to the next


class LookProducer(SpotProducer):
    """Drives to one spot after another."""

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self._floor = FloorStore(setup.state)
        self._track = OdometryTrack()
        self._map_track = MapTrack()
        self._map = ""  # the map that the chair was last known to be in
        self._store = MapStore(setup.maps)
        self._areas_s = -math.inf
        self._avoided: tuple[Area, ...] = ()  # by the path of `_found`
        self._ride = Ride(setup.thinker)
        self._ask: Ask | None = None
        self._camera: FloorCamera | None = None
        self._moved_by_others = MovedByOthers()
        self._watch = PoseWatch()
        self._spot_m = (0.0, 0.0)  # relative to the chair at the look
        self._scans: list[KeyScan] = []
        self._pictured = False
        self._refused = ""
        self._found: tuple[Costmap, Planner, Pose, Path] | None = None
        self._track_of: int | None = None  # the frame of `_found`
        self._mission: Mission | None = None
        self._pressed_s = -math.inf

    def ask(self, ask: Ask) -> None:
        self._ask, self._refused, self._found, self._mission = ask, "", None, None
        self._scans, self._pictured = [], False
        self._moved_by_others.begin(ask.at_s)
        known = self._floor.get()
        if known is None or not ask.may_reverse:
            self._refused = UNCALIBRATED if known is None else UNSEEN_BEHIND
            return
        camera = self._camera = known.camera
        pixel = ask.at[0] * camera.width_px, ask.at[1] * camera.height_px
        sigma_px = _DWELL * gaze_px(_GAZE_DEG, camera.width_px, _TABLET_M)
        spot = camera.spot(pixel, sigma_px, known.sigma_m)
        if isinstance(spot, NoSpot):
            self._refused = spot.reason
        else:
            self._spot_m = spot.x_m, spot.y_m

    def wait(self, sensed: Sensed, now_s: float) -> Output:
        self._take_in(sensed)
        ask = self._ask
        if ask is None:
            return Output(None, "ended")
        if self._found is None and not self._refused:
            self._find(ask, sensed.picture, now_s)
        if self._found is None:
            return Output(None, "ended" if self._refused else "thinks", self._refused)
        since_s = now_s - max(ask.at_s, self._pressed_s)
        newest = self._track.newest
        old = since_s > KEPT_S or newest is None or newest.track != self._track_of
        if old or self._moved_by_others.moved(self._track, now_s):
            return self._over(NOT_NOW)
        if self._redrawn(now_s):
            return self._over(CHANGED)
        return Output(None, "ready", "", self._shown(self._found[3].points_m, now_s))

    def press(self, press: Press) -> None:
        self._mission = None
        self._ride.begin()
        self._watch.begin()
        if self._found is None or self._ask is None or press.target["ask"] != self._ask.number:
            return
        costmap, planner, _, _ = self._found
        numbers, footprint = ChairNumbers.of(press.settings), self.setup.footprint
        self._mission = Mission(costmap, planner, numbers, footprint, self._ride.submit)

    def step(self, sensed: Sensed, now_s: float) -> Output:
        self._take_in(sensed)
        self._pressed_s = now_s
        self._moved_by_others.begin(now_s)
        mission, found, newest = self._mission, self._found, self._track.newest
        if mission is None or found is None:
            return self._over(NOT_NOW)
        if newest is None or newest.track != self._track_of:
            return self._over(POSE_LOST)
        state = self._watch.judge(self._track.seen_s(now_s), self._track, now_s)
        if state == LOST:
            return self._over(POSE_LOST)
        if self._redrawn(now_s):
            return self._over(CHANGED)
        if state == KNOWN:
            pose = newest.pose()
            at = float(pose[0]), float(pose[1]), float(pose[2])
            output = self._ride.step(mission, found[2], at, newest, now_s)
        else:
            output = self._ride.stand(mission, now_s)
        if output.stick is None:
            return self._over(output.reason, output.state)
        path = found[3] if mission.path is None else mission.path
        return replace(output, shown={**output.shown, **self._shown(path.points_m, now_s)})

    def _over(self, reason: str, state: MotionState = "ended") -> Output:
        """End it; continuing needs another look."""
        self._ask = self._found = self._mission = None
        return Output(None, state, reason)

    def _take_in(self, sensed: Sensed) -> None:
        self._ride.take_in(sensed)
        self._track.take(sensed.estimates)
        self._map_track.take(sensed.estimates, sensed.where)
        if sensed.where is not None:
            self._map = sensed.where.map

    def _find(self, ask: Ask, shot: Shot | None, now_s: float) -> None:
        """Plan the path to the spot, once the standing chair has seen enough."""
        late = now_s - ask.at_s > _CHOOSES_S
        newest = self._track.newest
        if newest is None or not self._track.known(now_s):
            self._refused = NO_PLACE if late else ""
            return
        if self._scans and newest.track != self._track_of:
            self._scans = []
        if not self._track.stands:
            self._scans = []
            self._refused = NOT_NOW if late else ""
            return
        self._check(shot, ask.at_s)
        self._scan(ask.at_s)
        if self._refused:
            return
        looked = self._track.pose(ask.at_s)  # the chair may have rolled on since
        if len(self._scans) < _SCANS or not self._pictured or looked is None:
            self._refused = (NO_PLACE if self._pictured else NO_PICTURE) if late else ""
            return
        self._plan(self._scans, looked, now_s)

    def _check(self, shot: Shot | None, since_s: float) -> None:
        """Check that a picture taken since the look has arrived, from the calibrated camera."""
        size = None if shot is None or shot.acquired_s < since_s else size_px(shot.jpeg)
        if size is None or self._camera is None:
            return
        self._pictured = True
        if not self._camera.same_shape(size):
            self._refused = UNCALIBRATED

    def _scan(self, since_s: float) -> None:
        if not self._ride.seen:
            return
        seen = self._ride.looks.seen()
        time_s = seen.estimate.time_s
        newest_s = self._scans[-1].time_s if self._scans else since_s
        if time_s < newest_s + SCAN_S:
            return
        self._track_of = seen.estimate.track
        pose, look = seen.odometry, seen.look
        self._scans.append(
            KeyScan(pose, look.points_m, look.origins_m, float(pose[2]), time_s, 0.0)
        )

    def _plan(self, scans: list[KeyScan], looked: FloatArray, now_s: float) -> None:
        footprint = self.setup.footprint
        try:
            grid = seen_from_here(scans, footprint)
        except ValueError:  # nothing within reach
            self._refused = UNSEEN
            return
        costmap = costmap_of(grid, footprint, self._no_go(now_s))
        x, y, heading = (float(one) for one in scans[-1].pose)
        seen_from = float(looked[0]), float(looked[1]), float(looked[2])
        there = goal(self._spot_m, seen_from, grid, costmap)
        if isinstance(there, NoPath):
            self._refused = there.reason
            return
        planner = Planner(costmap, may_reverse=True)
        path = planner.plan((x, y, heading), there)
        if isinstance(path, NoPath):
            self._refused = path.reason
            return
        self._found = costmap, planner, there, path

    def _no_go(self, now_s: float) -> list[FloatArray]:
        """The no-go areas to avoid from now on, in odometry's frame."""
        self._avoided = self._drawn(now_s) or ()
        newest, in_map = self._map_track.newest, self._map_track.pose(self._map, now_s)
        if newest is None or in_map is None:
            return []
        pose = newest.pose()
        corners = (np.array(area.corners_m) for area in self._avoided)
        return [to_frame(from_frame(one, in_map), pose) for one in corners]

    def _drawn(self, now_s: float) -> tuple[Area, ...] | None:
        """The areas of the map that the chair is in; None: it does not know where it is."""
        if self._map_track.pose(self._map, now_s) is None:
            return None
        stored = self._store.get(self._map)
        return () if stored is None or stored.map is None else stored.map.drawn.no_go

    def _redrawn(self, now_s: float) -> bool:
        """Whether the areas, as far as the chair knows, are not those that the path avoids."""
        if now_s < self._areas_s + _AREAS_S:
            return False
        self._areas_s = now_s
        drawn = self._drawn(now_s)
        return drawn is not None and drawn != self._avoided

    def _shown(self, way_m: FloatArray, now_s: float) -> dict[str, Any]:
        """The path over the picture, and in the map if the chair is in one."""
        newest = self._track.newest
        if newest is None or self._camera is None or self._found is None:
            return {}
        pose = newest.pose()
        there = np.array((self._found[2][:2],))
        shown: dict[str, Any] = {
            "px": over_picture(self._camera, way_m, pose),
            "at": spot_over_picture(self._camera, there[0], pose),
        }
        in_map = self._map_track.pose(self._map, now_s) if self._map else None
        if in_map is not None:
            frame = compose(in_map, between(pose, np.zeros(3)))
            shown["way"] = np.round(to_frame(way_m[:40], frame), 2).tolist()
            x_m, y_m = np.round(to_frame(there, frame), 2)[0].tolist()
            shown["goal"] = {"map": self._map, "x": x_m, "y": y_m}
        return shown
