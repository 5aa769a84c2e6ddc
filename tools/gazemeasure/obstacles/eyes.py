"""Fast simulated lidars: a few rays at their true times, and the two rules that evaluate them.

800 rays a turn instead of 3200 (a ray each 0.45 degrees), acquired one after another while the
chair moves, 10 turns a second, with range noise and lost returns.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gazechair.base.angles import half_turn_deg
from gazechair.base.arrays import FloatArray
from gazechair.base.footprint import Footprint
from gazechair.board.board_commands import Clearance
from gazechair.sensing.clearance.evaluate import Evaluator
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.lidar.blind import Blindness
from gazechair.sensing.lidar.scan import Pose, Scan, in_arcs, to_chair
from gazelink import codes
from gazemeasure import prototype_rule
from gazesim.lidar_noise import MISSING
from gazesim.rooms import Room
from gazesim.world import LIDAR_HEIGHT_M
from gazesim.zone import zone_of

RAYS = 800
TURN_S = 0.1
_RANGE_M = (0.05, 30.0)
_PIECE_S = 0.02  # beams are cast together from one place

Arc = tuple[float, float]
Where = tuple[float, float, float]


@dataclass(frozen=True)
class Mount:
    """A lidar's place on the chair and the arcs of its view that the chair itself fills."""

    pose: Pose
    mask: tuple[Arc, ...]


FRONT = (Mount(Pose(0.5), ((122.0, -122.0),)),)
"""The first prototype's lidar: in front; the chair hides what is behind it."""
CORNERS = (
    Mount(Pose(0.651, 0.376), ((-180.0, -90.0),)),
    Mount(Pose(-0.451, -0.376, 180.0), ((-180.0, -90.0),)),
)
"""Two on opposite corners, 270 degrees each: together they see everything around the chair."""


class Eye:
    """One lidar in a room."""

    def __init__(
        self, mount: Mount, room: Room, noise_m: float, seed: int, rays: int = RAYS
    ) -> None:
        self.mount = mount
        self._room = room
        self._noise_m = noise_m
        self._random = np.random.default_rng(seed)
        self._angles_deg = half_turn_deg(-360.0 * np.arange(rays) / rays)
        self._rays = rays
        self._masked = in_arcs(self._angles_deg, mount.mask)
        self._distances_m = np.zeros(rays)
        self._next = 0
        self._waited_s = 0.0
        self.turns = 0

    def step(self, dt_s: float, chair: Where) -> None:
        """Turn the mirror for `dt_s`, with the chair at (x, y, heading)."""
        self._waited_s += dt_s
        if self._waited_s < _PIECE_S - 1e-9:
            return
        count = round(self._rays * self._waited_s / TURN_S)
        self._waited_s = 0.0
        at = (self._next + np.arange(count)) % self._rays
        self._next += count
        if self._next >= self._rays:
            self._next -= self._rays
            self.turns += 1
        at = at[~self._masked[at]]
        if len(at):
            self._distances_m[at] = self._measure(self._angles_deg[at], chair)

    def _measure(self, angles_deg: FloatArray, chair: Where) -> FloatArray:
        pose = self.mount.pose
        x_m, y_m, heading_deg = chair
        c, s = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
        x, y = x_m + c * pose.x_m - s * pose.y_m, y_m + s * pose.x_m + c * pose.y_m
        rays = np.radians(pose.directions_deg(angles_deg) + heading_deg)
        true = self._room.cast(x, y, rays, LIDAR_HEIGHT_M)
        seen = (true >= _RANGE_M[0]) & (true <= _RANGE_M[1])
        seen &= self._random.random(len(true)) >= MISSING
        noise = self._random.standard_normal(len(true)) * self._noise_m
        return np.where(seen, np.maximum(np.where(seen, true, 0.0) + noise, 0.0), 0.0)

    def scan(self, now_s: float) -> Scan:
        """The scan of the newest turn."""
        return Scan(self._angles_deg, self._distances_m.copy(), now_s - TURN_S, codes.SIMULATED)

    def half_turn(self, now_s: float) -> Piece:
        """The newest half turn, in the chair's directions, without what the chair itself fills."""
        count = self._rays // 2
        at = (self._next - count + np.arange(count)) % self._rays
        kept = ~self._masked[at]
        times = now_s - 0.5 * TURN_S * (1.0 - (np.arange(count) + 1.0) / count)
        pose = self.mount.pose
        return Piece(
            pose.directions_deg(self._angles_deg[at][kept]),
            self._distances_m[at][kept],
            times[kept],
            (pose.x_m, pose.y_m),
            self._rays,
        )


class Ours:
    """The footprint's clearance, as the host computes it."""

    def __init__(self, eyes: Sequence[Eye]) -> None:
        self._eyes = eyes
        self._blindness = [Blindness() for _ in eyes]
        origins = [(eye.mount.pose.x_m, eye.mount.pose.y_m) for eye in eyes]
        self._evaluate = evaluator(tuple(origins))

    def look(self, now_s: float) -> Clearance:
        """The present clearance."""
        views = tuple(
            to_chair(eye.scan(now_s), eye.mount.pose, eye.mount.mask, blindness)
            for eye, blindness in zip(self._eyes, self._blindness, strict=True)
        )
        found = self._evaluate(views)
        return Clearance(source=codes.SIMULATED, acquired_s=now_s - TURN_S, **found)


class Prototype:
    """The first prototype's rule: three sectors of its front lidar, 0.5 m, nothing behind."""

    def __init__(self, eye: Eye) -> None:
        self._eye = eye
        self._bits = prototype_rule.ALL_BLOCKED

    def look(self, now_s: float) -> Clearance:
        """The clearance by the prototype's rule."""
        scan = self._eye.scan(now_s)
        kept = ~in_arcs(scan.angles_deg, self._eye.mount.mask)
        directions = self._eye.mount.pose.directions_deg(scan.angles_deg[kept])
        self._bits = prototype_rule.blocked(directions, scan.distances_m[kept], self._bits)
        bits = self._bits & ~(1 << codes.DIR_BACKWARD)
        return Clearance(bits, codes.SIMULATED, now_s - TURN_S)


def evaluator(origins_m: tuple[tuple[float, float], ...]) -> Evaluator:
    """A fresh evaluator of the default footprint for lidars there, and the default settings."""
    made = Evaluator(Footprint(), origins_m)
    made.zone = zone_of()
    return made
