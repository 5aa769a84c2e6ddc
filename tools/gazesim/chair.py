"""The wheelchair's twin: joystick deflection in, motion out, for each speed profile."""

from __future__ import annotations

import math

from gazesim.chair_axis import Axis, AxisState
from gazesim.disturbances import Disturbances, Floor
from gazesim.profiles import HALF_TRACK_M, KM_H, PROFILES, SPEEDS_KM_H, Parameters

__all__ = [
    "FRONT_M",
    "HALF_TRACK_M",
    "HALF_WIDTH_M",
    "KM_H",
    "PROFILES",
    "REAR_M",
    "SPEEDS_KM_H",
    "Axis",
    "Chair",
    "Disturbances",
    "Parameters",
]

NEUTRAL_TOLERANCE = 0.03  # R-net takes about +/- 30 mV of 1 V for neutral

# Footprint in the chair's frame, the drive axle at the origin.
FRONT_M = 0.65
REAR_M = -0.45
HALF_WIDTH_M = 0.375

_VEER_DEG_PER_M = 20.0  # how far an uneven floor turns the driving chair, per share of veer


class Chair:
    """The chair: pose in the room, speeds, and what its control system makes of the joystick.

    `parameters` makes it another chair than the one of `profile`. `joystick` is "ok", "absent"
    (relay open) or "not_neutral" (it came back deflected: the chair refuses to move until it has
    been neutral). `speed_m_s` is negative backwards, `yaw_rate_deg_s` positive to the left.
    """

    def __init__(
        self, profile: str = "3.1", seed: int = 1, parameters: Parameters | None = None
    ) -> None:
        self.x_m = 0.0
        self.y_m = 0.0
        self.heading_deg = 0.0  # counter-clockwise, not wrapped
        self.speed_m_s = 0.0
        self.yaw_rate_deg_s = 0.0
        self.joystick = "absent"
        self._now_s = 0.0
        self._floor = Floor(seed)
        numbers = _profile(profile) if parameters is None else parameters
        self._linear = AxisState(numbers.linear)
        self._turn = AxisState(numbers.turn)
        self.profile = profile
        self.parameters = numbers

    def set_profile(self, name: str) -> None:
        """Select speed profile `name`; ValueError when the chair has no such profile."""
        self.parameters = _profile(name)
        self.profile = name

    @property
    def parameters(self) -> Parameters:
        """All its numbers; setting them changes the chair at once, moving or not."""
        return self._parameters

    @parameters.setter
    def parameters(self, numbers: Parameters) -> None:
        self._parameters = numbers
        self._linear.use(numbers.disturbances.axis(numbers.linear))
        self._turn.use(numbers.disturbances.axis(numbers.turn))

    def place(self, x_m: float, y_m: float, heading_deg: float) -> None:
        """Put it there, standing still."""
        self.x_m, self.y_m, self.heading_deg = x_m, y_m, heading_deg
        self.halt()

    def halt(self) -> None:
        """Stand still at once."""
        self._linear.halt()
        self._turn.halt()
        self.speed_m_s = self.yaw_rate_deg_s = 0.0

    def step(self, dt_s: float, stick: tuple[float, float] | None) -> None:
        """Advance by `dt_s`; `stick` is (linear, turn), each -1..1, or None without a joystick."""
        self._now_s += dt_s
        now_s, numbers = self._now_s, self._parameters
        self._follow_joystick(stick)
        if stick is not None and self.joystick == "ok":
            axis = numbers.linear
            self._linear.step(now_s, dt_s, stick[0], axis.dead_time_s, axis.brake)
            axis = numbers.turn
            rolling = self._linear.speed != 0.0
            self._turn.step(now_s, dt_s, stick[1], axis.dead_time_s, axis.brake, rolling)
        else:
            lost_s = numbers.lost_dead_time_s
            self._linear.step(now_s, dt_s, 0.0, lost_s, numbers.lost_brake_m_s2)
            self._turn.step(now_s, dt_s, 0.0, lost_s, numbers.lost_brake_deg_s2)
        linear, turn = self._linear.speed, self._turn.speed
        before_m_s, before_deg_s = self.speed_m_s, self.yaw_rate_deg_s
        if numbers.disturbances.veer:
            self._floor.wander(dt_s, numbers.disturbances.veer)
        if linear or turn:
            self._move(dt_s, linear, turn)
        elif before_m_s or before_deg_s:
            self.speed_m_s = self.yaw_rate_deg_s = 0.0
        else:
            return
        speed = 0.5 * (before_m_s + self.speed_m_s)
        yaw = 0.5 * (before_deg_s + self.yaw_rate_deg_s)
        middle = math.radians(self.heading_deg + 0.5 * yaw * dt_s)
        self.x_m += speed * math.cos(middle) * dt_s
        self.y_m += speed * math.sin(middle) * dt_s
        self.heading_deg += yaw * dt_s

    def _move(self, dt_s: float, linear: float, turn: float) -> None:
        # The speeds over this floor, from those the wheels make.
        numbers = self._parameters.disturbances
        veer = self._floor.veer
        yaw = turn * (1.0 + veer[1]) + veer[1] * _VEER_DEG_PER_M * linear
        if numbers.slope_deg_s:
            down = math.radians(numbers.downhill_deg - self.heading_deg)
            yaw += numbers.slope_deg_s * math.sin(down)
        if numbers.caster_deg:
            linear_full = self._linear.axis.positive or 1.0
            turn_full = self._turn.axis.positive or 1.0
            yaw += self._floor.casters_deg_s(numbers, dt_s, linear / linear_full, turn / turn_full)
        self.speed_m_s = linear * (1.0 + veer[0])
        self.yaw_rate_deg_s = yaw

    def _follow_joystick(self, stick: tuple[float, float] | None) -> None:
        if stick is None:
            self.joystick = "absent"
        elif self.joystick != "ok":
            neutral = max(abs(stick[0]), abs(stick[1])) <= NEUTRAL_TOLERANCE
            self.joystick = "ok" if neutral else "not_neutral"


def _profile(name: str) -> Parameters:
    if name not in PROFILES:
        raise ValueError(f"no profile {name!r}; there are {', '.join(PROFILES)}")
    return PROFILES[name]
