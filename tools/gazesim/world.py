"""The simulated world: one chair in one room, with every device that the board and the host use.

No threads, no wall clock: only `step` moves time, so equal seeds and inputs give equal traces.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

from gazeboard.boards import bank_layout as layout
from gazechair.base.arrays import FloatArray
from gazesim import pot as pot_model
from gazesim.bank import Bank
from gazesim.bno055 import Bno055
from gazesim.chair import Chair
from gazesim.faults import WORLD_FAULTS, Faults
from gazesim.plans import room as make_room
from gazesim.pot import Pot
from gazesim.relay import Relay
from gazesim.rooms import Room, box
from gazesim.s2 import S2
from gazesim.s2_faults import LIDAR_FAULTS

LIDAR_X_M = 0.50  # in the chair's frame, facing forward
Mount = tuple[float, float, float]  # x, y in metres, and where its front looks, in degrees
ONE: tuple[Mount, ...] = ((LIDAR_X_M, 0.0, 0.0),)
"""In front: what the chair hides behind it is never seen."""
TWO: tuple[Mount, ...] = ((0.651, 0.376, 0.0), (-0.451, -0.376, 180.0))
"""On opposite corners, each seeing 270 degrees: nothing round the chair is unseen."""
_CORNER_ARCS = ((181.0, 269.0, 0.22),)  # as s2_beams.CHAIR_ARCS
LIDAR_HEIGHT_M = 0.25
_COLLISION_S = 0.010
_PEOPLE_S = 0.050
_APART_M = 0.02  # that far from what it bumped into, the next touch is a new collision


class World:
    """Chair, room and devices around one register bank.

    `tick_stall_s`: a board whose tick stands still that long counts as stopped (see relay).
    """

    def __init__(
        self,
        bank: Bank,
        room: str | Room = "living",
        profile: str = "3.1",
        seed: int = 1,
        tick_stall_s: float = 0.020,
        mounts: tuple[Mount, ...] = ONE,
    ) -> None:
        self.bank = bank
        self.room = make_room(room) if isinstance(room, str) else room
        self.chair = Chair(profile, seed)
        self.chair.place(*self.room.start)
        self.pot = Pot(bank)
        self.relay = Relay(bank, tick_stall_s)
        self.stuck_turn: float | None = None  # deflection at which the turn axis is stuck, if any
        self.imu = Bno055(bank, seed)
        self.lidars = [S2(partial(self._ranges, one), seed + k) for k, one in enumerate(mounts)]
        if mounts == TWO:
            for lidar in self.lidars:
                lidar.beams.chair_arcs = _CORNER_ARCS
        self.lidar = self.lidars[0]
        self.scans = [b""] * len(self.lidars)
        """What each lidar sent in the last step."""
        self.faults = Faults(self, WORLD_FAULTS)
        self.faults.add(self.lidar, LIDAR_FAULTS)
        self.time_s = 0.0
        self.wipers = self.pot.poll()
        self.collisions = 0
        self._touching = False
        self._good_pose = self.room.start
        self._collision_in_s = 0.0
        self._people_in_s = 0.0
        self._stands: tuple[tuple[float, float, float], int] | None = None
        self._seen: dict[tuple[Mount, int], tuple[FloatArray, FloatArray]] = {}

    def step(self, dt_s: float) -> bytes:
        """Advance by `dt_s` (1 ms is the board's tick; up to 5); what the first lidar sends."""
        self.time_s += dt_s
        self.bank.set_u32(layout.WORLD_MS_AT, round(self.time_s * 1000))
        self.relay.step(dt_s)
        self.wipers = self.pot.poll()
        stick = None
        if self.relay.closed:
            linear, turn = self.wipers
            stick = (pot_model.deflection(linear), pot_model.deflection(turn))
            if self.stuck_turn is not None:
                stick = (stick[0], self.stuck_turn)
        speed_before = self.chair.speed_m_s
        self.chair.step(dt_s, stick)
        self._collide(dt_s)
        acceleration = (self.chair.speed_m_s - speed_before) / dt_s
        self.imu.step(dt_s, self.chair.yaw_rate_deg_s, acceleration)
        self._people_in_s -= dt_s
        if self._people_in_s <= 0.0:
            self._people_in_s += _PEOPLE_S
            self.room.step(_PEOPLE_S, *self.pose)
        self.scans = [lidar.step(dt_s) for lidar in self.lidars]
        return self.scans[0]

    def power_off(self) -> None:
        """The board's power is gone, and with it that of the devices on its 3.3 V."""
        self.pot.power_off()
        self.imu.power_off()

    def power_on(self) -> None:
        """It is back: a cold start of both."""
        self.pot.power_on()
        self.imu.power_on()

    @property
    def pose(self) -> tuple[float, float, float]:
        """The chair's drive axle in the room: x m, y m, heading deg."""
        return self.chair.x_m, self.chair.y_m, self.chair.heading_deg

    def teleport(self, x_m: float, y_m: float, heading_deg: float) -> None:
        """Put the chair there, standing still; ValueError when it would stand in something."""
        if not all(math.isfinite(value) for value in (x_m, y_m, heading_deg)):
            raise ValueError("a pose must be finite")
        if self.room.collides(x_m, y_m, heading_deg):
            raise ValueError(f"the chair does not fit at x {x_m} m, y {y_m} m, {heading_deg} deg")
        self.chair.place(x_m, y_m, heading_deg)
        self._good_pose = self.pose
        self._touching = False

    def put_obstacle(self, ahead_m: float, left_m: float, size_m: float) -> None:
        """A box stands from `ahead_m` before the axle on, `left_m` to its left, `size_m` wide."""
        x, y, heading_deg = self.pose
        c, s = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
        ahead_m += size_m / 2
        place = (x + c * ahead_m - s * left_m, y + s * ahead_m + c * left_m)
        self.room.put("obstacle", box(*place, size_m, size_m, 0.0, 1.0, "pot", heading_deg))

    def _collide(self, dt_s: float) -> None:
        chair = self.chair
        if not chair.speed_m_s and not chair.yaw_rate_deg_s:
            return
        self._collision_in_s -= dt_s
        if self._collision_in_s > 0.0:
            return
        self._collision_in_s += _COLLISION_S
        if not self.room.collides(*self.pose):
            self._good_pose = self.pose
            if self._touching and self.room.clearance_m(*self.pose) > _APART_M:
                self._touching = False
            return
        if not self._touching:
            self.collisions += 1
        self._touching = True
        if not self.room.collides(*self._good_pose):  # else something closed in: let it out
            chair.place(*self._good_pose)

    def _ranges(self, mount: Mount, angles_rad: FloatArray) -> FloatArray:
        if self.room.people:
            return self._cast(mount, angles_rad)
        # A chair that stands where nothing moves sees the same in every turn of the mirror.
        stands = (self.pose, self.room.changes)
        if stands != self._stands:
            self._stands = stands
            self._seen.clear()
        _, found = self._seen.get((mount, id(angles_rad)), (None, None))
        if found is None:
            found = self._cast(mount, angles_rad)
            self._seen[mount, id(angles_rad)] = angles_rad, found
        return found

    def _cast(self, mount: Mount, angles_rad: FloatArray) -> FloatArray:
        x, y, heading_deg = self.pose
        heading = math.radians(heading_deg)
        x += mount[0] * math.cos(heading) - mount[1] * math.sin(heading)
        y += mount[0] * math.sin(heading) + mount[1] * math.cos(heading)
        looks = angles_rad + heading + math.radians(mount[2])
        return self.room.cast(x, y, looks, LIDAR_HEIGHT_M)

    def truth(self) -> dict[str, Any]:
        """The true state, for tests and demonstrations; no device reports all of it."""
        x_m, y_m, heading_deg = self.pose
        return {
            "time_s": self.time_s,
            "room": self.room.name,
            "profile": self.chair.profile,
            "x_m": x_m,
            "y_m": y_m,
            "heading_deg": heading_deg,
            "speed_m_s": self.chair.speed_m_s,
            "yaw_rate_deg_s": self.chair.yaw_rate_deg_s,
            "wipers": list(self.wipers),
            "relay_closed": self.relay.closed,
            "joystick": self.chair.joystick,
            "collided": self._touching,
            "collisions": self.collisions,
            "clearance_m": self.room.clearance_m(*self.pose),
            "tick_ms": self.bank.tick_ms,
            "boot_count": self.bank.boot_count,
            "lidar_scanning": self.lidar.scanning,
            "faults": self.faults.active(),
        }
