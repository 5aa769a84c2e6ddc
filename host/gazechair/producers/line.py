"""Kind "line": follows the line on the floor that was chosen in the picture, up to its end.

Every picture is searched for the line from the choice on, so the pages show before the press what
would be followed. After 0.3 s without a picture or the line the request is zero.
"""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import from_frame, to_frame
from gazechair.following.line import GONE_S, LineFollower, State
from gazechair.following.line_view import NOT_SEEN, Picture
from gazechair.following.request import STOP, Request
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.mission import LIMIT
from gazechair.picture.floor import FloorCamera
from gazechair.picture.floor_store import FloorStore
from gazechair.picture.newest import Shot
from gazechair.picture.pixels import pixels, size_px
from gazechair.producers import pose_watch
from gazechair.producers.contract import (
    KEPT_S,
    STEP_S,
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
from gazechair.producers.over_picture import over_picture
from gazechair.producers.pose_watch import PoseWatch

# Reasons, keys of the string tables.
NO_PICTURE, NO_PLACE, UNSEEN_BEHIND = "line_no_picture", "line_no_place", "line_unseen_behind"
LOST, NOT_NOW = "line_lost", "line_not_now"
WIDTH_PX = 160
"""Of the pictures that it searches."""
_CHOOSES_S = 3.0  # longest wait for a picture of a standing chair
_OLD_S = 1.0  # maximum age of a picture


class LineProducer(SpotProducer):
    """Follows one line after another."""

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self._front_m = float(setup.footprint.body[:, 0].max())
        self._floor = FloorStore(setup.state)
        self._track = OdometryTrack()
        self._ask: Ask | None = None
        self._camera: FloorCamera | None = None
        self._follower: LineFollower | None = None
        self._track_of: int | None = None  # the frame that the line is in
        self._pressed_s = self._placed_s = -math.inf
        self._requested_s = -math.inf  # last requested motion
        self._moved_by_others = MovedByOthers()
        self._watch = PoseWatch()
        self._refused = ""

    def ask(self, ask: Ask) -> None:
        self._ask, self._follower, self._refused = ask, None, ""
        self._moved_by_others.begin(ask.at_s)
        known = self._floor.get()
        if known is None or not ask.may_reverse:
            self._refused = UNCALIBRATED if known is None else UNSEEN_BEHIND
            return
        self._camera = known.camera.scaled(WIDTH_PX)

    def wait(self, sensed: Sensed, now_s: float) -> Output:
        self._track.take(sensed.estimates)
        ask = self._ask
        if ask is None:
            return Output(None, "ended")
        if self._follower is None and not self._refused:
            self._choose(ask, sensed.picture, now_s)
        if self._follower is None:
            return Output(None, "ended" if self._refused else "thinks", self._refused)
        reason = self._look(sensed.picture, now_s)
        since_s = now_s - max(ask.at_s, self._pressed_s)
        if not reason and (since_s > KEPT_S or self._moved_by_others.moved(self._track, now_s)):
            reason = NOT_NOW
        if reason:
            return self._over(reason)
        pose = self._track.pose(now_s)
        if pose is not None:
            self._follower.rest(pose, now_s)
        return Output(None, "ready", "", self._shown(pose))

    def press(self, press: Press) -> None:
        self._numbers = ChairNumbers.of(press.settings)
        self._pressed_s = self._requested_s = press.at_s
        self._watch.begin()
        if self._ask is None or press.target["ask"] != self._ask.number:
            self._over(LOST)

    def step(self, sensed: Sensed, now_s: float) -> Output:
        self._track.take(sensed.estimates)
        self._pressed_s = now_s
        self._moved_by_others.begin(now_s)
        follower = self._follower
        reason = LOST if follower is None else self._look(sensed.picture, now_s)
        if follower is None or reason:
            return self._over(reason)
        pose, newest = self._track.pose(now_s), self._track.newest
        seen_s = None if pose is None else self._track.seen_s(now_s)
        state = self._watch.judge(seen_s, self._track, now_s)
        if state == pose_watch.LOST:
            return self._over(NO_PLACE)
        if newest is None or pose is None or state != pose_watch.KNOWN:
            if newest is not None:
                follower.rest(newest.pose(), now_s)
            self._requested_s = now_s
            return Output((0, 0), "waits", NO_PLACE)
        if not self._numbers.rolls_within(sensed.cap_permille):
            follower.rest(pose, now_s)
            self._requested_s = now_s
            return Output((0, 0), "waits", LIMIT, self._shown(pose))
        moves = newest.speed_m_s, math.radians(newest.yaw_rate_deg_s)
        request = follower.step(pose, *moves, now_s, STEP_S)
        if follower.state is State.ENDED:
            return self._over("", "arrived")
        self._requested_s = self._requested_s if request == STOP else now_s
        if follower.state is State.LOST or now_s - self._requested_s > GONE_S:
            return self._over(LOST)
        shown = self._shown(pose)
        if request == STOP:
            return Output((0, 0), "waits", "line_hidden", shown)
        if not self._numbers.moves_within(
            request.linear_m_s, request.yaw_rad_s, sensed.cap_permille
        ):
            return Output((0, 0), "waits", LIMIT, shown)
        return Output(self._stick(request), "drives", "line_follows", shown)

    def _over(self, reason: str, state: MotionState = "ended") -> Output:
        """End it; continuing needs a new choice."""
        self._ask = self._follower = None
        return Output(None, state, reason)

    def _choose(self, ask: Ask, shot: Shot | None, now_s: float) -> None:
        """Choose the line in the first picture after the look, while the chair stands."""
        late = now_s - ask.at_s > _CHOOSES_S
        newest = self._track.newest
        if newest is None or not self._track.known(now_s):
            self._refused = NO_PLACE if late else ""
            return
        looked, stands = self._track.pose(ask.at_s), self._track.stands
        new = shot if shot is not None and shot.acquired_s >= ask.at_s and stands else None
        pose = None if new is None else self._track.pose(new.acquired_s)
        picture = None if new is None else self._pixels(new)
        if self._refused:
            return
        if new is None or pose is None or picture is None or looked is None:
            self._refused = (NO_PICTURE if stands else NOT_NOW) if late else ""
            return
        assert self._camera is not None
        numbers, camera = ChairNumbers.of(ask.settings), self._camera
        most_rad_s = math.radians(min(numbers.left_deg_s, numbers.right_deg_s))
        delay_s = numbers.dead_s + numbers.lag_s
        try:
            follower = LineFollower(camera, numbers.most_m_s, most_rad_s, delay_s, self._front_m)
        except ValueError:
            self._refused = NOT_SEEN  # this camera shows no floor ahead
            return
        # The chair may have rolled on since the look.
        pixel = np.array(((ask.at[0] * camera.width_px, ask.at[1] * camera.height_px),))
        spot = from_frame(to_frame(camera.floor_m(pixel), looked), pose)
        u, v = (float(one) for one in camera.pixels(spot)[0])
        self._refused = follower.choose(picture, (u, v), pose, new.acquired_s)
        if not self._refused:
            self._follower, self._track_of, self._placed_s = follower, newest.track, now_s

    def _look(self, shot: Shot | None, now_s: float) -> str:
        """Process a new picture; returns why the line is over, "" while it is not."""
        follower, newest = self._follower, self._track.newest
        assert follower is not None
        if follower.state is not State.FOLLOWS:
            return LOST
        if newest is None or newest.track != self._track_of:
            return NO_PLACE
        if self._track.known(now_s):
            self._placed_s = now_s
        elif now_s - self._placed_s > GONE_S:
            return NO_PLACE
        if shot is not None and now_s - shot.acquired_s <= _OLD_S:
            pose, picture = self._track.pose(shot.acquired_s), self._pixels(shot)
            if self._refused:
                return self._refused
            if pose is not None and picture is not None:
                follower.look(picture, pose, shot.acquired_s)
        return ""

    def _pixels(self, shot: Shot) -> Picture | None:
        """As the camera that was calibrated; None: not decodable, or refused as another one's."""
        camera, size = self._camera, size_px(shot.jpeg)
        if camera is None or size is None:
            return None
        if not camera.same_shape(size):
            self._refused = UNCALIBRATED
            return None
        return pixels(shot.jpeg, (camera.width_px, camera.height_px))

    def _shown(self, pose: FloatArray | None) -> dict[str, list[list[float]]]:
        """The line as drawn over the picture."""
        if pose is None or self._follower is None or self._camera is None:
            return {}
        return {"px": over_picture(self._camera, self._follower.line_m, pose)}

    def _stick(self, request: Request) -> tuple[int, int]:
        numbers = self._numbers
        return (
            numbers.linear_permille(request.linear_m_s),
            numbers.turn_permille(math.degrees(request.yaw_rad_s)),
        )
