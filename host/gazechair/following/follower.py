"""Person follower: takes scans and the chair's poses, returns a state and a request."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.at_once import at_once
from gazechair.base.footprint import Footprint
from gazechair.base.poses import to_frame
from gazechair.following.background import Background
from gazechair.following.fitting import Fitting, Submit
from gazechair.following.legs import Scan, clusters
from gazechair.following.person import Person, State
from gazechair.following.request import STOP, Request
from gazechair.following.tracks import Tracks
from gazechair.following.trail import Trail
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid

_LONGEST_S = 0.2  # between two scans: a longer gap does not permit a larger change


@dataclass(frozen=True)
class Followed:
    """The result of a scan. `person_m`: where the person is, in the frame of the poses."""

    state: State
    request: Request
    person_m: tuple[float, float] | None
    fits: bool = True
    """False: the chair stands, because it fits nowhere along the person's path."""


class PersonFollower:
    """Call `choose`, then `look` with every scan. A request is valid until the next scan is due.

    `grid`: the map, when poses are in its frame; without one, poses are odometry's. A new frame
    needs a new follower. `submit` runs the planner, usually on a thread.
    """

    def __init__(
        self,
        grid: OccupancyGrid | None = None,
        footprint: Footprint | None = None,
        submit: Submit = at_once,
    ) -> None:
        footprint = footprint or Footprint()
        front_m = float(footprint.body[:, 0].max())
        self._background = Background(grid)
        self._tracks = Tracks()
        self._person = Person(front_m, needs_steps=grid is None)
        self._trail = Trail(front_m)
        self._fitting = Fitting(footprint, submit)
        self._at_s: float | None = None
        self._follows = False

    @property
    def state(self) -> State:
        """The state after the last scan."""
        return self._person.state

    def choose(self, at_s: float, bearing_rad: float | None = None) -> None:
        """Choose the person seen at `bearing_rad`; None: the one who stands in front for 2 s."""
        self._person.choose(at_s, bearing_rad)
        self._follows = False

    def stop(self) -> None:
        """Stop following."""
        self._person.stop()
        self._follows = False

    def look(self, scan: Scan, pose: FloatArray) -> Followed:
        """Process a scan; `pose` of the drive axle at that time: x, y, heading in radians."""
        points = to_frame(scan.points_m, pose)
        origin = to_frame(np.array((scan.origin_m,)), pose)[0]
        stands = self._background.stands(points, origin)
        tracks = self._tracks
        seen = clusters(points, origin, ~stands)
        own = self._person.continued(seen)
        legs = [one for one in seen if not one.maybe_wall or one in own]
        tracks.look(legs, scan.at_s, self._person.track, own)
        hidden = self._person.look(tracks.all, tracks.ended, pose, scan.at_s)
        if hidden:
            tracks.forget(hidden)
        people = [
            (one.x_m, one.y_m)
            for one in tracks.all
            if one.walked
            or (one.may_have_walked and one.perhaps_person)
            or (self._background.has_map and one.person_like)
        ]
        self._background.learn(points, origin, people)
        return self._followed(scan.at_s, pose)

    def _followed(self, at_s: float, pose: FloatArray) -> Followed:
        dt_s = 0.0 if self._at_s is None else min(max(at_s - self._at_s, 0.0), _LONGEST_S)
        self._at_s = at_s
        state, track = self._person.state, self._person.track
        if state is not State.FOLLOWS or track is None:
            if state is not State.HIDDEN:
                self._follows = False
            return Followed(state, self._trail.stop(), None)
        if not self._follows:
            self._follows = True
            self._trail.begin(pose)
            self._fitting.begin()
        if not self._person.seen:
            return Followed(state, self._trail.coast(dt_s), None)
        at_m = (track.x_m, track.y_m)
        self._trail.walked(*at_m)
        room = self._fitting.room(self._background.standing_m, self._trail, pose, at_s)
        request = self._trail.request(pose, *at_m, dt_s, room)
        return Followed(state, request, at_m, self._fitting.fits or request != STOP)
