"""The floor as a camera on the chair sees it: tape, rugs, light, noise; one ray per pixel.

Its camera model uses three rotation matrices and shares nothing with the host's.
"""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from gazechair.base.arrays import BoolArray, FloatArray

Picture = NDArray[np.uint8]

_CELL_M = 0.01
_ROUND_M = 4.0  # of bare floor around everything that lies on it
_GAMMA_STEPS = 1024
_GAMMA = (
    255.0 * np.clip(1.25 * np.arange(_GAMMA_STEPS + 1) / _GAMMA_STEPS, 0, 1) ** (1 / 2.2)
).astype(np.float32)


@dataclass(frozen=True)
class Eye:
    """The camera's place on the chair, and its direction in degrees: down, left, clockwise."""

    width_px: int = 320
    height_px: int = 240
    field_deg: float = 75.0
    height_m: float = 1.15
    down_deg: float = 30.0
    left_deg: float = 0.0
    clockwise_deg: float = 0.0
    forward_m: float = 0.30
    leftward_m: float = 0.0
    radial: float = 0.0

    def rays(self) -> FloatArray:
        """(height, width, 3): the direction of each pixel, chair's frame."""
        focal = 0.5 * self.width_px / math.tan(math.radians(self.field_deg / 2.0))
        u = (np.arange(self.width_px) + 0.5 - 0.5 * self.width_px) / focal
        v = (np.arange(self.height_px) + 0.5 - 0.5 * self.height_px) / focal
        right, below = np.meshgrid(u, v)
        seen = np.hypot(right, below)
        true = seen.copy()
        for _ in range(20):  # Newton: seen = true (1 + radial true^2)
            true -= (true * (1.0 + self.radial * true**2) - seen) / (
                1.0 + 3.0 * self.radial * true**2
            )
        stretch = np.where(seen > 0.0, true / np.maximum(seen, 1e-12), 1.0)
        rays = np.stack((np.ones_like(right), -right * stretch, -below * stretch), axis=2)
        turn = _about(2, self.left_deg) @ _about(1, self.down_deg) @ _about(0, self.clockwise_deg)
        return np.asarray(rays @ turn.T)

    def pixel(self, x_m: float, y_m: float) -> tuple[float, float]:
        """The pixel of a floor point in the chair's frame, by the inverse of the same matrices."""
        turn = _about(2, self.left_deg) @ _about(1, self.down_deg) @ _about(0, self.clockwise_deg)
        x, y, z = turn.T @ (x_m - self.forward_m, y_m - self.leftward_m, -self.height_m)
        focal = 0.5 * self.width_px / math.tan(math.radians(self.field_deg / 2.0))
        a, b = -y / x, -z / x
        share = 1.0 + self.radial * (a * a + b * b)
        return 0.5 * self.width_px + focal * a * share, 0.5 * self.height_px + focal * b * share


def _about(axis: int, degrees: float) -> FloatArray:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    if axis == 0:  # clockwise, seen from behind: left goes up
        return np.array(((1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c)))
    if axis == 1:  # forward goes down
        return np.array(((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)))
    return np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))


@dataclass
class Floor:
    """The floor and what lies on it, metres; colours as reflectance 0..1."""

    colour: tuple[float, float, float] = (0.45, 0.33, 0.22)
    tape: tuple[float, float, float] = (0.06, 0.18, 0.55)
    tape_m: float = 0.05
    lines: list[FloatArray] = field(default_factory=list)
    """Polylines (N, 2) of tape."""
    gaps: list[tuple[float, float, float]] = field(default_factory=list)
    """x, y, radius: no tape there."""
    rugs: list[tuple[float, float, float, float, tuple[float, float, float]]] = field(
        default_factory=list
    )
    """x, y, half sizes, colour; under the tape."""
    shadows: list[tuple[float, float, float, float]] = field(default_factory=list)
    """x, y, radius, remaining share of the light."""
    glare: tuple[float, float, float] | None = None
    """x, y before the chair, radius: the reflection of a lamp moves with the chair."""
    light: tuple[float, float, float] = (1.0, 1.0, 1.0)
    texture: float = 0.05
    noise: float = 3.0
    quality: int = 75


class FloorView:
    """Pictures of one floor by one camera."""

    def __init__(self, eye: Eye, floor: Floor, seed: int = 1) -> None:
        self.eye, self.floor = eye, floor
        self._random = np.random.default_rng(seed)
        rays = eye.rays()
        down = rays[..., 2] < -1e-3
        far = np.where(down, -eye.height_m / np.minimum(rays[..., 2], -1e-3), np.inf)
        self._down = down & (far < 12.0)
        self._near = rays[self._down][:, :2] * far[self._down][:, None] + (
            eye.forward_m,
            eye.leftward_m,
        )
        if floor.glare is not None:
            gx, gy, radius = floor.glare
            away = np.hypot(self._near[:, 0] - gx, self._near[:, 1] - gy) / radius
            self._glare = (2.0 * np.exp(-(away**4)))[:, None].astype(np.float32)
        self._noise = self._random.normal(0.0, floor.noise, 4 * 3 * self._down.size).astype(
            np.float32
        )
        self._all = list(floor.lines)
        self.paint()

    def picture(self, x_m: float, y_m: float, heading_deg: float, width_px: int) -> Picture:
        """(height, width, 3) bytes as the host gets them: from JPEG, reduced to `width_px`."""
        jpeg = io.BytesIO(self.jpeg(x_m, y_m, heading_deg))
        image = Image.open(jpeg).convert("RGB")
        size = (width_px, round(width_px * self.eye.height_px / self.eye.width_px))
        return np.asarray(image.resize(size, Image.Resampling.BOX))

    def jpeg(self, x_m: float, y_m: float, heading_deg: float) -> bytes:
        """The picture as the camera sends it, with noise."""
        floor = self.floor
        c, s = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
        at = self._near @ np.array(((c, s), (-s, c))) + (x_m, y_m)
        cells = np.floor((at - self._low) / _CELL_M).astype(np.int64)
        nx, ny = self._painted.shape[:2]
        cells = np.clip(cells, 0, (nx - 1, ny - 1))
        colour = self._painted[cells[:, 0], cells[:, 1]]
        if floor.glare is not None:
            colour = colour + self._glare
        image = np.full((*self._down.shape, 3), 120.0, dtype=np.float32)
        image[self._down] = _GAMMA[np.minimum(colour * _GAMMA_STEPS, _GAMMA_STEPS).astype(np.int64)]
        start = int(self._random.integers(0, len(self._noise) - image.size))
        image += self._noise[start : start + image.size].reshape(image.shape)
        out = io.BytesIO()
        pixels = np.clip(image, 0, 255).astype(np.uint8)
        Image.fromarray(pixels).save(out, "JPEG", quality=floor.quality)
        return out.getvalue()

    def paint(self) -> None:
        """Paint the whole floor from above; call after a change of `floor`."""
        floor, random = self.floor, self._random
        ends = np.concatenate([*self._all, np.zeros((1, 2))])
        self._low = ends.min(axis=0) - _ROUND_M
        nx, ny = np.ceil((ends.max(axis=0) + _ROUND_M - self._low) / _CELL_M).astype(int)
        xs, ys = (self._low[k] + (np.arange(n) + 0.5) * _CELL_M for k, n in ((0, nx), (1, ny)))
        painted = np.tile(np.array(floor.colour, dtype=np.float32), (nx, ny, 1))
        for rx, ry, half_x, half_y, rug in floor.rugs:
            on = (np.abs(xs - rx) < half_x)[:, None] & (np.abs(ys - ry) < half_y)
            painted[on] = rug
        coarse = random.normal(0.0, floor.texture, ((nx + 1) // 2, (ny + 1) // 2))
        texture = np.exp(np.repeat(np.repeat(coarse, 2, axis=0), 2, axis=1)[:nx, :ny])
        painted *= texture[..., None].astype(np.float32)
        painted[self._tape(xs, ys)] = floor.tape
        for sx, sy, radius, share in floor.shadows:
            away = np.hypot((xs - sx)[:, None], ys - sy)
            painted *= (1.0 - (1.0 - share) * np.clip((radius - away) / 0.06 + 0.5, 0, 1))[
                ..., None
            ].astype(np.float32)
        self._painted = painted * np.array(floor.light, dtype=np.float32)

    def _tape(self, xs: FloatArray, ys: FloatArray) -> BoolArray:
        floor = self.floor
        found = np.zeros((len(xs), len(ys)), dtype=np.bool_)
        reach = floor.tape_m
        for line in floor.lines:
            for a, b in pairwise(line):
                low, high = np.minimum(a, b) - reach, np.maximum(a, b) + reach
                i = slice(*np.searchsorted(xs, (low[0], high[0])))
                j = slice(*np.searchsorted(ys, (low[1], high[1])))
                near = np.stack(np.meshgrid(xs[i], ys[j], indexing="ij"), axis=2)
                off = distance_to_line_m(np.array((a, b)), near.reshape(-1, 2))
                found[i, j] |= off.reshape(near.shape[:2]) < 0.5 * floor.tape_m
        for x, y, radius in floor.gaps:
            found &= np.hypot((xs - x)[:, None], ys - y) > radius
        return found


def distance_to_line_m(
    line: FloatArray | Sequence[tuple[float, float]], points: FloatArray
) -> FloatArray:
    """Distances (N,) of points (N, 2) to a polyline."""
    least = np.full(len(points), np.inf)
    ends = np.asarray(line)
    for a, b in pairwise(ends):
        side = b - a
        share = np.clip((points - a) @ side / (side @ side), 0.0, 1.0)
        least = np.minimum(least, np.hypot(*(points - a - share[:, None] * side).T))
    return least
