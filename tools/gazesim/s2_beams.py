"""Simulated beams of an S2: range, noise, misses, a covered view, a frozen memory."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from gazechair.base.arrays import FloatArray, IntArray

# Distances in m along our angles (radians, counter-clockwise, 0 forward); inf for nothing.
Ranger = Callable[[FloatArray], FloatArray]

# What the chair itself blocks: (from deg, to deg, distance m), our angles.
Arcs = tuple[tuple[float, float, float], ...]
CHAIR_ARCS: Arcs = ((124.0, 236.0, 0.22),)
_RANGE_M = (0.05, 30.0)
_MISSING = 0.003  # share of points without a return
_SPECKLE_M = (0.1, 4.0)


class Beams:
    """The measuring part. Its faults are plain attributes.

    `noise_m`: standard deviation of a range. `speckle`: share of beams that return a false
    distance, as from dust or sunlight. `covered_deg`: (from, to), our angles, counter-
    clockwise, where the window is covered; None = nowhere. `frozen`: every turn equals the last.
    `chair_arcs`: as CHAIR_ARCS.
    """

    chair_arcs = CHAIR_ARCS
    noise_m = 0.006
    speckle = 0.0

    def __init__(self, ranger: Ranger, random: np.random.Generator) -> None:
        self._ranger = ranger
        self._random = random
        self._last_turn: FloatArray = np.zeros(0)
        self.covered_deg: tuple[float, float] | None = None
        self.frozen = False

    def measure(self, first: int, count: int, per_turn: int) -> tuple[FloatArray, FloatArray]:
        """(share of the turn 0..1, distance in mm) of samples `first` and on; 0: no measurement."""
        places, turns, ours, degrees = _directions(first % per_turn, count, per_turn)
        blocked = _blocked(first % per_turn, count, per_turn, self.chair_arcs)
        if len(self._last_turn) != per_turn:
            self._last_turn = np.zeros(per_turn)
        if self.frozen:
            return turns, self._last_turn[places]
        distances = self._look(ours, degrees, blocked)
        self._last_turn[places] = distances
        return turns, distances

    def _look(
        self, ours: FloatArray, degrees: FloatArray, blocked: FloatArray | None
    ) -> FloatArray:
        random, count = self._random, len(ours)
        metres = np.asarray(self._ranger(ours), dtype=np.float64)
        if blocked is not None:
            metres = np.where(np.isinf(blocked), metres, blocked)
        noise = random.standard_normal(count) * self.noise_m
        seen = (metres >= _RANGE_M[0]) & (metres <= _RANGE_M[1])
        seen &= random.random(count) >= _MISSING
        metres = np.where(seen, metres + noise, 0.0)
        if self.speckle:
            stray = random.random(count) < self.speckle
            metres[stray] = random.uniform(*_SPECKLE_M, int(stray.sum()))
        if self.covered_deg is not None:
            first, last = self.covered_deg
            metres[(degrees - first) % 360.0 <= (last - first) % 360.0] = 0.0
        distances: FloatArray = np.maximum(metres, 0.0) * 1000.0
        return distances


@lru_cache(maxsize=256)  # turn by turn the same; a mirror that was stopped goes on elsewhere
def _directions(
    first: int, count: int, per_turn: int
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """Of samples `first` and on: place in the turn, share of it, our angle in rad and in deg."""
    places = np.arange(first, first + count, dtype=np.int64) % per_turn
    turns = places / per_turn
    ours = -2.0 * math.pi * turns  # the mirror turns clockwise
    found = places, turns, ours, np.degrees(ours) % 360.0
    for array in found:
        array.flags.writeable = False  # everybody's
    return found


@lru_cache(maxsize=256)
def _blocked(first: int, count: int, per_turn: int, arcs: Arcs) -> FloatArray | None:
    """Of the same samples: how far in m the chair itself is, inf beside it; None: nowhere."""
    degrees = _directions(first, count, per_turn)[3]
    metres = np.full(count, np.inf)
    for start, stop, distance in arcs:
        metres[(degrees >= start) & (degrees <= stop)] = distance
    metres.flags.writeable = False
    return None if np.isinf(metres).all() else metres
