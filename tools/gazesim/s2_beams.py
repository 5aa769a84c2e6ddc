"""Simulated beams of an S2: range, noise, misses, a covered view, a frozen memory."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Distances in m along our angles (radians, counter-clockwise, 0 forward); inf for nothing.
Ranger = Callable[[Array], Array]

# What the chair itself blocks: (from deg, to deg, distance m), our angles.
CHAIR_ARCS = ((124.0, 236.0, 0.22),)
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
        self._last_turn: Array = np.zeros(0)
        self.covered_deg: tuple[float, float] | None = None
        self.frozen = False

    def measure(self, index: NDArray[np.int64], per_turn: int) -> tuple[Array, Array]:
        """(share of the turn 0..1, distance in mm) of the samples; distance 0 is no measurement."""
        place = index % per_turn
        turns = place / per_turn
        if len(self._last_turn) != per_turn:
            self._last_turn = np.zeros(per_turn)
        if self.frozen:
            return turns, self._last_turn[place]
        distances = self._look(turns)
        self._last_turn[place] = distances
        return turns, distances

    def _look(self, turns: Array) -> Array:
        random = self._random
        ours = -2.0 * math.pi * turns  # the mirror turns clockwise
        metres = np.asarray(self._ranger(ours), dtype=np.float64)
        degrees = np.degrees(ours) % 360.0
        for start, stop, distance in self.chair_arcs:
            metres = np.where((degrees >= start) & (degrees <= stop), distance, metres)
        noise = random.standard_normal(len(turns)) * self.noise_m
        seen = (metres >= _RANGE_M[0]) & (metres <= _RANGE_M[1])
        seen &= random.random(len(turns)) >= _MISSING
        metres = np.where(seen, metres + noise, 0.0)
        if self.speckle:
            stray = random.random(len(turns)) < self.speckle
            metres[stray] = random.uniform(*_SPECKLE_M, int(stray.sum()))
        if self.covered_deg is not None:
            first, last = self.covered_deg
            metres[(degrees - first) % 360.0 <= (last - first) % 360.0] = 0.0
        distances: Array = np.maximum(metres, 0.0) * 1000.0
        return distances
