"""Tunes the plain PID that the board's controller is compared with: the best of a grid of gains.

On the undisturbed chair of a profile, over all angles in both directions, all gains at once in
numpy: the least mean settling time (a turn that does not settle counts as SECONDS), plus a second
for each turn with an overshoot above 1 degree. `python -m gazemeasure.turn.plain` prints them.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from gazechair.base.arrays import FloatArray
from gazemeasure.turn.cases import ANGLES_DEG
from gazemeasure.turn.judge import FOR_MS, UNDER_DPS, WITHIN_DEG
from gazemeasure.turn.rivals import PlainGains
from gazesim.profiles import PROFILES, undisturbed

SECONDS = 9.0
_STEP_S = 0.005
_LATE_S = 0.015  # delay of the heading sensor
_KP = (150, 250, 400, 600, 900, 1400, 2000, 3000)
_KI = (0, 20, 80)
_KD = (0, 40, 80, 120, 160, 240, 320, 480, 640)
_CUTOFF = (8, 12)


def tuned(profile: str) -> PlainGains:
    """The best gains for `profile`."""
    gains = [PlainGains(*each) for each in product(_KP, _KI, _KD, _CUTOFF)]
    angles = [side * angle for angle in ANGLES_DEG for side in (1.0, -1.0)]
    costs = _costs(profile, gains, np.array(angles)[None, :])
    return gains[int(costs.argmin())]


def _costs(profile: str, gains: list[PlainGains], angles: FloatArray) -> FloatArray:
    axis = undisturbed(profile).turn
    kp, ki, kd, cutoff = (
        np.array([[getattr(g, name)] for g in gains]) / 16
        for name in ("kp_q4", "ki_q4", "kd_q4", "cutoff_q4")
    )
    shape = (len(gains), angles.shape[1])
    follow = 1.0 - np.exp(-_STEP_S / axis.lag_s)
    delay = round(axis.dead_time_s / _STEP_S)
    late = round(_LATE_S / _STEP_S)
    requested = [np.zeros(shape)] * (delay + 1)
    seen = [(np.zeros(shape), np.zeros(shape))] * (late + 1)
    ramp, speed, heading, total = (np.zeros(shape) for _ in range(4))
    since, settled = np.full(shape, np.inf), np.full(shape, SECONDS)
    over = np.zeros(shape)
    for step in range(round(SECONDS / _STEP_S)):
        shown, rate = seen.pop(0)
        error = angles - shown
        out = kp * error - kd * rate
        whole = out + total
        free = (np.abs(whole) < 1000) | (whole * error < 0)
        total = np.where(free, np.clip(total + ki * error * _STEP_S, -1000, 1000), total)
        out = np.where(np.abs(error) <= cutoff, 0.0, np.clip(out + total, -1000, 1000)) / 1000
        share = np.maximum(0.0, np.abs(out) - axis.deadband) / (1.0 - axis.deadband)
        requested.append(np.where(out > 0, axis.positive, -axis.negative) * share)
        wanted = requested.pop(0)
        faster = (np.abs(wanted) > np.abs(ramp)) & (wanted * ramp >= 0.0)
        change = np.where(faster, axis.accelerate, axis.brake) * _STEP_S
        ramp = ramp + np.clip(wanted - ramp, -change, change)
        before = speed
        speed = speed + (ramp - speed) * follow
        speed[(np.abs(speed) < axis.standstill) & (np.abs(ramp) < axis.standstill)] = 0.0
        heading = heading + 0.5 * _STEP_S * (before + speed)
        seen.append((heading, speed))
        miss = (heading - angles) * np.sign(angles)
        over = np.maximum(over, miss)
        good = (np.abs(miss) <= WITHIN_DEG) & (np.abs(speed) < UNDER_DPS)
        now = step * _STEP_S
        since = np.where(good, np.minimum(since, now), np.inf)
        settled = np.where(now - since >= FOR_MS / 1000, np.minimum(settled, since), settled)
    costs: FloatArray = (settled + (over > WITHIN_DEG)).mean(axis=1)
    return costs


if __name__ == "__main__":
    for name in PROFILES:
        print(name, tuned(name))
