"""Fits a lidar's points to the remembered surfaces: iterated least squares with a prior."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray
from gazechair.sensing.odometry.apart import CORRELATED, Constraints, together
from gazechair.sensing.odometry.local_map import LocalMap, layers_of
from gazechair.sensing.odometry.points import between, on_flat, stand_alone
from gazechair.sensing.odometry.straight import as_seen, main_direction, straightened

# The state: x, y (m), offset of the heading (rad), speeds forward and sideways (m/s), the speed of
# a full command (m/s), and the error of this one heading (rad).
X, Y, OFFSET, FORWARD, SIDEWAYS, FULL, ERROR = range(7)
STATES = 7

# The heading that a match sees is the offset and this heading's error together.
_SPREAD = np.zeros((3, STATES))
_SPREAD[0, X] = _SPREAD[1, Y] = _SPREAD[2, OFFSET] = _SPREAD[2, ERROR] = 1.0

_ITERATIONS, _COARSE = 8, 3  # the first with coarse surfaces, the rest with fine ones
_SETTLED_M, _SETTLED_RAD = 2e-4, 1e-4
_NOISE_M = 0.015
_NOISE_PER_M = 0.002
_FEW = 5.0  # points: fewer in a cell's square are no surface
_FLAT = 8.0  # a surface's length in proportion to its depth, variances
_SCATTERS = 0.0045  # of the distance, what one beam shows of a surface: the heading is not exact
_POST_M = 0.05  # something compact is smaller
_OFF_SIGMAS, _MOST_OFF_RAD = 2.5, math.radians(15.0)  # of a surface's direction
_LOOSE_M, _TIGHT_M = 0.25, 0.08  # scale beyond which a point counts less: first round, last round
# Of an open direction: a surface that faces it more than this, the cosine, is left out; and a
# chair that points along it more than this drives along it.
_FACES, _ALONG = 0.2, 0.9


@dataclass(frozen=True)
class Fit:
    """The state after a match, and how well it is determined."""

    state: FloatArray
    covariance: FloatArray
    information: FloatArray
    """(2, 2), of x and y by this match alone, the heading being free within its own error."""
    matched: float
    """Share of the points that lie on a remembered surface, 0..1."""
    known: float
    """Share of the points where a surface is remembered nearby."""
    constraints: Constraints
    """What this match alone tells, with what is in open directions."""
    sees_speed: bool
    """Whether it tells the speed forward."""
    open_axes: tuple[FloatArray, ...]
    """(2,) each, the directions of the position that are open."""


def fit(
    coarse: LocalMap,
    fine: LocalMap,
    points: FloatArray,
    normals: FloatArray,
    prior: FloatArray,
    covariance: FloatArray,
    heading_rad: float,
    before: list[Constraints],
    learns: bool,
) -> Fit:
    """Fit `points` (chair's frame) starting at the state `prior` with its `covariance`.

    `before`: what earlier pieces of the same turn tell. `learns`: whether the speed of a full
    command may change.
    """
    alone, flat, inner = stand_alone(points), on_flat(points), between(points)
    state = prior.copy()
    distance = np.hypot(points[:, 0], points[:, 1])
    variance = (_NOISE_M + _NOISE_PER_M * distance) ** 2
    for iteration in range(_ITERATIONS):
        angle = heading_rad + state[OFFSET] + state[ERROR]
        c, s = math.cos(angle), math.sin(angle)
        rotation = np.array(((c, s), (-s, c)))
        turned = points @ rotation
        if iteration == 0:
            layers = layers_of(normals @ rotation)
            facing = np.where(flat, np.arctan2(normals[:, 1], normals[:, 0]) + angle, np.nan)
        surfaces = coarse if iteration < _COARSE else fine
        moments, centres = surfaces.look_up(turned + state[:2], layers)
        rows, residuals, spread = _rows(moments, centres, turned, state[:2], alone, (facing, inner))
        loose = _LOOSE_M if iteration < _COARSE else _TIGHT_M
        robust = 1.0 / (1.0 + (residuals / loose) ** 2) ** 2
        which = spread[1]
        strength = robust / ((spread[0] + variance[which]) * CORRELATED)
        if iteration in (0, _COARSE):
            constraints = Constraints(rows, turned[which] + state[:2], strength)
            open_axes = together([*before, constraints]).open_axes()
            free, kept = _free_and_kept(open_axes, np.array((c, s)), learns)
            weight = np.linalg.inv(free.T @ covariance @ free)
            state = prior + free @ (free.T @ (state - prior))
        for axis in open_axes:
            strength = strength * (np.abs(rows @ axis) < _FACES)
            rows = rows - np.outer(rows @ axis, axis)
        jacobian = _jacobian(rows, turned[which])
        seen = (jacobian.T * strength) @ jacobian
        gradient = jacobian.T @ (strength * residuals)
        whole = weight + free.T @ _SPREAD.T @ seen @ _SPREAD @ free
        pull = weight @ free.T @ (prior - state) + free.T @ _SPREAD.T @ gradient
        step = free @ np.linalg.solve(whole, pull)
        state += step
        settled = abs(step[X]) + abs(step[Y]) < _SETTLED_M and abs(step[OFFSET]) < _SETTLED_RAD
        if settled and iteration >= _COARSE:
            break
    count = max(1, len(points))
    near = np.zeros(len(points), dtype=np.bool_)
    near[which[np.abs(residuals) < 2.0 * _TIGHT_M]] = True
    known = np.count_nonzero(moments[:, 0] >= _FEW) / count
    freedom = seen[2, 2] + np.linalg.inv(covariance)[OFFSET, OFFSET]
    information = seen[:2, :2] - np.outer(seen[:2, 2], seen[2, :2]) / freedom
    sees_speed = not kept[FORWARD].any()
    # The directions that are kept have their own covariance still, and less of the common one.
    found = np.linalg.inv(whole)
    left = free @ found @ weight @ free.T + kept @ kept.T
    after = left @ covariance @ left.T
    after += free @ (found - found @ weight @ found) @ free.T
    return Fit(
        state,
        after,
        information,
        float(near.sum()) / count,
        float(known),
        constraints,
        sees_speed,
        tuple(open_axes),
    )


def _free_and_kept(
    open_axes: list[FloatArray], ahead: FloatArray, learns: bool
) -> tuple[FloatArray, FloatArray]:
    """Orthonormal directions of the state, (STATES, N) each: those a fit may change, and the rest.

    Nothing tells the speeds of a chair that drives in an open direction either.
    """
    eye = np.eye(STATES)
    along = any(abs(axis @ ahead) > _ALONG for axis in open_axes)
    still = [FORWARD, FULL] if along else [] if learns else [FULL]
    kept = eye[:, still]
    if not open_axes:
        return eye[:, [at for at in range(STATES) if at not in still]], kept
    for axis in open_axes:
        place = np.zeros((STATES, 1))
        place[:2, 0] = axis
        kept = np.hstack((kept, place))
    # The complement: the last columns of a full orthonormal basis that begins with `kept`.
    return np.linalg.qr(kept, mode="complete")[0][:, kept.shape[1] :], kept


def lie_on(surfaces: LocalMap, points: FloatArray, normals: FloatArray) -> BoolArray:
    """(N,): which points, with those normals, lie on a remembered surface."""
    moments, centres = surfaces.look_up(points, layers_of(normals))
    alone = np.ones(len(points), dtype=np.bool_)
    _, residuals, (_, which) = _rows(moments, centres, points, np.zeros(2), alone, None)
    lie = np.zeros(len(points), dtype=np.bool_)
    lie[which[np.abs(residuals) < _TIGHT_M]] = True
    return lie


def _rows(
    moments: FloatArray,
    centres: FloatArray,
    turned: FloatArray,
    at: FloatArray,
    alone: BoolArray,
    seen_there: tuple[FloatArray, BoolArray] | None,
) -> tuple[FloatArray, FloatArray, tuple[FloatArray, np.ndarray]]:
    """Directions, residuals, (variance, which point): flat surfaces across, posts both ways.

    `alone`: which points may be on a post; `seen_there`: directions of the points' normals,
    radians, NaN: not known, and which have both neighbours nearby; None: what is remembered counts.
    """
    count = np.maximum(moments[:, 0], 1.0)
    mean = moments[:, 1:3] / count[:, None]
    xx = moments[:, 3] / count - mean[:, 0] ** 2
    xy = moments[:, 4] / count - mean[:, 0] * mean[:, 1]
    yy = moments[:, 5] / count - mean[:, 1] ** 2
    half = 0.5 * (xx + yy)
    root = np.hypot(0.5 * (xx - yy), xy)
    large, small = half + root, np.maximum(half - root, 0.0)
    enough = moments[:, 0] >= _FEW
    flat = np.flatnonzero(enough & (large > _FLAT * small) & (large > 4e-4))
    post = np.flatnonzero(enough & (large < _POST_M**2) & (large <= _FLAT * small) & alone)
    off = centres + mean - turned - at
    # The direction of least variance.
    angle = 0.5 * np.arctan2(2.0 * xy[flat], xx[flat] - yy[flat]) + 0.5 * math.pi
    off_rad = _OFF_SIGMAS * np.sqrt((small[flat] + _NOISE_M**2) / (large[flat] * count[flat]))
    main_rad = main_direction(angle, np.sqrt(large[flat]))
    own_rad = straightened(angle, np.minimum(off_rad, _MOST_OFF_RAD), main_rad)
    angle = own_rad
    if seen_there is not None:
        facing, inner = seen_there
        by_several = inner[flat] | (large[flat] > (_SCATTERS * np.hypot(*turned[flat].T)) ** 2)
        angle = as_seen(own_rad, facing[flat], by_several, main_rad)
    across = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    # A surface is deeper across another direction than its own.
    depth = small[flat] + (large[flat] - small[flat]) * np.sin(angle - own_rad) ** 2
    ones = np.zeros((2, len(post), 2))
    ones[0, :, 0] = ones[1, :, 1] = 1.0
    rows = np.concatenate((across, ones[0], ones[1]))
    which = np.concatenate((flat, post, post))
    residuals = (rows * off[which]).sum(axis=1)
    variance = np.concatenate((depth, large[post], large[post]))
    return rows, residuals, (variance, which)


def _jacobian(rows: FloatArray, turned: FloatArray) -> FloatArray:
    # Of where a point lies along its row, by x, y and the heading.
    return np.column_stack((rows, rows[:, 1] * turned[:, 0] - rows[:, 0] * turned[:, 1]))
