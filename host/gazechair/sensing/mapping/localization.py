"""Localization in a known map: finds the pose without a hint, follows it, notices when it is lost.

Rather no pose than a wrong one: a pose counts when the looks fit there, fit nowhere else nearly as
well, contradict nothing, and the looks that follow find it again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gazechair.base.footprint import FloatArray
from gazechair.sensing.mapping import ndt
from gazechair.sensing.mapping.correlative_search import search
from gazechair.sensing.mapping.map_match import Evidence, Look, MapMatch, together
from gazechair.sensing.mapping.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.poses import between, compose

# Search.
_HEADINGS_RAD = np.radians(np.arange(0.0, 360.0, 1.5))
_POINTS, _FIT_POINTS = 100, 600  # of all looks together
_LEAST, _RATIO, _APART_M = 0.42, 0.75, 0.4
_CANDIDATES = 40
_SAME_M, _SAME_RAD = 0.3, math.radians(10.0)
# A pose that counts.
_EXPLAINED, _THROUGH = 0.60, 0.10
_MARGIN = 0.12  # of the value above every other place's
# Much is not as mapped: then the true place may look worse than another. It has to be clearer, and
# seen from several headings or places, for looks from one pose repeat each other.
_WEAK_EXPLAINED, _WEAK_MARGIN, _WEAK_MOVES = 0.80, 0.25, 4
# Nothing contradicts another place: it stays possible, for furniture may have been moved.
_POSSIBLE_EXPLAINED, _POSSIBLE_THROUGH = 0.75, 0.01
_FIRM = 0.03  # information across over along: less is a corridor without an end
_LOOKS = 8
_LOOK_M, _LOOK_RAD = 0.25, math.radians(9.0)  # the chair moves so far between two looks
_AGAIN_S = 0.5  # or stands so long
_CONFIRM_M, _CONFIRM_RAD = 0.10, math.radians(3.0)
_CONFIRMED = 4  # looks in a row that find the same pose
# Following.
_FOLLOW_SIGMAS = np.array((0.05, 0.05, math.radians(1.0)))
_LOST_EXPLAINED = 0.45  # fewer: a crowd, or another place; both are not known
_LOST_CONTRADICTED = 0.15  # of the beams that reach what is known
_LOST_S = 2.0
# Points err together, by what a fit claims twice; and a map's surfaces are right within this.
_PLACED_M, _PLACED_RAD = 0.1, math.radians(2.0)
_SIGMAS, _MAP_M, _MAP_RAD = 2.0, 0.01, math.radians(0.2)


@dataclass(frozen=True)
class Location:
    """Where the chair is in the map, and the evidence for it."""

    pose: FloatArray
    """(3,): x, y in metres, heading in radians."""
    evidence: Evidence
    sigma_m: float
    """Standard deviation of the place, in the direction known worst."""
    sigma_rad: float


class Localization:
    """Feed it looks with the odometry's pose at each; `location` is None while it is not known."""

    def __init__(self, grid: OccupancyGrid) -> None:
        self._map = MapMatch(grid)
        self._looks: list[tuple[Look, FloatArray, float]] = []  # with odometry's pose, time
        self._found: tuple[FloatArray, FloatArray] | None = None  # and odometry's pose then
        self._confirmed = 0  # how often in a row
        self._odometry: FloatArray = np.zeros(3)
        self._doubt_since_s: float | None = None
        self.location: Location | None = None
        self.searched = False
        """Whether the newest look was searched in the whole map."""

    def look(self, look: Look, odometry: FloatArray, time_s: float) -> Location | None:
        """The location after this look; `odometry` (3,): in a frame of its own."""
        self.searched = False
        if not len(look.points_m):
            return self.location
        if self.location is not None:
            self._follow(look, odometry, time_s, self.location.pose)
        elif self._is_new(odometry, time_s):
            self._looks = [*self._looks, (look, odometry, time_s)][-_LOOKS:]
            self._search(odometry)
        self._odometry = odometry
        return self.location

    def place(self, pose: FloatArray, odometry: FloatArray) -> None:
        """It is there, as who has just made the map knows; looks soon tell if not."""
        self.forget()
        self.location = Location(pose, Evidence(1.0, 0.0), _PLACED_M, _PLACED_RAD)
        self._odometry = odometry

    def forget(self) -> None:
        """Begin anew: the chair was lifted, or another map counts."""
        self._looks, self._found, self._confirmed = [], None, 0
        self._doubt_since_s = self.location = None

    def _is_new(self, odometry: FloatArray, time_s: float) -> bool:
        if not self._looks:
            return True
        _, before, before_s = self._looks[-1]
        return _is_apart(before, odometry) or time_s - before_s >= _AGAIN_S

    def _moves(self) -> int:
        """How many of the recent looks were made elsewhere, or at another heading, than before."""
        poses = [odometry for _, odometry, _ in self._looks]
        return sum(_is_apart(one, after) for one, after in pairwise(poses))

    def _search(self, odometry: FloatArray) -> None:
        self.searched = True
        found = self.only_pose(self._together(odometry))
        if found is None:
            self._found, self._confirmed = None, 0
            return
        agrees = False
        if self._found is not None:
            pose, at = self._found
            off = between(compose(pose, between(at, odometry)), found.pose)
            agrees = math.hypot(off[0], off[1]) < _CONFIRM_M and abs(off[2]) < _CONFIRM_RAD
        self._confirmed = self._confirmed + 1 if agrees else 1
        self._found = found.pose, odometry
        weak = found.evidence.explained < _WEAK_EXPLAINED and self._moves() < _WEAK_MOVES
        if self._confirmed >= _CONFIRMED and not weak:
            self.forget()
            self.location = found

    def fits_as_well(self, location: Location, odometry: FloatArray) -> bool:
        """Whether the recent looks may be from this map, given that they fit another so well."""
        if not self._looks:
            return False
        look = self._together(odometry)
        return any(_is_as_good(one.evidence, location.evidence) for one in self._candidates(look))

    def _together(self, odometry: FloatArray) -> Look:
        return together([one.moved(between(odometry, at)) for one, at, _ in self._looks])

    def only_pose(self, look: Look) -> Location | None:
        """The one pose that the look fits, searched in the whole map; None: none, or several."""
        ranked = sorted(self._candidates(look), key=lambda one: -one.evidence.value)
        if not ranked:
            return None
        best = ranked[0]
        if best.evidence.explained < _EXPLAINED or best.evidence.through > _THROUGH:
            return None
        if any(_is_rival(other, best) for other in ranked[1:]):
            return None
        return best

    def _candidates(self, look: Look) -> list[Location]:
        field = self._map.coarse
        few = look.points_m[:: max(1, len(look.points_m) // _POINTS)]
        some = look.points_m[:: max(1, len(look.points_m) // _FIT_POINTS)]
        low, high = field.low_m, field.high_m
        least = _LEAST, _APART_M, _RATIO, _CANDIDATES
        found = []
        for one in search(field, few, low, high, _HEADINGS_RAD, *least):
            fitted = ndt.fit(self._map.ndt, some, one.pose)
            soft, firm = np.linalg.eigvalsh(fitted.information[:2, :2])
            if soft > _FIRM * firm and self._map.on_free_floor(fitted.pose):
                found.append(self._location(look, fitted))
        return found

    def _location(self, look: Look, fitted: ndt.Fit) -> Location:
        covariance = np.linalg.inv(fitted.information + np.eye(3))
        along_m2 = float(np.linalg.eigvalsh(covariance[:2, :2])[1])
        return Location(
            fitted.pose,
            self._map.evidence(look, fitted.pose),
            math.hypot(_MAP_M, _SIGMAS * math.sqrt(along_m2)),
            math.hypot(_MAP_RAD, _SIGMAS * math.sqrt(float(covariance[2, 2]))),
        )

    def _follow(self, look: Look, odometry: FloatArray, time_s: float, pose: FloatArray) -> None:
        guess = compose(pose, between(self._odometry, odometry))
        fitted = ndt.fit(self._map.ndt, look.points_m, guess, _FOLLOW_SIGMAS)
        self.location = self._location(look, fitted)
        evidence = self.location.evidence
        contradicted = evidence.through > _LOST_CONTRADICTED * (
            evidence.explained + evidence.through
        )
        if evidence.explained >= _LOST_EXPLAINED and not contradicted:
            self._doubt_since_s = None
        elif self._doubt_since_s is None:
            self._doubt_since_s = time_s
        elif time_s - self._doubt_since_s >= _LOST_S:
            self.forget()


def _is_apart(one: FloatArray, other: FloatArray) -> bool:
    moved = between(one, other)
    return bool(math.hypot(moved[0], moved[1]) >= _LOOK_M or abs(moved[2]) >= _LOOK_RAD)


def _is_rival(other: Location, best: Location) -> bool:
    """Whether the chair may be at `other` instead."""
    off = between(best.pose, other.pose)
    if math.hypot(off[0], off[1]) < _SAME_M and abs(off[2]) < _SAME_RAD:
        return False
    return _is_as_good(other.evidence, best.evidence)


def _is_as_good(evidence: Evidence, best: Evidence) -> bool:
    margin = _MARGIN if best.explained >= _WEAK_EXPLAINED else _WEAK_MARGIN
    if evidence.value > best.value - margin:
        return True
    return evidence.explained >= _POSSIBLE_EXPLAINED and evidence.through <= _POSSIBLE_THROUGH
