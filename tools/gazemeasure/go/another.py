"""Another goal on the way: how soon the chair truly moves as the new path asks.

The whole chair drives; the goal is changed by a message of the driver's page, and the clock starts
there. Planning takes as long as its own CPU time, a tenth of a second or more.

Two moments are judged by the truth. The chair *responds* when it turns to the side of the new path
or moves along it, or, where it must stop for that, brakes. Braking counts once the
chair is 0.05 m/s slower than a copy of it that goes on with the last output for the old path: what
it would have done anyway is no response. Half a second is the limit for all. It *moves* when it
turns to that side or moves along the path; braking is not motion towards a goal. A quicker path may
replace the first one before that: the newest counts, for its class and limit as well.

A class is what this chair could do, moving as it does at that message, whatever the mission makes
of it: one that rolls could steer into a path that begins ahead within 30 degrees of its heading (a
curve that needs 0.15 m beside it; whether they are free is not asked). To move, half a second is
the limit where the chair does so as asked already, and for such a curve: the chair alone takes
0.4 s, from stick to motion, as gently as it is driven. Elsewhere it alone takes so long (dead time,
ramps, lag) that no plan would be in time: there half a second is added to that.
"""

from __future__ import annotations

import copy
import math
import pathlib
import tempfile
from dataclasses import dataclass

import numpy as np

from gazechair.going.bends import RATE_RAD_S
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.mission import PLANNING
from gazechair.going.pace import ACCELERATE_M_S2, JERK_M_S3, START_M_S2
from gazechair.going.plan import Path, Pose
from gazelink.settings_table import PROFILES, TABLE
from gazemeasure.go import missions, rows, scenes
from gazemeasure.go import record as go_record
from gazemeasure.go.whole import MOVES_DEG_S, MOVES_M_S, Judge, Scene
from gazemeasure.on_record import Job
from gazemeasure.report import Report, percentile
from gazemeasure.turn.board import settings_with
from gazesim import pot
from gazesim.chair import Chair

KIND, COUNT = "another goal", 40
GOES_ON, CURVES = "it moves as asked already", "a curve while it rolls"
TURNS, STARTS = "a turn from rest", "straight on from rest"
STOPS, BACKS = "a turn for which it must stop", "straight on against its motion"
_LIMIT_S = 0.5
_LEAST_ARRIVED = 99.0
_QUICK = 3
_BEFORE = "Eerst"
_DRIVES_MS = 8000
_LATEST_S = 10.0
_ROLLS_M_S, _AHEAD_RAD = 0.12, math.radians(30.0)
_STRAIGHT_RAD = math.radians(5.0)  # a smaller turn is steered while driving
_STEERS_DEG_S = 8.0  # slower, a rolling chair only steers along its leg
_BRAKED_M_S = 0.05
_TICK_S, _SETTLES_S = 0.01, 3.0


@dataclass(frozen=True)
class Redirected(scenes.Done):
    """A mission whose goal was changed. `arrived`: at the second goal."""

    profile: str
    how: str
    """What the new path asked of the chair: one of the classes above; "": it was never known."""
    moves_after_s: float
    responds_after_s: float
    planned_after_s: float
    """From the message until the chair has the new path; inf: never."""
    output_after_s: float
    """From the message until the board's output changes after that; inf: it did not."""

    @property
    def ratio(self) -> float:
        """1: there is no ideal time of a path that begins on another one."""
        return 1.0


def measure(report: Report, quick: bool, processes: int) -> None:
    """Add the rows."""
    jobs = [Job(KIND, seed) for seed in range(_QUICK if quick else COUNT)]
    done = go_record.gather(
        jobs, mission, Redirected.kept, processes, None if quick else go_record.FILE
    )
    add(report, done)


def add(report: Report, done: list[Redirected]) -> None:
    """Add the rows of these missions."""
    rows.add_arrived(report, KIND, [one.driven for one in done], _LEAST_ARRIVED)
    for how in (GOES_ON, CURVES, TURNS, STARTS, STOPS, BACKS, ""):
        of = [one for one in done if one.how == how]
        if of:
            after_s = percentile([one.moves_after_s for one in of], 0.95)
            own_s = max(floor_s(one.profile, how) for one in of)
            unit = f"s, {len(of)} missions; the chair alone {own_s:.2f}"
            limit_s = _LIMIT_S if how in (GOES_ON, CURVES, "") else own_s + _LIMIT_S
            report.add(f"  new motion, 95 %: {how or 'none'}", after_s, unit, limit_s)
    for what, every_s, most_s in (
        ("new motion", [one.moves_after_s for one in done], None),
        ("first response", [one.responds_after_s for one in done], _LIMIT_S),
        ("the new path is known", [one.planned_after_s for one in done], None),
    ):
        report.add(f"  {what}, 95 %: all", percentile(every_s, 0.95), "s", most_s)
    rows.note_failures(report, done)
    for one in done:
        report.note(
            f"{KIND} {one.job.seed}: {one.how or 'none'}; path {one.planned_after_s:.2f}, output "
            f"{one.output_after_s:.2f}, responds {one.responds_after_s:.2f}, moves "
            f"{one.moves_after_s:.2f} s after the message"
        )


def mission(job: Job) -> Redirected:
    """Drive towards one place, choose another on the way, and drive there."""
    number = job.seed // missions.MISSIONS_IN_A_HOME
    home, grid = missions.fenced(number), scenes.mapped_inside(number)
    chance = np.random.default_rng((job.seed, len(KIND)))
    start, goal, before = missions.poses(home, grid, chance, 3, False)
    profile = PROFILES[job.seed % len(PROFILES)]
    with tempfile.TemporaryDirectory(prefix="gazechair-") as folder:
        judge = Another(Scene(home, grid, start, goal, profile), before, pathlib.Path(folder))
        try:
            driven = judge.drive()
        finally:
            judge.chair.close()
    return Redirected(
        job,
        driven,
        profile,
        judge.how,
        judge.moves_after_s,
        judge.responds_after_s,
        judge.planned_after_s,
        judge.output_after_s,
    )


class Another(Judge):
    """Changes the goal after 8 s."""

    def __init__(self, scene: Scene, before: Pose, folder: pathlib.Path) -> None:
        self._before = before
        super().__init__(scene, folder, None)
        self.how = ""
        self.moves_after_s = self.responds_after_s = math.inf
        self.planned_after_s = self.output_after_s = math.inf
        self._goes_on: GoesOn | None = None
        self._first: Pose | tuple[float, float] | None = None
        self._new: Path | None = None
        self._off_rad = 0.0
        self._moved = 0.0, 0.0
        self._wipers = self.chair.world.wipers
        """A millisecond ago: the path may have come, and its first output with it, since."""
        self.acts.append(self._watch)

    def _places(self) -> dict[str, Pose]:
        return {**super()._places(), _BEFORE: self._before}

    def _sets_out(self) -> None:
        chair = self.chair
        chair.page.choose(chair.tiles[_BEFORE])
        self._waits(lambda: False, _DRIVES_MS)
        twin, mission = chair.world.chair, chair.mission
        self._moved = twin.speed_m_s, twin.yaw_rate_deg_s
        self._first = None if mission is None else mission.goal
        super()._sets_out()

    def _watch(self) -> None:
        before, self._wipers = self._wipers, self.chair.world.wipers
        if not self.pressed_ms or self.moves_after_s < math.inf or self.since_s > _LATEST_S:
            return
        mission, twin = self.chair.mission, self.chair.world.chair
        if mission is None or mission.path is None:
            return
        path = mission.path
        known = mission._path_to not in (None, self._first)  # one to the first may come only now
        if self._goes_on is not None:
            self._goes_on.one_ms()
        elif known or mission.state == PLANNING:  # to plan anew from where it stops, it brakes
            self._goes_on = GoesOn(self.chair.world.chair, before)
        if self._goes_on is not None and self._goes_on.faster_m_s(twin) > _BRAKED_M_S:
            self.responds_after_s = min(self.responds_after_s, self.since_s)
        if not known or self._goes_on is None:
            return
        self.planned_after_s = min(self.planned_after_s, self.since_s)
        if path is not self._new:
            self._new, self._off_rad = path, off_rad(path, math.radians(twin.heading_deg))
            self.how = class_of(path, self._off_rad, *self._moved)
        if self.output_after_s == math.inf and self._goes_on.wipers != self._wipers:
            self.output_after_s = self.since_s
        steered = steered_deg_s(*self._moved)
        if obeys(path, self._off_rad, twin.speed_m_s, twin.yaw_rate_deg_s, steered):
            self.moves_after_s = self.since_s
            self.responds_after_s = min(self.responds_after_s, self.since_s)


class GoesOn:
    """A copy of the simulated chair, to which the output for the old path is put out further on."""

    def __init__(self, chair: Chair, wipers: tuple[int, int]) -> None:
        self.wipers = wipers
        self._chair = copy.deepcopy(chair)
        linear, turn = (pot.deflection(one) for one in wipers)
        self._stick = linear, turn

    def one_ms(self) -> None:
        """Advance by a millisecond."""
        self._chair.step(0.001, self._stick)

    def faster_m_s(self, than: Chair) -> float:
        """How much faster it rolls than another chair."""
        return abs(self._chair.speed_m_s) - abs(than.speed_m_s)


def off_rad(path: Path, heading_rad: float) -> float:
    """Angle, left positive, from the chair's heading to the first one of the path as planned."""
    a, b = path.points_m[:2]
    first = math.atan2(b[1] - a[1], b[0] - a[0]) + (math.pi if path.backward else 0.0)
    if math.dist(a, b) < 0.03 and path.heading_rad is not None:
        first = path.heading_rad
    first = first if path.began_rad is None else path.began_rad
    return math.remainder(first - heading_rad, 2.0 * math.pi)


def steered_deg_s(speed_m_s: float, rate_deg_s: float) -> float:
    """Turn rate by which it only steered along its leg at the message."""
    steers = abs(speed_m_s) > MOVES_M_S and abs(rate_deg_s) < _STEERS_DEG_S
    return rate_deg_s if steers else 0.0


def obeys(
    path: Path, off: float, speed_m_s: float, rate_deg_s: float, steered: float = 0.0
) -> bool:
    """Whether the chair truly moves as the path begins: turning to it, or along it.

    Of a turn, what it `steered` at the message in degrees/s does not count.
    """
    if abs(off) > _STRAIGHT_RAD:
        side = math.copysign(1.0, off)
        return side * rate_deg_s > MOVES_DEG_S + max(0.0, side * steered)
    return (-speed_m_s if path.backward else speed_m_s) > MOVES_M_S


def class_of(path: Path, off: float, speed_m_s: float, rate_deg_s: float) -> str:
    """What the path asks of a chair that moves like this."""
    if obeys(path, off, speed_m_s, rate_deg_s, steered_deg_s(speed_m_s, rate_deg_s)):
        return GOES_ON
    if abs(off) <= _STRAIGHT_RAD:
        return BACKS if (speed_m_s if path.backward else -speed_m_s) > _ROLLS_M_S else STARTS
    turns_away = math.copysign(1.0, off) * rate_deg_s < -MOVES_DEG_S
    if speed_m_s > _ROLLS_M_S and abs(off) < _AHEAD_RAD and not (path.backward or turns_away):
        return CURVES
    return STOPS if turns_away or abs(speed_m_s) > _ROLLS_M_S else TURNS


def floor_s(profile: str, how: str) -> float:
    """Seconds of the chair alone from the stick to that motion, as gently as it is driven."""
    if how in (GOES_ON, ""):
        return 0.0
    values = {row[0]: getattr(settings_with({}), row[0]) for row in TABLE}
    full = {"profile": PROFILES.index(profile), "linear_permille": 1000, "turn_permille": 1000}
    numbers = ChairNumbers.of({**values, **full})
    rate = math.degrees(RATE_RAD_S)
    most = numbers.linear_permille(numbers.most_m_s)
    begins = {
        CURVES: (most, numbers.turn_permille(-MOVES_DEG_S)),
        STOPS: (most, numbers.turn_permille(-rate)),
        BACKS: (most, 0),
    }.get(how, (0, 0))
    chair = Chair(profile)
    chair.step(_TICK_S, (0.0, 0.0))
    for _ in range(round(_SETTLES_S / _TICK_S)):
        chair.step(_TICK_S, (begins[0] / 1000.0, begins[1] / 1000.0))
    speed, acceleration, at_s = 0.0, START_M_S2, 0.0
    while at_s < _SETTLES_S:
        acceleration = min(ACCELERATE_M_S2, acceleration + JERK_M_S3 * _TICK_S)
        speed += acceleration * _TICK_S
        linear, turn = {
            CURVES: (most, numbers.turn_permille(rate)),
            STARTS: (numbers.linear_permille(speed), 0),
            BACKS: (numbers.linear_permille(-speed), 0),
        }.get(how, (0, numbers.spot_permille))
        chair.step(_TICK_S, (linear / 1000.0, turn / 1000.0))
        at_s += _TICK_S
        along = {STARTS: chair.speed_m_s, BACKS: -chair.speed_m_s}.get(how)
        if chair.yaw_rate_deg_s > MOVES_DEG_S if along is None else along > MOVES_M_S:
            break
    return at_s
