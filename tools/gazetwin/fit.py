"""Searches for the chair behind the published turns: at random within the priors, then nearby."""

from __future__ import annotations

import math
import random
import time
from dataclasses import dataclass, replace
from functools import partial

from gazesim.chair_axis import Axis
from gazesim.profiles import PROFILES
from gazetwin.clues import Match, match
from gazetwin.prototype import Reading

# What is searched, and between which bounds. Dead time, deadband and lag: priors for power chairs.
# Ramps and friction: no prior is known for turning, the bounds are wide.
BOUNDS = {
    "dead_time_s": (0.08, 0.25),
    "deadband": (0.05, 0.15),
    "lag_s": (0.15, 0.45),
    "accelerate": (25.0, 300.0),
    "brake": (25.0, 400.0),
    "friction": (0.0, 5.0),
    "stiction": (0.0, 10.0),
}
_LOGARITHMIC = ("accelerate", "brake")
_NEAR = 0.06  # a step of the search nearby, as a share of the bounds
_POOL = 12


@dataclass(frozen=True)
class Candidate:
    """A chair that was tried, and how it matched."""

    shares: tuple[float, ...]
    """Its position within BOUNDS, 0..1 each."""
    match: Match

    def axis(self) -> Axis:
        """Its turn axis in profile 4.1."""
        return axis(self.shares)


def axis(shares: tuple[float, ...]) -> Axis:
    """The turn axis at these shares (0..1) of BOUNDS."""
    numbers = {}
    for (name, (low, high)), share in zip(BOUNDS.items(), shares, strict=True):
        if name in _LOGARITHMIC:
            numbers[name] = math.exp(math.log(low) + share * math.log(high / low))
        else:
            numbers[name] = low + share * (high - low)
    return replace(PROFILES["4.1"].turn, **numbers)


def search(reading: Reading, seconds: float, seed: int = 1) -> list[Candidate]:
    """Every chair whose clues were all checked, best first, after that much processor time."""
    source = random.Random(seed)
    tried: list[Candidate] = []
    pool: list[Candidate] = []
    until = time.process_time() + seconds
    while time.process_time() < until:
        explore = len(pool) < _POOL or source.random() < 0.3
        shares = tuple(
            source.random() if explore else _stepped(source, share)
            for share in (source.choice(pool).shares if pool else [0.5] * len(BOUNDS))
        )
        # Chairs not much worse than the best are kept too: they show how sharp the optimum is.
        worst = pool[-1].match.cost + 4.0 if len(pool) == _POOL else 30.0
        found = match(axis(shares), reading, partial(_hopeless, worst))
        if math.isinf(found.cost):
            continue
        tried.append(Candidate(shares, found))
        pool = sorted([*pool, tried[-1]], key=lambda c: (c.match.cost, source.random()))[:_POOL]
    return sorted(tried, key=lambda c: c.match.cost)


def _hopeless(worst: float, so_far: Match) -> bool:
    # The first two clues take 2.5 s of simulated time, the others a minute each.
    return so_far.cost > (worst if len(so_far.found) > 2 else min(worst, 4.0))


def _stepped(source: random.Random, share: float) -> float:
    return max(0.0, min(1.0, share + source.gauss(0.0, _NEAR) * (source.random() < 0.6)))


def slices(turn: Axis, reading: Reading, points: int = 25) -> dict[str, list[tuple[float, float]]]:
    """Around the chair `turn`, one number changed at a time within BOUNDS: (value, cost) each."""
    found = {}
    for name, (low, high) in BOUNDS.items():
        values = [low + (high - low) * k / (points - 1) for k in range(points)]
        near = [getattr(turn, name) * (1.0 + 0.01 * k) for k in range(-10, 11)]
        values = sorted(value for value in {*values, *near} if low <= value <= high)
        found[name] = [
            (value, match(replace(turn, **{name: value}), reading).cost) for value in values
        ]
    return found


def ranges(candidates: list[Candidate]) -> dict[str, tuple[float, float]]:
    """The lowest and highest value of each parameter among these chairs."""
    found = {}
    for name in BOUNDS:
        numbers = [getattr(c.axis(), name) for c in candidates]
        found[name] = (min(numbers), max(numbers))
    return found
