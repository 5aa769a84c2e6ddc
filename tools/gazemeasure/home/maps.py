"""A map made during a drive through a generated home, judged by the home itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.mapping.locating.looks import Looks
from gazechair.sensing.mapping.making import Making
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.odometry.estimate import Estimate
from gazemeasure.report import Report
from gazemeasure.spread import Spread, together
from gazesim.home_drive import LIDAR_HEIGHT_M, Truth
from gazesim.homes import Home

WALLS_M = 0.03  # 95 % of occupied cells are this near to a surface
# A room is doubled if key scans are this far off, or many occupied cells far from all surfaces.
_DOUBLED_M, _NOWHERE_M, _NOWHERE_SHARE = 0.3, 0.15, 0.03
_AT_ONCE = 500
OFF_STEP_M = 0.001


@dataclass(frozen=True)
class Judged:
    """Errors of a map."""

    off_m: Spread
    """Each occupied cell's distance from the nearest surface."""
    keys_off_m: float
    """The largest distance of a key scan from where it was made."""

    @property
    def doubled(self) -> bool:
        """True if a room is mapped at a wrong place."""
        nowhere = 1.0 - self.off_m.share_below(_NOWHERE_M)
        return self.keys_off_m > _DOUBLED_M or nowhere > _NOWHERE_SHARE


def kept(row: dict[str, Any]) -> Judged:
    """Errors from their JSON row."""
    return Judged(Spread(**row["off_m"]), row["keys_off_m"])


class MapJudge:
    """Makes the map of a drive; feed it odometry's inputs and estimates."""

    def __init__(self, home: Home) -> None:
        self._home = home
        self._looks, self._making = Looks(), Making()
        self._true: list[tuple[float, float]] = []
        self._states: dict[object, FloatArray] = {}

    def take(self, piece: Piece, estimate: Estimate, true: Truth) -> None:
        """A piece, its estimate and the truth."""
        self._looks.piece(piece)
        if self._looks.estimate(estimate) and self._making.take(self._looks):
            self._true.append((true.x_m, true.y_m))
            doors = tuple(door.open for door in self._home.doors)
            state = doors, tuple(solid.corners for solid in self._home.furniture)
            if state not in self._states:
                self._states[state] = self._home.segments(LIDAR_HEIGHT_M)

    def judged(self) -> Judged:
        """Judge the map after the drive. Objects count where they stood at any time."""
        home: HomeMap = self._making.finished("judged")
        true, found = np.array(self._true), home.track[:, :2]
        # The map's frame in the home's: the best fit of the key scans.
        here, there = found - found.mean(axis=0), true - true.mean(axis=0)
        products = here.T @ there
        turn = math.atan2(products[0, 1] - products[1, 0], products[0, 0] + products[1, 1])
        c, s = math.cos(turn), math.sin(turn)
        rotation = np.array(((c, s), (-s, c)))

        def placed(points_m: FloatArray) -> FloatArray:
            return np.asarray((points_m - found.mean(axis=0)) @ rotation + true.mean(axis=0))

        surfaces = np.unique(np.concatenate(list(self._states.values())), axis=0)
        off_m = surfaces_off_m(placed(home.grid.occupied_m()), surfaces)
        keys_off_m = np.hypot(*(placed(found) - true).T)
        return Judged(Spread.of(off_m, OFF_STEP_M), float(keys_off_m.max()))


def add_rows(report: Report, lidars: str, maps: list[Judged]) -> None:
    """Add the results of the maps of all drives with these lidars."""
    off_m = together(one.off_m for one in maps).percentile(95.0)
    report.add(f"maps of homes, {lidars}: walls, 95 %", off_m, "m", WALLS_M)
    report.add("  in the worst home", max(one.off_m.percentile(95.0) for one in maps), "m")
    report.add("  key scans, most off", max(one.keys_off_m for one in maps), "m")
    report.add("  homes with a doubled room", float(sum(one.doubled for one in maps)), "", 0.0)


def surfaces_off_m(places_m: FloatArray, surfaces: FloatArray) -> FloatArray:
    """Each place's distance from the nearest surface; inf: there is none."""
    if not len(places_m) or not len(surfaces):
        return np.full(len(places_m), np.inf)
    begin, along = surfaces[:, :2], surfaces[:, 2:] - surfaces[:, :2]
    length = np.maximum((along**2).sum(axis=1), 1e-12)
    found = []
    for at in range(0, len(places_m), _AT_ONCE):
        off = places_m[at : at + _AT_ONCE, None] - begin
        share = np.clip((off * along).sum(axis=2) / length, 0.0, 1.0)
        apart = off - share[..., None] * along
        found.append(np.hypot(apart[..., 0], apart[..., 1]).min(axis=1))
    return np.concatenate(found)
