"""Measures following a person: walks with people who get between, judged by the simulator.

The judge knows where everybody is. Errors: following anything 0.5 m or more off the leader for a
quarter of a second, and any request later than 0.5 s after the last beam that hit the leader. Half
of the walks know a map, half only odometry; in half of them people have gaits that were not used in
development.
"""

from __future__ import annotations

import math
import random
import time
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.following.follower import Followed, PersonFollower
from gazechair.following.legs import Scan
from gazechair.following.person import State
from gazechair.following.request import STOP, Request
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazemeasure.go.person_chair import ROOM_M, Chair
from gazemeasure.go.person_walk import STEP_S, Walk
from gazemeasure.home.localization import mapped
from gazemeasure.report import Report, percentile
from gazesim import home_plans, rays
from gazesim.home_drive import FRONT, LIDAR_HEIGHT_M
from gazesim.home_routes import Pose, Router
from gazesim.homes import Home
from gazesim.lidar_noise import MISSING, NOISE_M
from gazesim.thinker import Thinker

_WALKS, _WALKS_QUICK = 100, 6
_SECONDS, _SECONDS_QUICK = 45.0, 25.0
_SCAN_S = 0.1
_PER_TURN = 1440
_OFF_M, _OFF_S = 0.5, 0.25
_LOST_S = 0.5
_POSE_M, _POSE_RAD, _DRIFT = 0.008, math.radians(0.15), 0.01
_TURNS_DEG_S = 25.0  # turn rate of the driver towards the leader
_HELP_S, _HELP_M = 8.0, 2.7
_LOOK_DEG = 2.5  # error of a look


@dataclass
class Judged:
    """The result of one walk, by the truth."""

    swaps: int = 0
    things: int = 0
    """How often it followed an object."""
    wrong_choices: int = 0
    choices: int = 0
    late_s: float = 0.0
    """The longest time from the last view of the leader to the end of a request."""
    stands_s: float = 0.0
    """The longest time from the last view of the leader until the chair stood."""
    ends: Counter[str] = field(default_factory=Counter)
    back: int = 0
    hidden: int = 0
    followed_s: float = 0.0
    sought_s: float = 0.0
    gaps_m: list[float] = field(default_factory=list)
    spent_ms: list[float] = field(default_factory=list)
    plans_ms: list[float] = field(default_factory=list)
    blocked_s: float = 0.0
    narrow_s: float = 0.0
    """How long it stood because it found no path on which the chair fits."""
    moved_m: float = 0.0
    done: bool = False
    helped: int = 0


def walk(
    home: Home, router: Router, seed: int, foreign: bool, grid: OccupancyGrid | None, seconds: float
) -> Judged:
    """One walk with its judge."""
    return _Run(home, router, seed, foreign, grid).through(seconds)


class _Run:
    def __init__(
        self, home: Home, router: Router, seed: int, foreign: bool, grid: OccupancyGrid | None
    ) -> None:
        self._home = home
        self._walk = Walk(home, router, seed, foreign)
        chance = random.Random(f"chair {home.name} {seed}")
        self._random = np.random.default_rng(chance.randrange(1 << 30))
        leader = self._walk.leader
        begin = self._walk.start
        heading = math.degrees(math.atan2(leader.y_m - begin.y_m, leader.x_m - begin.x_m))
        self._chair = Chair(Pose(begin.x_m, begin.y_m, heading), chance)
        self._judged = Judged()
        self._at_s = 0.0
        thinker = Thinker(lambda: self._at_s)
        self._submit, self._judged.plans_ms = thinker.submit, thinker.spent_ms
        self._follower = PersonFollower(grid, submit=self._submit)
        self._drift = np.zeros(3)
        self._drifts = grid is None
        self._by_look = chance.random() < 0.4
        self._chosen = False
        self._sought_s = 0.0
        self._grid = grid
        self._waited_s = 0.0
        self._plainly = False
        self._off_s = self._unseen_s = 0.0
        self._followed = Followed(State.NOBODY, STOP, None)
        self._before = State.NOBODY

    def through(self, seconds: float) -> Judged:
        judged = self._judged
        for step in range(round(seconds / STEP_S)):
            at_s = step * STEP_S
            if step % round(_SCAN_S / STEP_S) == 0:
                self._look(at_s)
            state = self._followed.state
            follows = state is State.FOLLOWS
            self._chosen = follows or state is State.HIDDEN
            self._walk.step(self._chair.pose, self._plainly, self._chosen)
            request = self._followed.request if self._chosen else self._drive(at_s)
            judged.moved_m += self._chair.step(self._home, request)
            if follows:
                judged.followed_s += STEP_S
                judged.blocked_s += STEP_S * self._chair.blocked
                judged.narrow_s += STEP_S * (not self._followed.fits)
                stuck = self._chair.blocked or not self._followed.fits
                self._sought_s = self._sought_s + STEP_S if stuck else 0.0
            else:
                judged.sought_s += STEP_S
                self._sought_s += STEP_S
            if self._sought_s > _HELP_S:
                self._help()
            if self._walk.done:
                judged.done = True
                break
        return judged

    def _help(self) -> None:
        """The driver drives to behind the leader, where a new follower begins."""
        self._sought_s = 0.0
        walk = self._walk
        for _ in range(20):
            pose = walk.behind()
            true = np.array((pose.x_m, pose.y_m, math.radians(pose.heading_deg)))
            self._scan(true, 0.0)
            far_m = math.dist(true[:2], (walk.leader.x_m, walk.leader.y_m))
            if (
                self._plainly
                and far_m > _HELP_M
                and self._home.clearance_m(pose.x_m, pose.y_m, pose.heading_deg) > ROOM_M
            ):
                self._chair.place(pose)
                self._follower = PersonFollower(self._grid, submit=self._submit)
                self._followed = Followed(State.NOBODY, STOP, None)
                self._judged.helped += 1
                return
            walk.ahead(0.3)

    def _drive(self, at_s: float) -> Request:
        """The driver turns to the leader, and chooses when they stand there."""
        pose, leader = self._chair.pose, self._walk.leader
        dx, dy = leader.x_m - pose.x_m, leader.y_m - pose.y_m
        bearing = math.remainder(math.atan2(dy, dx) - math.radians(pose.heading_deg), 2 * math.pi)
        near = 0.9 < math.hypot(dx, dy) - 0.65 < 1.5
        self._waited_s = self._waited_s + STEP_S if near else 0.0
        if self._followed.state is State.CHOOSING:
            return STOP
        by_look = self._by_look or self._chair.blocked
        if abs(math.degrees(bearing)) > 8.0 and not self._chair.blocked:
            size = min(math.radians(_TURNS_DEG_S), 1.5 * abs(bearing))
            return Request(0.0, math.copysign(size, bearing))
        if near and self._waited_s > 1.0 and self._plainly:
            error = math.radians(self._random.normal(0.0, _LOOK_DEG))
            self._follower.choose(at_s, bearing + error if by_look else None)
            self._followed = Followed(State.CHOOSING, STOP, None)
            self._before = State.CHOOSING
        return STOP

    def _look(self, at_s: float) -> None:
        pose = self._chair.pose
        true = np.array((pose.x_m, pose.y_m, math.radians(pose.heading_deg)))
        scan, seen = self._scan(true, at_s)
        known = self._known(true)
        self._at_s = at_s
        planned_ms = sum(self._judged.plans_ms)
        begin_s = time.process_time()
        self._followed = followed = self._follower.look(scan, known)
        spent_ms = 1000.0 * (time.process_time() - begin_s)
        self._judged.spent_ms.append(spent_ms - (sum(self._judged.plans_ms) - planned_ms))
        self._judge(followed, true, known, seen)

    def _known(self, true: FloatArray) -> FloatArray:
        noise = self._random.normal(0.0, (_POSE_M, _POSE_M, _POSE_RAD))
        if self._drifts and self._chair.moves:
            self._drift += self._random.normal(0.0, (0.002, 0.002, math.radians(0.03)))
        return np.asarray(true + self._drift + noise)

    def _scan(self, true: FloatArray, at_s: float) -> tuple[Scan, bool]:
        """A scan of the lidar, and whether it shows the leader."""
        own = np.arange(-FRONT.half_deg, FRONT.half_deg, 360.0 / _PER_TURN)
        angles = np.radians(own)
        c, s = math.cos(true[2]), math.sin(true[2])
        x, y = true[0] + c * FRONT.x_m, true[1] + s * FRONT.x_m
        metres = self._home.cast(x, y, angles + true[2], LIDAR_HEIGHT_M)
        legs = np.array([leg[:3] for leg in self._walk.leader.legs()])
        here = np.full(len(own), x), np.full(len(own), y)
        to_leader = rays.cast_discs(*here, angles + true[2], legs)
        on_leader = to_leader <= metres + 1e-6
        on_leader &= np.isfinite(metres)
        wanted = max(1, int(np.isfinite(to_leader).sum()))
        self._plainly = int(on_leader.sum()) >= 0.8 * wanted
        kept = np.isfinite(metres) & (self._random.random(len(own)) > MISSING)
        noisy = metres[kept] + self._random.normal(0.0, NOISE_M, int(kept.sum()))
        points = np.stack(
            (FRONT.x_m + noisy * np.cos(angles[kept]), noisy * np.sin(angles[kept])), 1
        )
        return Scan(points, (FRONT.x_m, 0.0), at_s), int(on_leader.sum()) >= 2

    def _judge(self, followed: Followed, true: FloatArray, known: FloatArray, seen: bool) -> None:
        judged, walk = self._judged, self._walk
        leader = (walk.leader.x_m, walk.leader.y_m)
        self._unseen_s = 0.0 if seen else self._unseen_s + _SCAN_S
        if followed.request != STOP:
            # It is in force until the next scan.
            judged.late_s = max(judged.late_s, self._unseen_s + _SCAN_S)
        elif (
            self._unseen_s
            and followed.state is not State.NOBODY
            and self._chair.moves
            and self._chosen
        ):
            judged.stands_s = max(judged.stands_s, self._unseen_s)
        if followed.state is not self._before:
            self._change(followed.state)
        if followed.person_m is None:
            self._off_s = 0.0
            self._before = followed.state
            return
        dx, dy = followed.person_m[0] - known[0], followed.person_m[1] - known[1]
        turn = true[2] - known[2]
        c, s = math.cos(turn), math.sin(turn)
        there = (true[0] + c * dx - s * dy, true[1] + s * dx + c * dy)
        off_m = math.dist(there, leader)
        judged.gaps_m.append(math.dist(leader, true[:2]) - 0.65)
        if self._before is State.CHOOSING:
            judged.choices += 1
            judged.wrong_choices += off_m > _OFF_M or self._nearest_m(there) < off_m
        before_s = self._off_s
        self._off_s = self._off_s + _SCAN_S if off_m > _OFF_M else 0.0
        if before_s < _OFF_S <= self._off_s:
            if self._nearest_m(there) < min(off_m, _OFF_M):
                judged.swaps += 1
            else:
                judged.things += 1
        self._before = followed.state

    def _nearest_m(self, there: tuple[float, float]) -> float:
        """Distance from a point to the nearest person except the leader, m."""
        others = [one.actor for one in self._walk.others]
        return min(math.dist(there, (one.x_m, one.y_m)) for one in others)

    def _change(self, state: State) -> None:
        judged = self._judged
        if state in (State.LOST, State.UNSURE):
            judged.ends[state.value] += 1
        if state is State.HIDDEN:
            judged.hidden += 1
        if state is State.FOLLOWS and self._before is State.HIDDEN:
            judged.back += 1


def walks(count: int, seconds: float) -> dict[bool, list[Judged]]:
    """`count` walks, two in each home; by whether gaits are foreign."""
    found: dict[bool, list[Judged]] = {False: [], True: []}
    for number in range(count):
        seed = number // 2
        if number % 2 == 0:
            home = home_plans.home(seed)
            home.people, home.script = (), ()
            router = Router(home)
            grid = mapped(home, np.random.default_rng(seed)) if seed % 2 else None
        foreign = bool(number % 2)
        found[foreign].append(walk(home, router, number, foreign, grid, seconds))
    return found


def measure(quick: bool) -> Report:
    """Run everything; see Report."""
    report = Report("go: follow a person")
    add(report, quick)
    return report


def add(report: Report, quick: bool) -> None:
    """Add the rows."""
    count = _WALKS_QUICK if quick else _WALKS
    done = walks(count, _SECONDS_QUICK if quick else _SECONDS)
    for foreign, name in ((False, "person, the simulator's gait"), (True, "person, foreign gaits")):
        rows = done[foreign]
        sum_s = sum(one.followed_s for one in rows)
        report.add(f"{name}: silent swaps", sum(o.swaps for o in rows), f"in {len(rows)}", 0.0)
        report.add("  things followed", sum(o.things for o in rows), "", 0.0)
        chosen = sum(o.choices for o in rows)
        report.add("  wrong choices", sum(o.wrong_choices for o in rows), f"of {chosen}", 0.0)
        report.add("  request after last seen, most", max(o.late_s for o in rows), "s", _LOST_S)
        report.add("  chair stands after last seen, most", max(o.stands_s for o in rows), "s")
        share = sum_s / (sum_s + sum(o.sought_s for o in rows))
        report.add("  follows", 100.0 * share, "% of time")
        for state in (State.LOST, State.UNSURE):
            ends = sum(o.ends[state.value] for o in rows)
            report.add(f"  {state.value}, a minute of following", 60.0 * ends / sum_s, "")
        report.add(
            "  found again by itself",
            sum(o.back for o in rows),
            f"of {sum(o.hidden for o in rows)}",
        )
        gaps = [gap for one in rows for gap in one.gaps_m]
        report.add("  gap to the leader, median", percentile(gaps, 0.5), "m")
        report.add(
            "  blocked by the board", 100.0 * sum(o.blocked_s for o in rows) / sum_s, "% of time"
        )
        narrow_s = sum(o.narrow_s for o in rows)
        report.add("  stands, as it fits nowhere", 100.0 * narrow_s / sum_s, "% of time")
        report.add("  driven", sum(o.moved_m for o in rows), "m")
    spent = [ms for rows in done.values() for one in rows for ms in one.spent_ms]
    report.add("person: a scan costs, median", percentile(spent, 0.5), "ms", 5.0)
    report.add("  95 %", percentile(spent, 0.95), "ms")
    plans = [ms for rows in done.values() for one in rows for ms in one.plans_ms]
    if plans:
        report.add("person: a plan costs, median", percentile(plans, 0.5), f"ms, of {len(plans)}")
        report.add("  95 %", percentile(plans, 0.95), "ms")
