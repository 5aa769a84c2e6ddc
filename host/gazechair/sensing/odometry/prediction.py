"""The state and its covariance a moment later, before the lidars are asked."""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.sensing.odometry.match import (
    ERROR,
    FORWARD,
    FULL,
    OFFSET,
    SIDEWAYS,
    STATES,
    X,
    Y,
)
from gazechair.sensing.odometry.speed_by_command import Change

_HEADING_ERROR_RAD = math.radians(0.1)
_DRIFT_RAD_S = math.radians(0.02)
_SCALE = 0.006  # of a turn
_SIDEWAYS_M_S, _SIDEWAYS_S = 0.05, 0.3  # sideways slip of a chair, and its duration


def predict(
    before: FloatArray,
    covariance: FloatArray,
    heading_rad: float,
    turn: float,
    speed: Change,
    dt: float,
) -> tuple[FloatArray, FloatArray]:
    """`heading_rad`: of the sensor, before it turned by `turn` rad within `dt` s."""
    angle = heading_rad + 0.5 * turn + before[OFFSET]
    c, s = math.cos(angle), math.sin(angle)
    forward, sideways = before[FORWARD], before[SIDEWAYS]
    fades = math.exp(-dt / _SIDEWAYS_S)
    state = before.copy()
    state[X] += (c * forward - s * sideways) * dt
    state[Y] += (s * forward + c * sideways) * dt
    state[SIDEWAYS] *= fades
    state[FORWARD] += speed.speed_m_s
    state[ERROR] = 0.0
    change = np.eye(STATES)
    change[X, FORWARD], change[X, SIDEWAYS] = c * dt, -s * dt
    change[Y, FORWARD], change[Y, SIDEWAYS] = s * dt, c * dt
    change[X, OFFSET], change[Y, OFFSET] = -(s * forward) * dt, (c * forward) * dt
    change[SIDEWAYS, SIDEWAYS] = fades
    change[FORWARD, FORWARD], change[FORWARD, FULL] = speed.by_speed, speed.by_full
    change[ERROR, ERROR] = 0.0
    covariance = change @ covariance @ change.T
    slip = _SIDEWAYS_M_S**2 * (1.0 - fades**2)
    gain = np.zeros((STATES, 2))
    gain[X], gain[Y] = (0.5 * c * dt, -0.5 * s * dt), (0.5 * s * dt, 0.5 * c * dt)
    gain[FORWARD, 0] = gain[SIDEWAYS, 1] = 1.0
    covariance += gain @ np.diag((speed.q * dt, slip)) @ gain.T
    covariance[OFFSET, OFFSET] += (_DRIFT_RAD_S * dt) ** 2 + (_SCALE * turn) ** 2
    covariance[FULL, FULL] += 1e-5 * dt + speed.full_variance
    covariance[ERROR, ERROR] = _HEADING_ERROR_RAD**2
    covariance[X, X] += 1e-8
    covariance[Y, Y] += 1e-8
    covariance[OFFSET, OFFSET] += 1e-10
    return state, covariance
