"""A simulated chair follows tape on the floor, drawn and judged by code that the host does not use.

Pictures come through JPEG, noise and 100 ms; the pose is odometry's, with its drift; the camera is
the result of a calibration by taps. Judged by the drive axle's true path and the true tape.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.following.line import LineFollower, State
from gazechair.following.request import STOP, Request
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.picture.floor import FloorCamera
from gazechair.picture.floor_calibration import Calibration, Tap, calibrate
from gazelink.settings_table import PROFILES, TABLE
from gazemeasure.report import Report, percentile
from gazemeasure.turn.board import settings_with
from gazesim.chair import Chair
from gazesim.floor_view import Eye, Floor, FloorView, Picture, distance_to_line_m

WIDTH_PX = 160
_STEP_S, _PERIOD_S, _PICTURE_S, _LATE_S = 0.01, 0.05, 0.08, 0.10
_LIMIT_S = 150.0
_LENGTH_M = 7.0  # of a random line
_TAPPED = (22, 14, 28)  # points of the line, 5 cm apart from 0.9 m on
_NEAR_M = 0.10
_LEAST = 95.0  # %, of the way near the tape, of drives that find it, and that end with it
_LOST_S = 0.3
_MOVES_M_S = 0.05
_MARKS = [(x, y) for x in (1.3, 1.7, 2.4) for y in (-0.5, 0.0, 0.5)]
_TAP_PX, _TAPE_M = 1.5, 0.01  # of a picture 320 wide
_DRIFT, _DRIFT_RAD_S, _POSE_M, _SPEED_M_S = 0.01, math.radians(0.05), 0.004, 0.02

_FLOORS = ((0.45, 0.33, 0.22), (0.35, 0.35, 0.36), (0.62, 0.60, 0.55), (0.25, 0.28, 0.34))
_TAPES = {
    "blue": (0.05, 0.16, 0.50),
    "red": (0.50, 0.06, 0.05),
    "yellow": (0.75, 0.60, 0.05),
    "green": (0.05, 0.35, 0.12),
    "black": (0.03, 0.03, 0.03),
    "white": (0.90, 0.90, 0.88),
}
_SIMILAR = 0.75  # share of the tape's colour in a rug of similar colour


@dataclass(frozen=True)
class Driven:
    """The result of a drive. `lost_s`: from the last view of the tape to the zero request."""

    chosen: str
    """The reason why no tap was accepted, or ""."""
    taps: int
    state: State = State.OFF
    near: float = 0.0
    """Share of the path within 10 cm of the tape."""
    worst_m: float = 0.0
    followed: float = 0.0
    """Share of the tape that the axle passed, without the part below the chair's front."""
    end_m: float = 0.0
    """From the chair's front to the tape's end, along it; above 0 before it."""
    lost_s: float = 0.0
    rolled_m: float = 0.0
    speed_m_s: float = 0.0
    cut_m_s: float = 0.0
    """True speed when tape or picture disappeared."""

    @property
    def way(self) -> float:
        """Share of the tape that was followed within 10 cm."""
        return self.near * self.followed


@dataclass(frozen=True)
class Job:
    """A line, a light, a chair. `cut`: "tape" or "picture" disappears after some seconds."""

    seed: int
    profile: str
    cut: str = ""


def measure(report: Report, quick: bool) -> None:
    """Add the rows."""
    count = 2 if quick else 12
    drives = [drive(Job(seed, p)) for p in PROFILES for seed in range(count)]
    add_drives(report, drives)
    for cut in ("tape", "picture"):
        lost = [drive(Job(seed, p, cut)) for p in PROFILES for seed in range(max(1, count // 4))]
        add_lost(report, cut, [one for one in lost if not one.chosen])
    report.note(
        f"(line: {len(drives)} drives of 5 profiles, {WIDTH_PX} px wide, {1 / _PICTURE_S:.1f} Hz)"
    )


def add_drives(report: Report, drives: Sequence[Driven]) -> None:
    """The rows of drives whose tape and picture stay."""
    started = [one for one in drives if not one.chosen]
    found = _share([not one.chosen for one in drives])
    report.add("line: drives that found the tapped tape", found, "%", _LEAST, True)
    taps = _share([one.taps == 1 for one in started])
    report.add("  by the first tap of three", taps, "%")
    way = [100.0 * one.way for one in started]
    mean = sum(way) / max(1, len(way))
    report.add("line: way within 10 cm of it, mean", mean, "%", _LEAST, True)
    report.add("  worst drive", min(way, default=math.nan), "%")
    report.add("  farthest off, 95 % of drives", _p95([one.worst_m for one in started]), "m")
    ended = _share([one.state is State.ENDED for one in started])
    report.add("  drives to its end", ended, "%", _LEAST, True)
    ends = [abs(one.end_m) for one in started if one.state is State.ENDED]
    report.add("  stopped off its end, median", percentile(ends, 0.5), "m")
    report.add("  mean speed", sum(o.speed_m_s for o in started) / max(1, len(started)), "m/s")


def add_lost(report: Report, cut: str, lost: Sequence[Driven]) -> None:
    """The rows of drives whose `cut` disappears; one that stood already shows nothing."""
    moved = [one for one in lost if one.cut_m_s > _MOVES_M_S]
    lost_s = max((one.lost_s for one in moved), default=math.nan)
    report.add(f"line: {cut} gone, zero after, most", lost_s, "s", _LOST_S)
    report.add(
        "  drives that moved then",
        _share([o.cut_m_s > _MOVES_M_S for o in lost]),
        "%",
        _LEAST,
        True,
    )
    report.add("  rolled on, most", max((one.rolled_m for one in moved), default=math.nan), "m")


def _p95(values: list[float]) -> float:
    return percentile(values, 0.95)


def _share(values: list[bool]) -> float:
    return 100.0 * sum(values) / max(1, len(values))


def calibrated(eye: Eye, random: np.random.Generator) -> FloorCamera | None:
    """The camera as calibrated by taps on nine marks; None when the set is refused."""
    taps = []
    for mark in _MARKS:
        u, v = eye.pixel(*(np.array(mark) + random.normal(0.0, _TAPE_M, 2)))
        u, v = np.array((u, v)) + random.normal(0.0, _TAP_PX, 2)
        if 0.0 <= u <= eye.width_px and 0.0 <= v <= eye.height_px:
            taps.append(Tap((float(u), float(v)), mark))
    focal = 0.5 * eye.width_px / math.tan(math.radians(36.0))
    start = FloorCamera(eye.width_px, eye.height_px, focal, 1.1, math.radians(28.0), x_m=0.3)
    found = calibrate(start, taps)
    return found.camera if isinstance(found, Calibration) else None


def random_eye(random: np.random.Generator) -> Eye:
    """A camera as families mount it: behind or beside the head, looking down at the floor ahead."""
    return Eye(
        field_deg=random.uniform(65.0, 85.0),
        height_m=random.uniform(1.0, 1.3),
        down_deg=random.uniform(27.0, 36.0),
        left_deg=random.uniform(-4.0, 4.0),
        clockwise_deg=random.uniform(-3.0, 3.0),
        forward_m=0.3 + random.normal(0.0, 0.03),
        leftward_m=random.normal(0.0, 0.04),
        radial=random.uniform(-0.08, 0.02),
    )


def random_line(random: np.random.Generator) -> FloatArray:
    """Straights and bends of 1.2 m radius and more; begins before the chair."""
    points, heading = [np.array((0.9, random.uniform(-0.05, 0.05)))], random.normal(0.0, 0.05)
    done, first = 0.0, True
    while done < _LENGTH_M:
        piece = random.uniform(0.8, 2.0)
        straight = first or random.random() < 0.4
        bend = 0.0 if straight else random.choice((-1, 1)) / random.uniform(1.2, 4.0)
        piece = min(piece, 1.6 / abs(bend) if bend else piece)
        for _ in range(round(piece / 0.05)):
            heading += bend * 0.05
            step = 0.05 * np.array((math.cos(heading), math.sin(heading)))
            points.append(points[-1] + step)
        done, first = done + piece, False
    return np.array(points)


def random_floor(random: np.random.Generator, line: FloatArray) -> Floor:
    """A floor with tape, a crossing, gaps, shadows, a rug of similar colour, glare and light."""
    tape = _TAPES[str(random.choice(list(_TAPES)))]
    base = np.array(_FLOORS[random.integers(len(_FLOORS))])
    warm = random.uniform(-0.25, 0.25)
    bright = random.uniform(0.35, 1.1)
    at = line[random.integers(len(line) // 3, len(line) - 20, 6)]
    across = random.normal(0.0, 1.0, 2)
    across /= np.hypot(*across)
    where = int(random.integers(len(line) // 3, len(line) - 30))
    ahead = line[where + 1] - line[where]
    across = np.array((-ahead[1], ahead[0])) / np.hypot(*ahead)
    crossing = np.array((line[where] - 0.8 * across, line[where] + 0.8 * across))
    similar = _SIMILAR * np.array(tape) + (1.0 - _SIMILAR) * base
    side = 0.75 * random.choice((-1, 1))
    rug = line[where - 12] + side * across
    return Floor(
        colour=tuple(base),
        tape=tape,
        tape_m=random.uniform(0.04, 0.06),
        lines=[line, crossing],
        gaps=[(float(p[0]), float(p[1]), 0.05) for p in at[:2]],
        rugs=[(float(rug[0]), float(rug[1]), 0.5, 0.35, tuple(similar))],
        shadows=[
            (*(p + random.normal(0.0, 0.2, 2)), random.uniform(0.15, 0.6), 0.4) for p in at[2:]
        ],
        glare=(2.2, random.uniform(-0.6, 0.6), 0.18) if random.random() < 0.5 else None,
        light=(bright * (1.0 + warm), bright, bright * (1.0 - warm)),
        texture=random.uniform(0.02, 0.08),
        noise=random.uniform(1.0, 5.0),
        quality=int(random.integers(50, 85)),
    )


def numbers_of(profile: str) -> ChairNumbers:
    """Numbers of the tuned profile at full speed."""
    changed = {"profile": PROFILES.index(profile), "linear_permille": 1000, "turn_permille": 1000}
    settings = settings_with(changed)
    return ChairNumbers.of({row[0]: getattr(settings, row[0]) for row in TABLE})


class Drive:
    """One chair on one floor, in virtual time."""

    def __init__(
        self, job: Job, line: FloatArray | None = None, floor: Floor | None = None
    ) -> None:
        random = np.random.default_rng((job.seed, PROFILES.index(job.profile)))
        self._random = random
        self.eye = random_eye(random)
        self.camera = calibrated(self.eye, random)
        self.line = random_line(random) if line is None else line
        self.floor = random_floor(random, self.line) if floor is None else floor
        self.view = FloorView(self.eye, self.floor, job.seed)
        self.chair = Chair(job.profile, job.seed)
        self.chair.place(0.0, 0.0, 0.0)
        self.chair.step(_STEP_S, (0.0, 0.0))
        self._numbers = numbers_of(job.profile)
        self._drift = 1.0 + random.normal(0.0, _DRIFT)
        self._pose = np.zeros(3)
        self._before = np.zeros(3)
        self.now_s = 0.0
        self.follower: LineFollower | None = None
        if self.camera is not None:
            small = self.camera.scaled(WIDTH_PX)
            numbers = self._numbers
            most_rad_s = math.radians(min(numbers.left_deg_s, numbers.right_deg_s))
            delay_s = numbers.dead_s + numbers.lag_s
            self.follower = LineFollower(small, numbers.most_m_s, most_rad_s, delay_s)

    def see(self) -> Picture:
        """The camera's present picture."""
        chair = self.chair
        return self.view.picture(chair.x_m, chair.y_m, chair.heading_deg, WIDTH_PX)

    def choose(self) -> tuple[str, int]:
        """Tap the tape some 2 m ahead, if refused nearer or farther; the last reason, and taps."""
        if self.follower is None:
            return "refused", 0
        share = WIDTH_PX / self.eye.width_px
        for taps, point in enumerate(_TAPPED, 1):
            aim = self.line[point] + self._random.normal(0.0, 0.01, 2)
            u, v = self.eye.pixel(float(aim[0]), float(aim[1]))
            picture = self.see()
            reason = self.follower.choose(picture, (u * share, v * share), self.pose, self.now_s)
            if not reason:
                return "", taps
        return reason, len(_TAPPED)

    @property
    def pose(self) -> FloatArray:
        """The chair's pose by odometry."""
        noise = np.array((*self._random.normal(0.0, _POSE_M, 2), 0.0))
        return np.asarray(self._pose + noise)

    def run(
        self, until_s: float, cut_s: float = math.inf, cut: str = ""
    ) -> list[tuple[float, ...]]:
        """Rows: time, true x, y, heading, requested speed, requested yaw."""
        assert self.follower is not None
        rows: list[tuple[float, ...]] = []
        waiting: deque[tuple[float, Picture, FloatArray]] = deque()
        request = STOP
        ticks = 0
        while self.now_s < until_s:
            gone = self.now_s >= cut_s
            if gone and cut == "tape" and self.floor.lines:
                self.floor.lines = []
                self.view.paint()
            dark = gone and cut == "picture"
            if ticks % round(_PICTURE_S / _STEP_S) == 0 and not dark:
                waiting.append((self.now_s, self.see(), self.pose))
            while waiting and waiting[0][0] + _LATE_S <= self.now_s:
                at_s, picture, pose = waiting.popleft()
                self.follower.look(picture, pose, at_s)
            if ticks % round(_PERIOD_S / _STEP_S) == 0:
                speed = self.chair.speed_m_s + float(self._random.normal(0.0, _SPEED_M_S))
                rate = math.radians(self.chair.yaw_rate_deg_s)
                request = self.follower.step(self.pose, speed, rate, self.now_s, _PERIOD_S)
            self._step(request)
            ticks += 1
            chair = self.chair
            rows.append((self.now_s, chair.x_m, chair.y_m, chair.heading_deg, *_both(request)))
            if self.follower.state is not State.FOLLOWS and chair.speed_m_s == 0.0:
                break
        return rows

    def _step(self, request: Request) -> None:
        linear = self._numbers.linear_permille(request.linear_m_s) / 1000.0
        turn = self._numbers.turn_permille(math.degrees(request.yaw_rad_s)) / 1000.0
        self.chair.step(_STEP_S, (linear, turn))
        self.now_s += _STEP_S
        true = np.array((self.chair.x_m, self.chair.y_m, math.radians(self.chair.heading_deg)))
        moved = true - self._before
        self._before = true
        turn = self._pose[2] - true[2]
        c, s = math.cos(turn), math.sin(turn)
        step = self._drift * np.array((c * moved[0] - s * moved[1], s * moved[0] + c * moved[1]))
        self._pose += (*step, moved[2] + _DRIFT_RAD_S * _STEP_S * self._random.normal())


def _both(request: Request) -> tuple[float, float]:
    return request.linear_m_s, request.yaw_rad_s


def drive(job: Job) -> Driven:
    """Run one drive and judge it."""
    one = Drive(job)
    reason, taps = one.choose()
    if reason or one.follower is None:
        return Driven(reason, taps)
    cut_s = float(one._random.uniform(5.0, 10.0)) if job.cut else math.inf
    rows = np.array(one.run(_LIMIT_S, cut_s, job.cut))
    after = rows[:, 0] > cut_s
    moving = after & ((rows[:, 4] != 0.0) | (rows[:, 5] != 0.0))
    lost_s = float(rows[moving, 0].max() - cut_s) if moving.any() else 0.0
    way = np.hypot(*np.diff(rows[:, 1:3], axis=0).T)
    on = rows[1:, 1:3]
    # Count only from where the tape begins.
    from_m = on[:, 0] > one.line[0, 0]
    off = distance_to_line_m(one.line, on)
    total = float(way[from_m].sum())
    near = float(way[from_m & (off < _NEAR_M)].sum()) / total if total > 0.1 else 0.0
    last = rows[-1]
    front = last[1:3] + 0.65 * np.array(
        (math.cos(math.radians(last[3])), math.sin(math.radians(last[3])))
    )
    ahead = one.line[-1] - one.line[-3]
    end_m = float((one.line[-1] - front) @ ahead / np.hypot(*ahead))
    gaps = np.hypot(*(one.line[:, None, :] - on[None, ::20, :]).transpose(2, 0, 1)).min(axis=1)
    before = np.arange(len(one.line)) < len(one.line) - 14
    return Driven(
        "",
        taps,
        one.follower.state,
        near=near,
        worst_m=float(off[from_m].max()) if from_m.any() else 0.0,
        followed=float((gaps[before] < 0.25).mean()),
        end_m=end_m,
        lost_s=lost_s,
        rolled_m=float(way[rows[1:, 0] > cut_s].sum()),
        speed_m_s=total / max(1e-9, float(rows[-1, 0])),
        cut_m_s=float(way[rows[1:, 0] <= cut_s][-1]) / _STEP_S if after.any() else 0.0,
    )
