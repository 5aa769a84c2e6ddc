"""Turns a small picture into a plan of the floor ahead, and finds a line's colour on it.

A line is stored as contrast, not colour: logarithms of red, green and blue against the floor on
both sides. Effects on line and floor alike (shadow, lamp, exposure) cancel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gazechair.base.arrays import BoolArray, FloatArray, IntArray
from gazechair.picture.floor import FloorCamera

Picture = NDArray[np.uint8]

CELL_M = 0.015
FAR_M, BESIDE_M = 2.6, 1.1
_DARK = 6.0  # added to each channel, so that noise of dark pixels has no colour
_GLARE = 250
_MIDDLE_M = (-0.01, 0.0, 0.01)
_FLANKS_M = (0.07, 0.09, 0.11)  # tapes are 3 to 8 cm wide
_ALONG_M = (-0.04, 0.0, 0.04)
_LIGHT, _NOISE = 0.12, 0.06  # sigma of the logarithms: common to all channels, per channel
_TURNS = 18
_SLIDES_M = np.arange(-0.04, 0.041, 0.01)
_LEAST_SIGMAS = 2.0
_LEAST_SHARE = 0.5

# Reasons, keys of the string tables.
NOT_SEEN, NO_LINE = "line_not_seen", "line_no_line"


@dataclass(frozen=True)
class Plan:
    """`logs`: (nx, ny, 3) logarithms, nan where the camera does not see; `glare`: (nx, ny)."""

    logs: FloatArray
    glare: BoolArray
    near_m: float

    def at(self, points_m: FloatArray) -> FloatArray:
        """Logarithms (..., 3) at points (..., 2) in the chair's frame; nan outside."""
        i, j, inside = self._cells(points_m)
        found = self.logs[i, j]
        found[~inside] = np.nan
        return np.asarray(found)

    def seen(self, points_m: FloatArray) -> BoolArray:
        """Which points the picture shows."""
        return np.asarray(np.isfinite(self.at(points_m)[..., 0]))

    def glares(self, points_m: FloatArray) -> BoolArray:
        """Which points are too bright to have a colour."""
        i, j, inside = self._cells(points_m)
        return np.asarray(self.glare[i, j] & inside)

    def _cells(self, points_m: FloatArray) -> tuple[IntArray, IntArray, BoolArray]:
        cells = np.floor((points_m - (self.near_m, -BESIDE_M)) / CELL_M).astype(np.int64)
        i, j = cells[..., 0], cells[..., 1]
        nx, ny = self.glare.shape
        inside = (i >= 0) & (i < nx) & (j >= 0) & (j < ny)
        return np.clip(i, 0, nx - 1), np.clip(j, 0, ny - 1), inside


class PlanMaker:
    """Makes plans from one camera's pictures, all of one size."""

    def __init__(self, camera: FloorCamera) -> None:
        ahead = np.arange(0.3, FAR_M, CELL_M)
        seen = camera.sees(np.column_stack((ahead, np.zeros(len(ahead)))))
        if not seen.any():
            raise ValueError("the camera does not see the floor before the chair")
        self.near_m = float(ahead[seen.argmax()])
        xs = np.arange(self.near_m, FAR_M, CELL_M) + 0.5 * CELL_M
        ys = np.arange(-BESIDE_M, BESIDE_M, CELL_M) + 0.5 * CELL_M
        centres = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=2).reshape(-1, 2)
        self._shape = (len(xs), len(ys))
        self._seen = camera.sees(centres)
        at = np.nan_to_num(camera.pixels(centres)) - 0.5
        self._size = (camera.height_px, camera.width_px)
        most = np.array((camera.width_px, camera.height_px)) - 1.001
        at = np.clip(at, 0.0, most)
        corner = at.astype(np.int64)
        share = (at - corner).astype(np.float32)
        u, v = share[:, :1], share[:, 1:]
        self._first = corner[:, 1] * camera.width_px + corner[:, 0]
        self._shares = ((1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v)

    def fits(self, picture: Picture) -> bool:
        """True if `picture` has the camera's size."""
        return picture.shape == (*self._size, 3)

    def __call__(self, picture: Picture) -> Plan:
        """`picture`: (height, width, 3), red, green, blue. ValueError for another size."""
        if not self.fits(picture):
            raise ValueError(f"a picture of {picture.shape}, not {self._size}")
        flat = picture.reshape(-1, 3)
        logs = np.log(flat.astype(np.float32) + np.float32(_DARK))
        width = self._size[1]
        corners = [self._first + step for step in (0, 1, width, width + 1)]
        shown = sum(
            share * logs[corner] for share, corner in zip(self._shares, corners, strict=True)
        )
        found = np.asarray(shown, dtype=np.float64)
        found[~self._seen] = np.nan
        glare = (flat.min(axis=1) >= _GLARE)[self._first]
        shape = self._shape
        return Plan(found.reshape(*shape, 3), glare.reshape(shape), self.near_m)


@dataclass(frozen=True)
class LineColour:
    """A line's contrast to the floor on both sides: (3,), whitened, and its length."""

    contrast: FloatArray
    sigmas: float

    def score(self, plan: Plan, points_m: FloatArray, heading_rad: FloatArray) -> FloatArray:
        """How much each point (..., 2) looks like the line: 1 the same, 0 floor, nan unseen.

        `heading_rad` (...): along the line. An edge has the floor on one side only: it counts 0.
        """
        sides = _contrasts(plan, points_m, heading_rad) @ _WHITEN
        off = np.linalg.norm(sides - self.contrast, axis=-1) / self.sigmas
        return np.asarray(1.0 - off.max(axis=-1))


def _whitening() -> FloatArray:
    covariance = _LIGHT**2 * np.ones((3, 3)) + _NOISE**2 * np.eye(3)
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors / np.sqrt(values) @ vectors.T)


_WHITEN = _whitening()


def _contrasts(plan: Plan, points_m: FloatArray, heading_rad: FloatArray) -> FloatArray:
    """Contrasts (..., 2, 3): to the left side, to the right side."""
    left = np.stack((-np.sin(heading_rad), np.cos(heading_rad)), axis=-1)[..., None, :]
    steps = np.array((*_MIDDLE_M, *_FLANKS_M, *(-d for d in _FLANKS_M)))
    at = plan.at(points_m[..., None, :] + steps[:, None] * left)
    middle, one, other = (at[..., k : k + 3, :].mean(axis=-2) for k in (0, 3, 6))
    return np.stack((middle - one, middle - other), axis=-2)


def chosen(plan: Plan, point_m: FloatArray) -> tuple[LineColour, FloatArray, float] | str:
    """The line at a tapped point: colour, a point of it, its heading; or the reason for none."""
    turns = np.arange(_TURNS) * math.pi / _TURNS
    heading = np.repeat(turns, len(_SLIDES_M))
    slide = np.tile(_SLIDES_M, _TURNS)
    forward = np.column_stack((np.cos(heading), np.sin(heading)))
    left = np.column_stack((-forward[:, 1], forward[:, 0]))
    centres = point_m + slide[:, None] * left
    along = centres[:, None, :] + np.array(_ALONG_M)[:, None] * forward[:, None, :]
    found = _contrasts(plan, along, np.repeat(heading[:, None], len(_ALONG_M), axis=1)) @ _WHITEN
    found = found.reshape(len(heading), -1, 3)
    if not np.isfinite(found).all(axis=(1, 2)).any():
        return NOT_SEEN
    mean = found.mean(axis=1)
    length = np.linalg.norm(mean, axis=1)
    # A line contrasts alike on both sides and along it, at the tap or close to it.
    spread = np.linalg.norm(found - mean[:, None, :], axis=2).max(axis=1)
    value = np.nan_to_num(length - spread - 10.0 * np.abs(slide), nan=-np.inf)
    best = int(value.argmax())
    if length[best] < _LEAST_SIGMAS or spread[best] > _LEAST_SHARE * length[best]:
        return NO_LINE
    colour = LineColour(mean[best], float(length[best]))
    return colour, np.asarray(centres[best]), float(heading[best])
