"""Missions of the whole chair: firmware from main.py on, frames, odometry, mapping, producers.

In virtual time, as tests/e2e drive it; the chair must locate itself. It begins where the drive
before ended, and has one press. The simulator's truth judges.
"""

from __future__ import annotations

import math
import pathlib
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gazechair.base.footprint import Footprint
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.costmap import costmap_of
from gazechair.going.plan import Path, Planner, Pose
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.places import Drawn
from gazemeasure.go.ideal import Permitted, ideal_s
from gazesim.homes import GLASS, Home
from gazesim.located_chair import LocatedChair
from gazesim.thinker import PLAN_MS

ARRIVED_M, ARRIVED_DEG = 0.15, 5.0
_GOAL = "Daar"
_KNOWN_MS = 3000
_JUDGE_MS, _WORD_MS = 20, 60
_LIMIT_S = 90.0  # and four times the ideal
_SETTLES_MS = 1000
MOVES_M_S, MOVES_DEG_S = 0.05, 2.0


@dataclass(frozen=True)
class Scene:
    """Where a mission is driven. `room`: the truth; `grid`: the chair's map of it."""

    room: Home
    grid: OccupancyGrid
    start: Pose
    goal: Pose
    profile: str


@dataclass
class Driven:
    """The result of a drive."""

    arrived: bool = False
    collisions: int = 0
    least_m: float = math.inf
    took_s: float = 0.0
    ideal_s: float = math.inf
    end_m: float = math.inf
    end_deg: float = math.inf
    ended: str = ""
    """The last state and reason that the pages received."""
    silent_s: float = 0.0
    """The longest time that it stood before a blocked way without a reason on the pages."""
    shut: bool = False
    """Its way was blocked during the drive."""
    cpu_s: float = 0.0

    @property
    def ratio(self) -> float:
        """Time divided by the ideal time."""
        return self.took_s / max(self.ideal_s, 1.0)

    @property
    def why(self) -> str:
        """The situation in one line, for drives that did not arrive."""
        off = f"{self.end_m:.2f} m and {self.end_deg:.0f} deg off"
        return f"{self.ended}, {off}, {self.took_s:.0f} s, {self.collisions} collisions"


class Judge:
    """Drives one mission. `acts` are called each millisecond."""

    def __init__(self, scene: Scene, folder: pathlib.Path, plan_ms: float | None = PLAN_MS) -> None:
        """`plan_ms`: see LocatedChair."""
        self.scene = scene
        drawn = Drawn()
        for name, (x_m, y_m, heading_rad) in self._places().items():
            heading_deg = math.degrees(heading_rad) % 360.0
            place = {"name": name, "icon": "star", "x": x_m, "y": y_m, "heading": heading_deg}
            drawn = drawn.with_place(place)
        for one in scene.room.solids():
            if one.material == GLASS:
                drawn = drawn.with_area([list(corner) for corner in one.corners])
        self._no_go = tuple(np.array(area.corners_m) for area in drawn.no_go)
        scene.room.start = (*scene.start[:2], math.degrees(scene.start[2]))
        home = HomeMap("Thuis", scene.grid, drawn=drawn)
        self.chair = LocatedChair(folder, home, scene.room, scene.profile, plan_ms)
        self.driven = Driven()
        self.acts: list[Callable[[], None]] = []
        self.pressed_ms = 0

    def drive(self) -> Driven:
        """Press once, and run until it has arrived, has ended, or takes too long."""
        chair, driven = self.chair, self.driven
        chair.came_here()
        if not self._waits(lambda: _GOAL in chair.tiles, _KNOWN_MS):
            driven.ended = "it does not know where it is"
            return driven
        driven.ideal_s = self._ideal_s(False)
        self._sets_out()
        chair.run(_WORD_MS)
        limit_s = _LIMIT_S + 4.0 * driven.ideal_s
        self._waits(lambda: chair.news["state"] in ("", "arrived", "ended"), 1000 * round(limit_s))
        driven.took_s = self.since_s
        if chair.board.app.profile_check.agreed:
            driven.ideal_s = self._ideal_s(True)
        state, reason = chair.news["state"], chair.news["reason"]
        driven.ended = f"{state} {reason}".strip()
        self._waits(lambda: False, _SETTLES_MS)
        x_m, y_m, heading_rad = self.scene.goal
        driven.end_m, driven.end_deg = chair.off(x_m, y_m, math.degrees(heading_rad))
        near = driven.end_m <= ARRIVED_M and driven.end_deg <= ARRIVED_DEG
        driven.collisions = chair.world.collisions
        driven.arrived = state == "arrived" and near and not driven.collisions
        return driven

    def _places(self) -> dict[str, Pose]:
        """The places of the map, by their names."""
        return {_GOAL: self.scene.goal}

    def _sets_out(self) -> None:
        """Choose the goal."""
        self.pressed_ms = self.chair.now_ms
        self.chair.page.choose(self.chair.tiles[_GOAL])

    @property
    def since_s(self) -> float:
        """Seconds since the press."""
        return (self.chair.now_ms - self.pressed_ms) / 1000.0

    def _waits(self, over: Callable[[], bool], limit_ms: int) -> bool:
        chair = self.chair
        for _ in range(limit_ms):
            if chair.now_ms % _JUDGE_MS == 0:
                if over():
                    return True
                self._measure()
            chair.one_ms()
            for act in self.acts:
                act()
        return over()

    @property
    def moves(self) -> bool:
        """True if the chair moves, by the truth."""
        chair = self.chair.world.chair
        return abs(chair.speed_m_s) > MOVES_M_S or abs(chair.yaw_rate_deg_s) > MOVES_DEG_S

    def _measure(self) -> None:
        if self.moves:
            gap_m = self.scene.room.clearance_m(*self.chair.world.pose)
            self.driven.least_m = min(self.driven.least_m, gap_m)

    def _ideal_s(self, trusted: bool) -> float:
        settings = self.chair.settings
        assert settings is not None
        numbers = ChairNumbers.of(settings)
        permitted = Permitted(self.chair.board.app.settings, numbers, trusted)
        costmap = costmap_of(self.scene.grid, Footprint(), self._no_go)
        path = Planner(costmap, True).plan(self.scene.start, self.scene.goal, ())
        return ideal_s(path, self.scene.start, permitted) if isinstance(path, Path) else math.inf


def drive(scene: Scene, act: Callable[[Judge], None] = lambda _judge: None) -> Driven:
    """Drive it; `act` is called each millisecond."""
    begin_s = time.process_time()
    with tempfile.TemporaryDirectory(prefix="gazechair-") as folder:
        judge = Judge(scene, pathlib.Path(folder))
        judge.acts.append(lambda: act(judge))
        try:
            driven = judge.drive()
        finally:
            judge.chair.close()
    driven.cpu_s = time.process_time() - begin_s
    return driven
