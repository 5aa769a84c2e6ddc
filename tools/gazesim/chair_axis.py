"""One axis of the chair, drive or turn: deadband, dead time, ramp, friction, lag, standstill."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass


@dataclass(frozen=True)
class Axis:
    """How one axis answers a deflection; speeds in m/s (linear) or deg/s (turn).

    The joystick's deflection passes the deadband, arrives after the dead time, is followed by the
    ramp of the chair's own controller (`accelerate`, `brake`), loses `friction`, and reaches the
    floor through the first-order lag. ValueError for numbers no chair can have.
    """

    positive: float  # speed at full positive deflection (forward, left)
    negative: float  # at full negative deflection (backward, right)
    dead_time_s: float  # joystick to motor controller
    deadband: float  # share of the deflection that does nothing
    accelerate: float  # ramp towards more speed, per second
    brake: float  # ramp towards less
    lag_s: float  # first-order lag of chair and wheels
    standstill: float  # slower than this, without a faster request, the brakes stop it
    friction: float = 0.0  # speed lost while moving; full deflection still gives the full speed
    stiction: float = 0.0  # a ramp below this does not set a standing chair in motion

    def __post_init__(self) -> None:
        if not 0.0 <= self.deadband < 1.0:
            raise ValueError(f"deadband {self.deadband} must be a share, 0 up to 1")
        if min(self.accelerate, self.brake, self.lag_s) <= 0.0 or self.dead_time_s < 0.0:
            raise ValueError("ramps and lag must be above 0, the dead time 0 or more")
        if min(self.friction, self.stiction) < 0.0:
            raise ValueError("friction and stiction must be 0 or more")
        for full in (self.positive, self.negative):  # 0: it does not move in that direction
            if full < 0.0 or (full and max(self.friction, self.stiction) >= full):
                raise ValueError(f"friction and stiction must be below the full speed {full}")


class AxisState:
    """One axis in motion."""

    def __init__(self, axis: Axis) -> None:
        self.speed = 0.0
        self.axis = axis
        self._wanted = 0.0
        self._asked = 0.0
        self._ramp = 0.0
        self._pending: deque[tuple[float, float]] = deque()
        self._dt_s = 0.0
        self._follow = 0.0
        self.use(axis)

    def use(self, axis: Axis) -> None:
        """From now on it answers like this; its speed stays."""
        self.axis = axis
        self._dt_s = 0.0
        self._breakaway = max(axis.stiction, axis.friction, axis.standstill)
        # Full deflection gives the full speed in spite of the friction.
        self._up = axis.positive / ((axis.positive - axis.friction) or 1.0)
        self._down = axis.negative / ((axis.negative - axis.friction) or 1.0)

    def halt(self) -> None:
        """Stand still at once, as against a wall."""
        self.speed = self._ramp = 0.0

    def step(
        self,
        now_s: float,
        dt_s: float,
        deflection: float,
        dead_time_s: float,
        brake: float,
        rolling: bool = False,
    ) -> None:
        """Advance by `dt_s` to `now_s` with the stick at `deflection` (-1..1) meanwhile.

        `rolling`: the other axis moves the chair, so nothing sticks and no friction is left.
        """
        axis = self.axis
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
        wanted, ramp, speed = self._wanted, self._ramp, self.speed
        drive = ramp
        if wanted != ramp:
            faster = abs(wanted) > abs(ramp) and wanted * ramp >= 0.0
            change = (axis.accelerate if faster else brake) * dt_s
            ramp += max(-change, min(change, wanted - ramp))
            self._ramp = ramp
            drive = 0.5 * (drive + ramp)  # its mean over the step, for the same path at any step
        elif ramp == 0.0 == speed:
            return
        if not rolling:
            if speed == 0.0 and -self._breakaway < ramp < self._breakaway:
                return
            if drive > axis.friction:
                drive = (drive - axis.friction) * self._up
            elif drive < -axis.friction:
                drive = (drive + axis.friction) * self._down
            else:
                drive = 0.0
        if dt_s != self._dt_s:
            self._dt_s = dt_s
            self._follow = 1.0 - math.exp(-dt_s / axis.lag_s)
        new = speed + (drive - speed) * self._follow
        still = axis.standstill
        # It sticks at a reversal below what would break it loose, and where the brakes stop it.
        turned = new * speed < 0.0 and -self._breakaway < ramp < self._breakaway
        held = -still < new < still and -still < drive < still
        if (turned and not rolling) or (held and (not rolling or ramp == 0.0)):
            new = 0.0
        self.speed = new
