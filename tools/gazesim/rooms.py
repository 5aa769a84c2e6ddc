"""Rooms: walls, doors, furniture and people; ray casting and collision by numpy."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray
from gazesim import chair

WALL_HEIGHT_M = 2.5
BODY_HEIGHT_M = 1.3  # what hangs higher than chair and driver is no obstacle
_FARTHEST_M = math.hypot(chair.FRONT_M, chair.HALF_WIDTH_M)  # of the footprint, from its axle
_TINY_M = 1e-6  # above the rounding of any gap


@dataclass(frozen=True)
class Solid:
    """A convex prism: corners counter-clockwise in m, from `z0_m` to `z1_m`, of a material."""

    corners: tuple[tuple[float, float], ...]
    z0_m: float
    z1_m: float
    material: str

    def edges(self) -> list[tuple[float, float, float, float]]:
        """Its sides as segments (x1, y1, x2, y2)."""
        ends = self.corners[1:] + self.corners[:1]
        return [(*a, *b) for a, b in zip(self.corners, ends, strict=True)]


def box(
    x: float,
    y: float,
    length: float,
    width: float,
    z0: float,
    z1: float,
    material: str,
    turn_deg: float = 0,
) -> Solid:
    """A box around (x, y), `length` along its own x axis, turned counter-clockwise."""
    c, s = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    half = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    corners = tuple(
        (x + c * i * length / 2 - s * j * width / 2, y + s * i * length / 2 + c * j * width / 2)
        for i, j in half
    )
    return Solid(corners, z0, z1, material)


@dataclass
class Door:
    """A door from hinge to jamb; open, it stands at right angles, `swing` 1 left or -1 right."""

    name: str
    hinge: tuple[float, float]
    jamb: tuple[float, float]
    swing: int = 1
    open: bool = True

    def leaf(self) -> Solid:
        """The leaf where it stands now, 4 cm thick."""
        dx, dy = self.jamb[0] - self.hinge[0], self.jamb[1] - self.hinge[1]
        if self.open:
            dx, dy = -dy * self.swing, dx * self.swing
        length = math.hypot(dx, dy)
        x, y = self.hinge[0] + dx / 2, self.hinge[1] + dy / 2
        return box(x, y, length, 0.04, 0.0, 2.05, "door", math.degrees(math.atan2(dy, dx)))


@dataclass
class Person:
    """A person who walks to and fro along `path` and waits while the chair is in the way."""

    path: tuple[tuple[float, float], ...]
    speed_m_s: float = 0.6
    radius_m: float = 0.22
    x_m: float = field(init=False)
    y_m: float = field(init=False)
    _next: int = field(init=False, default=1)
    _way: int = field(init=False, default=1)

    def __post_init__(self) -> None:
        self.x_m, self.y_m = self.path[0]

    def walk(self, dt_s: float) -> tuple[float, float]:
        """Where the next `dt_s` would lead; `go` takes the step."""
        if len(self.path) == 1:
            return self.x_m, self.y_m
        goal = self.path[self._next]
        left = math.hypot(goal[0] - self.x_m, goal[1] - self.y_m)
        stride = self.speed_m_s * dt_s
        if left <= stride:
            if not 0 <= self._next + self._way < len(self.path):
                self._way = -self._way
            self._next += self._way
            return goal
        share = stride / left
        return self.x_m + (goal[0] - self.x_m) * share, self.y_m + (goal[1] - self.y_m) * share


@dataclass
class Room:
    """A room by name, with everything in it, and where the chair starts."""

    name: str
    walls: tuple[tuple[float, float, float, float], ...]
    furniture: tuple[Solid, ...] = ()
    doors: tuple[Door, ...] = ()
    people: tuple[Person, ...] = ()
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)  # x m, y m, heading deg
    _obstacles: dict[str, Solid] = field(default_factory=dict)
    _cached: dict[float, FloatArray] = field(default_factory=dict)
    changes: int = 0
    """So often something in it has moved, people aside."""
    _free: tuple[float, float, float, float] | None = None
    """A pose, and the gap there between the chair's footprint and what does not walk."""

    def solids(self) -> list[Solid]:
        """Everything convex that stands in it now, people aside."""
        return [*self.furniture, *(door.leaf() for door in self.doors), *self._obstacles.values()]

    def put(self, name: str, solid: Solid | None) -> None:
        """Put an extra obstacle there under `name`; None takes it away."""
        self._obstacles.pop(name, None)
        if solid is not None:
            self._obstacles[name] = solid
        self.changed()

    def set_door(self, name: str, is_open: bool) -> None:
        """Open or close a door; ValueError when there is none of that name."""
        for door in self.doors:
            if door.name == name:
                door.open = is_open
                self.changed()
                return
        names = ", ".join(door.name for door in self.doors) or "none"
        raise ValueError(f"room {self.name} has no door {name!r}; doors: {names}")

    def open_doors(self) -> None:
        """Open every door."""
        for door in self.doors:
            door.open = True
        self.changed()

    def changed(self) -> None:
        """Something in it has moved."""
        self._cached = {}
        self._free = None
        self.changes += 1

    def segments(self, height_m: float) -> FloatArray:
        """What a horizontal plane at `height_m` cuts, as rows x1, y1, x2, y2."""
        return self._segments(height_m, height_m)

    def body_segments(self) -> FloatArray:
        """What chair and driver can bump into, at any height."""
        return self._segments(0.0, BODY_HEIGHT_M)

    def _segments(self, low_m: float, high_m: float) -> FloatArray:
        key = low_m + 1000.0 * high_m
        found = self._cached.get(key)
        if found is None:
            rows = list(self.walls)
            for solid in self.solids():
                if solid.z0_m <= high_m and solid.z1_m >= low_m:
                    rows.extend(solid.edges())
            found = np.array(rows, dtype=np.float64).reshape(-1, 4)
            self._cached[key] = found
        return found

    def discs(self) -> FloatArray:
        """People as rows x, y, radius."""
        rows = [(p.x_m, p.y_m, p.radius_m) for p in self.people]
        return np.array(rows, dtype=np.float64).reshape(-1, 3)

    def cast(self, x_m: float, y_m: float, angles_rad: FloatArray, height_m: float) -> FloatArray:
        """Distance in m from (x, y) along each angle to what is first there; inf for nothing."""
        return cast_rays(x_m, y_m, angles_rad, self.segments(height_m), self.discs())

    def collides(self, x_m: float, y_m: float, heading_deg: float) -> bool:
        """Whether the chair's footprint at that pose touches anything."""
        if not self._stays_free(x_m, y_m, heading_deg):
            segments = self._in_chair_frame(x_m, y_m, heading_deg)
            if _cuts_footprint(segments).any():
                return True
            gap_m = float(_segment_gaps(segments).min()) if len(segments) else math.inf
            self._free = (x_m, y_m, heading_deg, gap_m)
        if not self.people:
            return False
        return bool((_disc_gaps(_turn_discs(self.discs(), x_m, y_m, heading_deg)) <= 0.0).any())

    def _stays_free(self, x_m: float, y_m: float, heading_deg: float) -> bool:
        # No corner of the footprint has come as far as the nearest thing was.
        if self._free is None:
            return False
        at_x_m, at_y_m, at_deg, gap_m = self._free
        turned_m = _FARTHEST_M * math.radians(abs(heading_deg - at_deg))
        return math.hypot(x_m - at_x_m, y_m - at_y_m) + turned_m < gap_m - _TINY_M

    def clearance_m(self, x_m: float, y_m: float, heading_deg: float) -> float:
        """Smallest gap between the chair's footprint and anything, 0 when touching."""
        segments = self._in_chair_frame(x_m, y_m, heading_deg)
        if _cuts_footprint(segments).any():
            return 0.0
        discs = _turn_discs(self.discs(), x_m, y_m, heading_deg)
        gaps = np.concatenate((_segment_gaps(segments), _disc_gaps(discs)))
        return max(0.0, float(gaps.min())) if gaps.size else math.inf

    def step(self, dt_s: float, x_m: float, y_m: float, heading_deg: float) -> None:
        """Let people walk for `dt_s`; nobody walks closer than 0.4 m to the chair at that pose."""
        for person in self.people:
            wanted = person.walk(dt_s)
            here = np.array([[person.x_m, person.y_m, person.radius_m]])
            there = np.array([[*wanted, person.radius_m]])
            pose = (x_m, y_m, heading_deg)
            gap_there = float(_disc_gaps(_turn_discs(there, *pose))[0])
            if gap_there >= 0.4 or gap_there > float(_disc_gaps(_turn_discs(here, *pose))[0]):
                person.x_m, person.y_m = wanted

    def _in_chair_frame(self, x_m: float, y_m: float, heading_deg: float) -> FloatArray:
        rows = self.body_segments()
        c, s = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
        shifted = rows.reshape(-1, 2) - (x_m, y_m)
        turned: FloatArray = shifted @ np.array(((c, -s), (s, c)))
        return turned.reshape(-1, 4)


def cast_rays(
    x_m: float, y_m: float, angles_rad: FloatArray, segments: FloatArray, discs: FloatArray
) -> FloatArray:
    """Distance in m from (x, y) along each angle to what is nearest; inf for nothing."""
    dx, dy = np.cos(angles_rad), np.sin(angles_rad)
    nearest: FloatArray = np.full(len(angles_rad), np.inf)
    if len(segments):
        # A row for each segment: long rows are computed faster than long columns.
        x1, y1, x2, y2 = segments.T[:, :, None]
        ax, ay, ex, ey = x1 - x_m, y1 - y_m, x2 - x1, y2 - y1
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            inverse = 1.0 / (dx * ey - dy * ex)
            along = (ax * ey - ay * ex) * inverse  # distance along the ray
            share = (ax * dy - ay * dx) * inverse  # 0..1 along the segment
            hit = (along > 0.0) & (share >= 0.0) & (share <= 1.0)
            nearest = np.where(hit, along, np.inf).min(axis=0)
    for cx, cy, radius in discs:
        middle = dx * (cx - x_m) + dy * (cy - y_m)
        inside = radius**2 - ((cx - x_m) ** 2 + (cy - y_m) ** 2 - middle**2)
        hit = (inside >= 0.0) & (middle > 0.0)
        near = middle - np.sqrt(np.maximum(inside, 0.0))
        nearest = np.where(hit, np.minimum(nearest, np.maximum(near, 0.0)), nearest)
    return nearest


def _turn_discs(discs: FloatArray, x_m: float, y_m: float, heading_deg: float) -> FloatArray:
    c, s = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
    x, y = discs[:, 0] - x_m, discs[:, 1] - y_m
    return np.column_stack((c * x + s * y, c * y - s * x, discs[:, 2]))


def _cuts_footprint(segments: FloatArray) -> BoolArray:
    """Which segments (chair's frame) touch the footprint: clip each against its four sides."""
    enter, leave = np.zeros(len(segments)), np.ones(len(segments))
    sides = ((0, chair.REAR_M, chair.FRONT_M), (1, -chair.HALF_WIDTH_M, chair.HALF_WIDTH_M))
    for axis, low, high in sides:
        start = segments[:, axis]
        step = segments[:, axis + 2] - start
        step = np.where(np.abs(step) < 1e-12, 1e-12, step)
        to_low, to_high = (low - start) / step, (high - start) / step
        enter = np.maximum(enter, np.minimum(to_low, to_high))
        leave = np.minimum(leave, np.maximum(to_low, to_high))
    return enter <= leave


def _point_gaps(x: FloatArray, y: FloatArray) -> FloatArray:
    out_x = np.maximum(np.maximum(chair.REAR_M - x, x - chair.FRONT_M), 0.0)
    out_y = np.maximum(np.abs(y) - chair.HALF_WIDTH_M, 0.0)
    return np.hypot(out_x, out_y)


def _disc_gaps(discs: FloatArray) -> FloatArray:
    return np.asarray(_point_gaps(discs[:, 0], discs[:, 1]) - discs[:, 2])


def _segment_gaps(segments: FloatArray) -> FloatArray:
    """Gap of segments that do not cut the footprint: end to box, or corner to segment."""
    gaps = np.minimum(
        _point_gaps(segments[:, 0], segments[:, 1]), _point_gaps(segments[:, 2], segments[:, 3])
    )
    ex, ey = segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]
    squared = np.maximum(ex**2 + ey**2, 1e-12)
    for x in (chair.REAR_M, chair.FRONT_M):
        for y in (-chair.HALF_WIDTH_M, chair.HALF_WIDTH_M):
            rx, ry = x - segments[:, 0], y - segments[:, 1]
            share = np.clip((rx * ex + ry * ey) / squared, 0.0, 1.0)
            gaps = np.minimum(gaps, np.hypot(rx - share * ex, ry - share * ey))
    return gaps
