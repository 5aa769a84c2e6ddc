"""Traces a line over the plan of the floor, step by step: straight on at junctions, across gaps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.following.line_view import LineColour, Plan

STEP_M = 0.04
_BENDS_RAD = np.radians((-24.0, -12.0, 0.0, 12.0, 24.0))
_SLIDES_M = np.arange(-0.05, 0.051, 0.01)
_AHEAD_M = np.array((0.0, 0.03, 0.06))
_CORNERS_RAD = np.radians((-105.0, -90.0, -75.0, -60.0, -45.0, 45.0, 60.0, 75.0, 90.0, 105.0))
_CORNER_AHEAD_M = np.arange(0.06, 0.24, 0.03)
_LEAST, _LEAST_CORNER = 0.4, 0.55
_PER_BEND, _PER_SLIDE = 0.25, 2.0  # subtracted from the score per radian and per metre
_GAP_M, _GLARE_M = 0.20, 0.5
_LONGEST = 90
_SMOOTH = 0.6  # weight of the new heading


@dataclass(frozen=True)
class Trace:
    """Points (N, 2) in the chair's frame, and how the trace ended."""

    points_m: FloatArray
    ended: bool
    """True if visible floor follows the line's end; False if the view ends or glare begins."""


def trace(plan: Plan, colour: LineColour, start_m: FloatArray, heading_rad: float) -> Trace:
    """Trace from `start_m`, at or near the line, in the direction `heading_rad`."""
    at, heading = np.asarray(start_m, dtype=np.float64), heading_rad
    found: list[FloatArray] = []
    last = (at, heading)
    gap = glare = 0.0
    ended = False
    for _ in range(_LONGEST):
        best = _best(plan, colour, at, heading, _BENDS_RAD, _SLIDES_M, _AHEAD_M)
        if best is not None:
            at, bent = best
            if found:
                bent = math.atan2(*(at - found[-1])[::-1]) if gap else bent
            heading += _SMOOTH * math.remainder(bent - heading, 2.0 * math.pi)
            found.append(at)
            last, gap, glare = (at, heading), 0.0, 0.0
        elif plan.glares(at[None])[0] and glare < _GLARE_M:
            glare += STEP_M
        elif not plan.seen(at[None])[0]:
            break
        elif gap < _GAP_M:
            gap += STEP_M
        else:
            corner = _corner(plan, colour, *last)
            if corner is None or not found:
                ended = not glare
                break
            at, heading = corner
            gap = 0.0
        at = at + STEP_M * np.array((math.cos(heading), math.sin(heading)))
    return Trace(np.array(found).reshape(-1, 2), ended and bool(found))


def _corner(
    plan: Plan, colour: LineColour, at: FloatArray, heading: float
) -> tuple[FloatArray, float] | None:
    """Point and heading where the line continues to a side; None: it does not."""
    slides = _SLIDES_M[2:-2]
    return _best(plan, colour, at, heading, _CORNERS_RAD, slides, _CORNER_AHEAD_M, _LEAST_CORNER)


def _best(
    plan: Plan,
    colour: LineColour,
    at: FloatArray,
    heading: float,
    bends: FloatArray,
    slides: FloatArray,
    ahead: FloatArray,
    least: float = _LEAST,
) -> tuple[FloatArray, float] | None:
    """The most likely point and heading around `at`; None: no line."""
    headings = heading + bends
    forward = np.stack((np.cos(headings), np.sin(headings)), axis=1)
    left = np.stack((-forward[:, 1], forward[:, 0]), axis=1)
    origins = at + slides[None, :, None] * left[:, None, :]
    points = origins[:, :, None, :] + ahead[:, None] * forward[:, None, None, :]
    along = np.broadcast_to(headings[:, None, None], points.shape[:-1])
    score = colour.score(plan, points, along)
    value = np.nan_to_num(score, nan=0.0).mean(axis=2)
    penalty = _PER_BEND * np.abs(bends)[:, None] + _PER_SLIDE * np.abs(slides)[None, :]
    bend, _ = np.unravel_index(int((value - penalty).argmax()), value.shape)
    if value[bend].max() < least:
        return None
    # The line's middle, interpolated between the slides of that heading.
    weight = np.maximum(value[bend] - 0.5 * _LEAST, 0.0) * np.exp(-((np.abs(slides) / 0.04) ** 2))
    middle = float((weight * slides).sum() / max(weight.sum(), 1e-9))
    return at + middle * left[bend], float(headings[bend])
