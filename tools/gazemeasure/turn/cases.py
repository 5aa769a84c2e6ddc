"""The turns of the benchmark: the undisturbed grid, and random chairs."""

from __future__ import annotations

import random
from dataclasses import dataclass

from gazemeasure.turn.model import Case
from gazemeasure.turn.run import WARM_MS
from gazesim.imu_model import Imu, ImuErrors
from gazesim.profiles import PROFILES, identified, least_sticky, random_chair, undisturbed

ANGLES_DEG = (5, 10, 20, 45, 90)


@dataclass(frozen=True)
class Drawn:
    """One turn: its profile, and everything drawn from `case.seed`."""

    profile: str
    case: Case

    def imu(self) -> Imu:
        """Its heading sensor, new and at rest."""
        seed = self.case.seed
        return Imu(ImuErrors.drawn(random.Random(seed)), seed)


def grid() -> list[Drawn]:
    """Five profiles x five angles x both directions, undisturbed."""
    return [
        Drawn(profile, Case(undisturbed(profile), side * angle, seed=1 + number))
        for profile in PROFILES
        for number, angle in enumerate(ANGLES_DEG)
        for side in (1.0, -1.0)
    ]


def monte_carlo(count: int) -> list[Drawn]:
    """`count` chairs drawn by gazesim.profiles.random_chair, one turn each."""
    out = []
    for seed in range(1, count + 1):
        source = random.Random(-seed)
        profile = source.choice(tuple(PROFILES))
        angle = source.choice(ANGLES_DEG) * source.choice((1.0, -1.0))
        out.append(Drawn(profile, Case(random_chair(profile, seed), angle, seed, WARM_MS / 1000)))
    return out


def stepped() -> list[Drawn]:
    """Ten degrees, in both directions, in every profile on a typical floor: for ten steps."""
    return [
        Drawn(profile, Case(PROFILES[profile], side * 10.0, seed=20 + number))
        for number, profile in enumerate(PROFILES)
        for side in (1.0, -1.0)
    ]


def published() -> list[Drawn]:
    """The published turn of 10 degrees on 4.1, in both directions, on both chairs that fit the
    first prototype's figures."""
    return [
        Drawn("4.1", Case(chair("4.1"), side * 10.0))
        for chair in (identified, least_sticky)
        for side in (1.0, -1.0)
    ]
