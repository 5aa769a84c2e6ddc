"""People as a lidar near the floor sees them: several gaits, each as discs around a position.

`plain` swings both legs like the homes' walkers. The tracker was not developed with the others:
feet that stand while the body passes over them (60 % of a stride; legs of unequal width), a skirt,
a cane, a rollator.
"""

from __future__ import annotations

import math
import random

from gazesim.homes import Walker

PLAIN = "plain"
FOREIGN = ("planted", "planted", "skirt", "cane", "rollator")
_STANDS = 0.6  # of a stride
_STRIDE_M = 0.35
Disc = tuple[float, float, float]


class Actor(Walker):
    """A person moved by `go`, with legs by their gait."""

    def __init__(self, x_m: float, y_m: float, gait: str, chance: random.Random) -> None:
        super().__init__(((x_m, y_m),))
        self.gait = gait
        self.heading_rad = chance.uniform(-math.pi, math.pi)
        self._way_m = chance.uniform(0.0, 1.0)
        self._stride_m = (
            chance.uniform(0.3, 0.45) if gait == "rollator" else chance.uniform(0.5, 0.8)
        )
        self._spread = 0.0
        self._apart_m = chance.uniform(0.07, 0.12)
        self._radii = chance.uniform(0.045, 0.07), chance.uniform(0.045, 0.07)
        self._wide_m = chance.uniform(0.16, 0.22)
        self._side = chance.choice((-1.0, 1.0))

    def go(self, x_m: float, y_m: float) -> None:
        """Move to (x, y), in one time step."""
        dx, dy = x_m - self.x_m, y_m - self.y_m
        step = math.hypot(dx, dy)
        if step > 1e-6:
            turn = math.remainder(math.atan2(dy, dx) - self.heading_rad, 2.0 * math.pi)
            self.heading_rad += max(-0.4, min(0.4, turn))
        self._spread = min(1.0, self._spread + 3.0 * step)
        self._way_m += step
        self.x_m, self.y_m = x_m, y_m

    def stand(self) -> None:
        """Stand for one time step: the feet come together."""
        self._spread *= 0.9

    def legs(self) -> list[Disc]:
        """Discs that a plane near the floor cuts: legs first."""
        if self.gait == PLAIN:
            swing = self._spread * 0.5 * _STRIDE_M * math.sin(math.pi * self._way_m / _STRIDE_M)
            return [self._disc(side * swing, side * 0.09, 0.055) for side in (1.0, -1.0)]
        if self.gait == "skirt":
            sway = 0.03 * math.sin(2.0 * math.pi * self._way_m / self._stride_m)
            return [self._disc(0.0, sway, self._wide_m)]
        found = [
            self._disc(self._foot(0.0), self._apart_m, self._radii[0]),
            self._disc(self._foot(0.5), -self._apart_m, self._radii[1]),
        ]
        if self.gait == "cane":
            found.append(self._disc(0.15 + self._foot(0.5), 0.28 * self._side, 0.012))
        elif self.gait == "rollator":
            found += [
                self._disc(ahead, side, 0.02) for ahead in (0.3, 0.65) for side in (-0.28, 0.28)
            ]
        return found

    def _foot(self, later: float) -> float:
        """How far a foot is ahead of the body, m; `later`: its phase."""
        phase = (self._way_m / self._stride_m + later) % 1.0
        reach = self._spread * 0.5 * _STANDS * self._stride_m
        if phase < _STANDS:
            return reach * (1.0 - 2.0 * phase / _STANDS)
        return reach * (2.0 * (phase - _STANDS) / (1.0 - _STANDS) - 1.0)

    def _disc(self, ahead_m: float, left_m: float, radius_m: float) -> Disc:
        c, s = math.cos(self.heading_rad), math.sin(self.heading_rad)
        return (
            self.x_m + c * ahead_m - s * left_m,
            self.y_m + s * ahead_m + c * left_m,
            radius_m,
        )
