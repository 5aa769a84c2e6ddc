"""One turn of the first prototype on the twin, and the values read from its heading."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from gazesim.chair import Chair
from gazesim.chair_axis import Axis
from gazesim.imu_model import Imu, ImuErrors
from gazesim.pot import deflection
from gazesim.profiles import undisturbed
from gazetwin.prototype import Gains, Prototype, Reading

ANGLE_DEG = 10.0
CUTOFF_DEG = 2.0
SAMPLE_MS = 10
_STICKS = [deflection(count) for count in range(256)]
_SENSOR = ImuErrors(latency_s=0.015)


@dataclass
class Trace:
    """True headings of a turn to `angle_deg`, one each 10 ms from its start."""

    angle_deg: float
    headings_deg: list[float] = field(default_factory=list)

    def times_s(self) -> list[float]:
        """The time of each heading."""
        return [k * SAMPLE_MS / 1000 for k in range(len(self.headings_deg))]

    def first_crossing_s(self) -> float:
        """When it first reached the setpoint; infinity when it never did."""
        for k, heading in enumerate(self.headings_deg):
            if heading >= self.angle_deg:
                return k * SAMPLE_MS / 1000
        return float("inf")

    def overshoot_deg(self) -> float:
        """How far beyond the setpoint it came, at least 0."""
        return max(0.0, max(self.headings_deg) - self.angle_deg)

    def error_deg(self, at_s: float) -> float:
        """Setpoint less heading at that time."""
        return self.angle_deg - self.headings_deg[round(at_s * 1000 / SAMPLE_MS)]

    def settled_s(self, within_deg: float) -> float:
        """The time from which it stayed that near to the setpoint; infinity when it never did."""
        for k in range(len(self.headings_deg) - 1, -1, -1):
            if abs(self.angle_deg - self.headings_deg[k]) > within_deg:
                last = k == len(self.headings_deg) - 1
                return float("inf") if last else (k + 1) * SAMPLE_MS / 1000
        return 0.0

    def swings(self, from_s: float, beyond_deg: float) -> int:
        """How often it went from beyond one side of the setpoint to beyond the other since then."""
        count, side = 0, 0
        for heading in self.headings_deg[round(from_s * 1000 / SAMPLE_MS) :]:
            error = self.angle_deg - heading
            if abs(error) > beyond_deg:
                now = 1 if error > 0 else -1
                count += side == -now
                side = now
        return count


def run(
    turn: Axis,
    reading: Reading,
    gains: Gains,
    seconds: float,
    cutoff_deg: float = 0.0,
    profile: str = "4.1",
) -> Trace:
    """The published turn of 10 degrees to the left: chair at `turn`, sensor 100 Hz, 15 ms late."""
    chair = Chair(profile, 1, replace(undisturbed(profile), turn=turn))
    imu = Imu(_SENSOR)
    controller = Prototype(reading, gains, ANGLE_DEG, cutoff_deg)
    # A controller of 100 Hz changes nothing between headings: coarser steps of the chair will do.
    step_ms = 1 if reading.rate_hz == 1000 else 5
    step_s = step_ms / 1000
    shown = 0.0
    stick = (0.0, 0.0)
    chair.step(step_s, stick)
    trace = Trace(ANGLE_DEG)
    for k in range(round(seconds * 1000 / step_ms)):
        if k * step_ms % SAMPLE_MS == 0:
            trace.headings_deg.append(chair.heading_deg)
            stick = (0.0, _STICKS[controller.update(shown)])
        elif step_ms == 1:
            stick = (0.0, _STICKS[controller.update(shown)])
        chair.step(step_s, stick)
        if imu.step(step_s, chair.yaw_rate_deg_s):
            shown = imu.heading_q4 / 16.0
    trace.headings_deg.append(chair.heading_deg)
    return trace
