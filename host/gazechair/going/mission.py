"""A mission: takes the chair to a place, whatever happens on the way. Pure, time injected.

Every 50 ms it takes the board's output, the pose and the lidars' returns, and gives the stick's
position. `submit` runs the planner, usually on a thread: until a plan is ready, the chair stands,
or drives on along its present path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from gazechair.base.arrays import FloatArray
from gazechair.base.at_once import at_once
from gazechair.base.footprint import Footprint
from gazechair.going.ahead import Ahead, look_ahead
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.costmap import Costmap
from gazechair.going.follow import STOP, Follower, Stick
from gazechair.going.obstacle_layer import ObstacleLayer
from gazechair.going.people import speed_within
from gazechair.going.plan import ARRIVED_M, NO_WAY, NoPath, Path, Planner, Pose
from gazechair.going.planning import Planned, Planning, Submit
from gazechair.going.recovery import END_LEG, GIVE_UP, PLAN, Recovery, Verdict
from gazechair.going.rolled import POSE_OLD_S, Located, Rolled
from gazechair.going.rolls_into import Rolling, rolled_into, turns_at_stop, turns_rolling
from gazechair.going.smooth import refused_s
from gazechair.going.steering import NARROW_M

# States.
IDLE, PLANNING, DRIVING, WAITING, BLOCKED = "idle", "planning", "driving", "waiting", "blocked"
ARRIVED, LOST = "arrived", "lost"
# Reasons, keys of the string tables; the planner's and recovery.py's are others.
POSE_LOST, LIMIT = "going_pose_lost", "going_limit"

_CHECK_S = 0.3
_AGAIN_S = 2.0
_RETRY_S = 2.5
_MAY_OPEN_S = 7.0  # no plan leads past an obstacle: approach it, and wait this long
_STAND_OFF_M = 0.8
_DETOUR_S = 20.0
_BETTER_S = 3.0
_LATER_S, _LATER = 1.5, 2  # a better path for which it must stop is looked for again, so often
_SAME_WAY_RAD = math.radians(6.0)
_NEARER = 2
_JUMP_M, _JUMP_RAD = 0.30, math.radians(15.0)


@dataclass
class Mission:
    """One chair in one map."""

    costmap: Costmap
    planner: Planner
    numbers: ChairNumbers
    footprint: Footprint
    submit: Submit = at_once
    state: str = IDLE
    reason: str = ""
    goal: Pose | tuple[float, float] | None = None
    path: Path | None = None
    plans: int = 0
    cap_permille: int = 1000
    """The speed cap: the highest output of each axis."""
    _located: Located | None = None
    rolled: Rolled = field(default_factory=Rolled)
    """Tells whether it has moved, unlike the pose in the map."""
    _checked_s: float = -math.inf
    _hit_since_s: float | None = None
    _shut_since_s: float | None = None
    """Since when no plan has led past the obstacle ahead; None: nothing shuts the path."""
    _path_to: Pose | tuple[float, float] | None = None
    """Goal of the path that it follows."""
    _gave_up_s: float = 0.0
    _went_round_s: float = -math.inf
    _wants_plan: bool = False
    _hurries: bool = False
    """Another goal on the way: the first path found is taken, and then a better one looked for."""
    _improves: bool = False
    """The plan is made for a better path than the present one to the same goal."""
    _improves_at_s: float = math.inf
    """When to look again for a better path; `_later`: how often it has been put off."""
    _later: int = 0
    _ahead: Ahead = field(default_factory=Ahead)
    _free_m: float = math.inf
    _nearer: int = 0
    """Plans made because a path had ended too far from the goal."""

    def __post_init__(self) -> None:
        self._planning = Planning(lambda job: self.submit(job))
        self._follower = Follower(self.numbers)
        self._obstacles = ObstacleLayer(self.costmap, self.footprint)
        self._recovery = Recovery(self.costmap, self._obstacles, self._follower, self.rolled)

    # -- what people ask ---------------------------------------------------------------------------

    def go(self, goal: Pose | tuple[float, float]) -> None:
        """Set the goal, at any time; the chair follows its old path until the new one is ready."""
        self.goal = goal
        self._nearer = self._later = 0
        self._recovery.begin()
        self._hit_since_s, self._shut_since_s, self._went_round_s = None, None, -math.inf
        self._planning.abandon()
        self._follower.press()
        self._hurries = self.state == DRIVING
        self._ask_plan(self._hurries)

    def abandon(self) -> None:
        """Nobody waits for its plan any more: another mission begins."""
        self._planning.abandon()

    @property
    def turns_on_spot(self) -> bool:
        """Whether it turns on the spot now."""
        return self.state == DRIVING and self._follower.turns_on_spot

    @property
    def path_to_goal(self) -> Path | None:
        """Its path; None while it follows only the path to the goal before, or none."""
        return self.path if self._path_to == self.goal else None

    @property
    def left_m(self) -> float:
        """Remaining length of the path."""
        return 0.0 if self._located is None else self._follower.left_m(self._located.pose)

    # -- what is measured --------------------------------------------------------------------------

    def locate(self, located: Located | None) -> None:
        """Where the chair is; None: not known."""
        before, self._located = self._located, located
        if before is None or located is None:
            return
        dt = located.time_s - before.time_s
        self.rolled.on(located.speed_m_s, located.rate_deg_s, dt)
        if self.state != DRIVING:
            return
        jumped_m = math.dist(located.pose[:2], before.pose[:2]) - abs(before.speed_m_s) * dt
        turned = math.remainder(located.pose[2] - before.pose[2], 2.0 * math.pi)
        turned -= math.radians(before.rate_deg_s) * dt
        if jumped_m > _JUMP_M or abs(turned) > _JUMP_RAD:
            self._ask_plan()  # the pose before was wrong

    def scan(self, points_m: FloatArray, origins_m: FloatArray, at_s: float, pose: Pose) -> None:
        """Take in one lidar rotation: ends and origins of its beams (N, 2), in the chair's frame.

        `pose`: the chair's at that time, in the map.
        """
        if self._located is not None:
            self._obstacles.scan(points_m, origins_m, at_s, pose)

    # -- each period -------------------------------------------------------------------------------

    def step(self, now_s: float, put_out: Stick) -> Stick:
        """The stick for the next 50 ms. `put_out`: what the board has put out since."""
        at = self._located
        moves = (None, None) if at is None else (at.speed_m_s, at.rate_deg_s, now_s - at.time_s)
        self._follower.moved(put_out, *moves)
        self._recovery.put_out(put_out)
        self._recovery.requested = self._step(now_s, put_out)
        return self._recovery.requested

    def _step(self, now_s: float, put_out: Stick) -> Stick:
        at = self._located
        if self.goal is None or self.state == ARRIVED:
            return STOP
        if at is None or now_s - at.time_s > POSE_OLD_S:
            self.state, self.reason = LOST, POSE_LOST
            return STOP
        if self.state == LOST:
            self.state, self.reason = DRIVING, ""
            self._recovery.moves()
            if self._path_to != self.goal or self._planning.busy:
                self._ask_plan()
        if not self.numbers.drives_within(self.cap_permille):
            self._give_up(LIMIT, now_s)
            return STOP
        pose = at.pose_at(now_s)
        waited = not self._planning.busy and now_s - self._gave_up_s > _RETRY_S
        if self.state == BLOCKED and waited:
            self._wants_plan = True
        self._plan(pose, now_s)
        if self.state in (BLOCKED, PLANNING):
            return STOP
        self._look_ahead(pose, now_s)
        most_m_s = speed_within(self._free_m)
        stick = self._follower.step(pose, most_m_s, self._ahead.room_m, self._ahead.straight_m)
        waits = self._free_m < 0.3
        if self._planning.busy or self._wants_plan:
            if not (self._follower.arrived or self._follower.lost_path):
                verdict = self._recovery.meanwhile(at.pose, stick, put_out, waits, now_s)
                return self._obey(verdict, at.pose, now_s)
            if self._path_to != self.goal:  # the path to the goal before has ended
                self.state, self.reason = PLANNING, ""
            return STOP
        if self._follower.arrived:
            if self._nearer < _NEARER and self._gap_m(pose) > ARRIVED_M:
                self._nearer += 1
                self._ask_plan()
                return STOP
            self.state, self.reason = ARRIVED, ""
            return STOP
        if self._follower.lost_path:
            self._ask_plan()
            return STOP
        stick = STOP if self._follower.turns_on_spot and self._free_m < 0.05 else stick
        verdict = self._recovery.step(self.planner, at.pose, stick, put_out, waits, now_s)
        return self._obey(verdict, at.pose, now_s)

    def _gap_m(self, pose: Pose) -> float:
        assert self.goal is not None
        return math.hypot(self.goal[0] - pose[0], self.goal[1] - pose[1])

    def _ask_plan(self, drives_on: bool = False) -> None:
        self._wants_plan, self._improves, self._improves_at_s = True, False, math.inf
        if not drives_on:
            self._planning.abandon()  # it begins where the chair was, or was believed to be
            self.state, self.reason = PLANNING, ""

    def _plan(self, pose: Pose, now_s: float) -> None:
        """Ask for a plan, or take the one that is ready."""
        if now_s >= self._improves_at_s and self.state == DRIVING and not self._planning.busy:
            self._ask_plan(drives_on=True)
            self._improves = True
        if self._wants_plan and not self._planning.busy:
            assert self.goal is not None
            self._wants_plan = False
            self.plans += 1
            self.costmap.refresh(now_s)
            self._obstacles.suspect()
            start = self._follower.rests(pose) if self.state == PLANNING else pose
            goal, refused, hurry = self.goal, self._recovery.refused.all, self._hurries
            self._planning.begin(lambda over: self.planner.plan(start, goal, refused, hurry, over))
        found = self._planning.take()
        if found is None:
            return
        hurried, self._hurries = self._hurries, False
        improves, self._improves = self._improves, False
        if improves and not self._is_better(found):
            return
        hit, self._hit_since_s = self._hit_since_s is not None, None
        if self._may_open(found, hit, now_s):
            return
        if isinstance(found, NoPath):
            self._give_up(found.reason, now_s)
            return
        self._shut_since_s = None
        if not hit and self._waits_here_anyway(found, pose):
            return
        if hurried or improves:
            puts_off = improves and self._later < _LATER
            joined = self._join(found, pose, hurried, puts_off)
            if joined is None and hurried:
                self._ask_plan()  # without hurry, from where it stops
            if joined is None and puts_off:
                self._later += 1
                self._improves_at_s = now_s + _LATER_S
            if joined is None:
                return
            found = joined
        else:
            self._follower.take(found, pose)
        self.path, self._path_to = found, self.goal
        self._recovery.another_path()
        if self.state != WAITING:
            self.state, self.reason = DRIVING, ""
        if hurried and not self._wants_plan:
            self._wants_plan = self._improves = True

    def _join(self, found: Path, pose: Pose, hurried: bool, puts_off: bool) -> Path | None:
        """Follow a path that was found while the chair drove; None: it cannot, or not now.

        `puts_off`: nor is it followed if the chair must stop for it.
        """
        rolling = self._follower.rolling(pose)
        if hurried and rolling is None and self._turns_in_vain(found, pose):
            return None
        self._checked_s = -math.inf  # whoever walks there was not in the path before
        if rolling is not None:
            return self._roll_into(found, pose, rolling, puts_off)
        self._follower.take(found, pose)
        return found

    def _turns_in_vain(self, found: Path, pose: Pose) -> bool:
        """Whether a chair that stands would begin with a turn that the board refuses."""
        aim_rad = found.aim_rad(0, pose)
        if aim_rad is None:
            return False
        turns = abs(math.remainder(aim_rad - pose[2], 2.0 * math.pi)) > _SAME_WAY_RAD
        return turns and not self.planner.turns_freely(pose, aim_rad)

    def _roll_into(self, found: Path, pose: Pose, rolling: Rolling, puts_off: bool) -> Path | None:
        """Follow the path, bent into where the chair rolls; None: a turn to it has no room."""
        turns = turns_rolling(self.costmap, found, rolling)
        found = rolled_into(self.costmap, found, rolling) or found
        ahead = look_ahead(self.costmap, self._obstacles.people, self.footprint, found, 0, pose)
        steers = ahead.room_m > NARROW_M
        goes_on = turns or self._follower.leads_on(found, pose, steers)
        if not goes_on and (puts_off or not turns_at_stop(self.costmap, found, rolling)):
            return None
        self._follower.take(found, pose, steers, turns)
        return found

    def _is_better(self, found: Planned) -> bool:
        """Whether it is worth leaving the present path, which leads to the same goal, for it."""
        if isinstance(found, NoPath) or self.path is None:
            return False
        driven_s = self._later * _LATER_S  # since the present path was planned
        return found.cost_s < self.path.cost_s - driven_s - _BETTER_S

    def _may_open(self, found: Planned, hit: bool, now_s: float) -> bool:
        """Whether to wait for the path to open: there is no other one, or only a long detour."""
        if self.path is None or self.state not in (DRIVING, WAITING) or self._path_to != self.goal:
            return False
        if isinstance(found, NoPath):
            shut = found.reason == NO_WAY
        else:
            shut = hit and found.cost_s > self.path.cost_s + _DETOUR_S
        if not shut:
            return False
        if self._shut_since_s is None:
            self._shut_since_s = now_s
        return now_s - self._shut_since_s < _MAY_OPEN_S

    def _waits_here_anyway(self, found: Path, pose: Pose) -> bool:
        """Whether to wait before a possible person: the new path begins like the refused one.

        Aiming anew would restart the board's ten seconds of standing. It may help once they were
        in vain, and where the board refuses for another reason.
        """
        if self.state != WAITING or self._path_to != self.goal or self._follower.turns_on_spot:
            return False
        if not self._recovery.refused.may_pass or not self._recovery.may_be_person(pose):
            return False
        a, b = found.points_m[:2]
        heading = math.atan2(b[1] - a[1], b[0] - a[0])
        turns_rad = math.remainder(heading - pose[2], 2.0 * math.pi)
        no_other = abs(turns_rad) < _SAME_WAY_RAD and not found.backward
        return no_other and refused_s(self._recovery.refused.all, a, heading) > 0.0

    def _give_up(self, reason: str, now_s: float) -> None:
        self.state, self.reason, self._gave_up_s = BLOCKED, reason, now_s
        self._recovery.forget()
        self._shut_since_s = self._path_to = None
        self._follower.drop()

    def _look_ahead(self, pose: Pose, now_s: float) -> None:
        """Update the clearances, the distance free of walkers, and whether the path is blocked."""
        if now_s - self._checked_s < _CHECK_S or self.path is None:
            return
        self._checked_s = now_s
        self.costmap.refresh(now_s)
        leg, people = self._follower.leg, self._obstacles.people
        self._ahead = look_ahead(self.costmap, people, self.footprint, self.path, leg, pose)
        self._free_m, hit_m = self._ahead.free_m, self._ahead.hit_m
        if self._shut_since_s is not None:
            self._wait_before(hit_m, pose)
        if math.isinf(hit_m):
            self._hit_since_s = None
        elif self._hit_since_s is None:
            self._hit_since_s = now_s
        elif (
            now_s - self._hit_since_s > self._recovery.round_after_s(pose)
            and now_s - self._went_round_s > _AGAIN_S
        ):
            self._went_round_s = now_s
            self._ask_plan(drives_on=True)

    def _wait_before(self, shut_m: float, pose: Pose) -> None:
        """Stop before the obstacle `shut_m` ahead, with a reason; inf: the path is open again."""
        if math.isinf(shut_m):
            self._shut_since_s = None
            self.state, self.reason = DRIVING, ""
            return
        self._free_m = min(self._free_m, shut_m - _STAND_OFF_M)
        self.state, self.reason = WAITING, self._recovery.in_the_way(pose)

    def _obey(self, verdict: Verdict, pose: Pose, now_s: float) -> Stick:
        """Do what comes of requests in vain."""
        if verdict.act == GIVE_UP:
            assert verdict.reason is not None
            self._give_up(verdict.reason, now_s)
            return verdict.stick
        if verdict.reason:
            self.state, self.reason = WAITING, verdict.reason
        elif verdict.reason is not None and self.state == WAITING and self._shut_since_s is None:
            self.state, self.reason = DRIVING, ""
        if verdict.act == END_LEG:
            self.path = self._follower.end_leg_early(pose)
        elif verdict.act == PLAN:
            self._ask_plan(drives_on=True)
        return verdict.stick
