"""First model of the wheelchair: joystick deflection in, motion out, per speed profile."""

from __future__ import annotations

import math
import random
from collections import deque
from dataclasses import dataclass

KM_H = 1.0 / 3.6
HALF_TRACK_M = 0.28
NEUTRAL_TOLERANCE = 0.03  # R-net takes about +/- 30 mV of 1 V for neutral

# Footprint in the chair's frame, the drive axle at the origin.
FRONT_M = 0.65
REAR_M = -0.45
HALF_WIDTH_M = 0.375


@dataclass(frozen=True)
class Axis:
    """How one axis answers a deflection; speeds in m/s (linear) or deg/s (turn)."""

    positive: float  # speed at full positive deflection (forward, left)
    negative: float  # at full negative deflection (backward, right)
    dead_time_s: float  # joystick to motor controller
    deadband: float  # share of the deflection that does nothing
    accelerate: float  # ramp towards more speed, per second
    brake: float  # ramp towards less
    lag_s: float  # first-order lag of chair and wheels
    standstill: float  # below this, with nothing asked, the brakes hold it


@dataclass(frozen=True)
class Parameters:
    """All numbers of one profile."""

    linear: Axis
    turn: Axis
    lost_brake_m_s2: float = 1.5  # ramp when the joystick is gone
    lost_brake_deg_s2: float = 300.0
    lost_dead_time_s: float = 0.05
    veer: float = 0.02  # slow random part of the speeds: floor, casters


# Speeds seen on the chair in km/h: forward, backward, left, right. Left and right are wheel speeds.
SPEEDS_KM_H = {
    "1.2": (0.7, 0.9, 0.4, 0.3),
    "2.1": (1.0, 1.0, 0.7, 0.7),
    "3.1": (1.3, 1.4, 0.8, 0.8),
    "4.1": (1.6, 1.7, 1.0, 1.0),
    "5.1": (2.0, 1.4, 1.0, 1.0),
}


def _parameters(forward: float, backward: float, left: float, right: float) -> Parameters:
    # The dynamics are estimates, the same for every profile until they are identified on the chair.
    per_km_h = math.degrees(KM_H / HALF_TRACK_M)
    linear = Axis(forward * KM_H, backward * KM_H, 0.15, 0.08, 0.6, 1.0, 0.30, 0.01)
    turn = Axis(left * per_km_h, right * per_km_h, 0.12, 0.08, 120.0, 180.0, 0.20, 0.5)
    return Parameters(linear, turn)


PROFILES = {name: _parameters(*speeds) for name, speeds in SPEEDS_KM_H.items()}


class _AxisState:
    """One axis in motion: dead time, ramp, lag."""

    def __init__(self) -> None:
        self.speed = 0.0
        self._wanted = 0.0
        self._asked = 0.0
        self._ramp = 0.0
        self._pending: deque[tuple[float, float]] = deque()

    def halt(self) -> None:
        """Stand still at once, as against a wall."""
        self.speed = self._ramp = 0.0

    def step(
        self,
        axis: Axis,
        now_s: float,
        dt_s: float,
        deflection: float,
        dead_time_s: float,
        brake: float,
    ) -> None:
        over = abs(deflection) - axis.deadband
        asked = 0.0
        if over > 0.0:
            full = axis.positive if deflection > 0 else -axis.negative
            asked = full * min(1.0, over / (1.0 - axis.deadband))
        pending = self._pending
        if asked != self._asked:
            self._asked = asked
            pending.append((now_s, asked))
        while pending and pending[0][0] + dead_time_s <= now_s + 1e-9:
            self._wanted = pending.popleft()[1]
        wanted, ramp = self._wanted, self._ramp
        if wanted != ramp:
            faster = abs(wanted) > abs(ramp) and wanted * ramp >= 0.0
            change = (axis.accelerate if faster else brake) * dt_s
            ramp += max(-change, min(change, wanted - ramp))
            self._ramp = ramp
        self.speed += (ramp - self.speed) * (1.0 - math.exp(-dt_s / axis.lag_s))
        if ramp == 0.0 and wanted == 0.0 and abs(self.speed) < axis.standstill:
            self.speed = 0.0


class Chair:
    """The chair: pose in the room, speeds, and what its control system makes of the joystick.

    `joystick` is "ok", "absent" (relay open) or "not_neutral" (it came back deflected: the chair
    refuses to move until it has been neutral).
    """

    def __init__(self, profile: str = "3.1", seed: int = 1) -> None:
        self.x_m = 0.0
        self.y_m = 0.0
        self.heading_deg = 0.0  # counter-clockwise, not wrapped
        self.joystick = "absent"
        self._now_s = 0.0
        self._random = random.Random(seed)
        self._veer = [0.0, 0.0]
        self._veer_left_s = 0.0
        self._linear = _AxisState()
        self._turn = _AxisState()
        self.set_profile(profile)

    def set_profile(self, name: str) -> None:
        """Select speed profile `name`; ValueError when the chair has no such profile."""
        if name not in PROFILES:
            raise ValueError(f"no profile {name!r}; there are {', '.join(PROFILES)}")
        self.profile = name
        self.parameters = PROFILES[name]

    @property
    def speed_m_s(self) -> float:
        """Forward speed, negative backwards."""
        return self._linear.speed * (1.0 + self._veer[0])

    @property
    def yaw_rate_deg_s(self) -> float:
        """Turn rate, counter-clockwise positive."""
        yaw = self._turn.speed * (1.0 + self._veer[1])
        return yaw + self._veer[1] * 20.0 * self._linear.speed  # veers a little while it drives

    def place(self, x_m: float, y_m: float, heading_deg: float) -> None:
        """Put it there, standing still."""
        self.x_m, self.y_m, self.heading_deg = x_m, y_m, heading_deg
        self.halt()

    def halt(self) -> None:
        """Stand still at once."""
        self._linear.halt()
        self._turn.halt()

    def step(self, dt_s: float, stick: tuple[float, float] | None) -> None:
        """Advance by `dt_s`; `stick` is (linear, turn), each -1..1, or None without a joystick."""
        self._now_s += dt_s
        self._follow_joystick(stick)
        numbers = self.parameters
        if stick is not None and self.joystick == "ok":
            linear, turn = stick
            linear_dead_s, turn_dead_s = numbers.linear.dead_time_s, numbers.turn.dead_time_s
            linear_brake, turn_brake = numbers.linear.brake, numbers.turn.brake
        else:
            linear = turn = 0.0
            linear_dead_s = turn_dead_s = numbers.lost_dead_time_s
            linear_brake, turn_brake = numbers.lost_brake_m_s2, numbers.lost_brake_deg_s2
        self._linear.step(numbers.linear, self._now_s, dt_s, linear, linear_dead_s, linear_brake)
        self._turn.step(numbers.turn, self._now_s, dt_s, turn, turn_dead_s, turn_brake)
        self._wander(dt_s)
        speed, yaw = self.speed_m_s, self.yaw_rate_deg_s
        if speed or yaw:
            middle = math.radians(self.heading_deg + 0.5 * yaw * dt_s)
            self.x_m += speed * math.cos(middle) * dt_s
            self.y_m += speed * math.sin(middle) * dt_s
            self.heading_deg += yaw * dt_s

    def _follow_joystick(self, stick: tuple[float, float] | None) -> None:
        if stick is None:
            self.joystick = "absent"
        elif self.joystick != "ok":
            neutral = max(abs(stick[0]), abs(stick[1])) <= NEUTRAL_TOLERANCE
            self.joystick = "ok" if neutral else "not_neutral"

    def _wander(self, dt_s: float) -> None:
        # A slow random walk that tends back to zero, renewed ten times a second.
        self._veer_left_s -= dt_s
        if self._veer_left_s <= 0.0:
            self._veer_left_s += 0.1
            spread = self.parameters.veer
            for axis in (0, 1):
                self._veer[axis] = 0.95 * self._veer[axis] + 0.3 * self._random.gauss(0.0, spread)
