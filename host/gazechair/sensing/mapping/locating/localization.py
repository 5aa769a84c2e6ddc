"""Localization in a known map: finds the pose without a hint, follows it, notices when it is lost.

No pose is better than a wrong one: a pose counts when the static surfaces around the chair agree
with the map there, clearly more than at any other pose, hardly contradict it, and the following
looks find it again.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between, compose, from_frame
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.locating.candidate import Candidate, far_of, is_only
from gazechair.sensing.mapping.locating.hold import Hold
from gazechair.sensing.mapping.locating.lasting import Lasting
from gazechair.sensing.mapping.locating.location import Location
from gazechair.sensing.mapping.locating.map_match import Evidence, Look, MapMatch
from gazechair.sensing.mapping.locating.open_directions import OpenDirections
from gazechair.sensing.mapping.locating.pose_information import PoseInformation, fits_elsewhere
from gazechair.sensing.mapping.locating.recent_looks import CELL_M, RecentLooks, Settled
from gazechair.sensing.mapping.locating.uncertainty import (
    FOUND_M,
    KEPT_M,
    Unsteady,
    disagreement,
    sigmas_of,
)
from gazechair.sensing.mapping.matching import ndt
from gazechair.sensing.mapping.matching.correlative_search import search

# Search.
_HEADINGS_RAD = np.radians(np.arange(0.0, 360.0, 1.5))
_POINTS = 120
_EVERY = 2  # looks between searches of the whole map; in between, its candidates are compared again
_LEAST, _RATIO, _APART_M = 0.15, 0.7, 0.4
_CANDIDATES = 40
_KEPT = 12  # candidates, for the next look
_SAME_M, _SAME_RAD = 0.12, math.radians(4.0)
# A pose that counts, see also candidate.py.
_FIRM = 0.03  # information across over along: less is a corridor without an end
_LOOK_M, _LOOK_RAD = 0.25, math.radians(9.0)  # least motion of the chair between two looks
_AGAIN_S = 0.5  # least time between looks at standstill
_CONFIRM_M, _CONFIRM_RAD = 0.10, math.radians(3.0)
_CONFIRMED = 4  # looks in a row that find the same pose
# Following.
_FOLLOW_SIGMAS = np.array((0.05, 0.05, math.radians(1.0)))
# If less is explained, or the heading is poorly determined, people distort the fit; see Hold.
_SURE, _SURE_RAD = 0.8, math.radians(0.5)
_HELD_FOR_M = 1.0  # beyond this distance the view is another, with other people
_LOST_EXPLAINED = 0.45  # with less: a crowd, or another place; the map is searched again
_LOST_CONTRADICTED = 0.15  # share of beams that reach known surfaces, and of their length
_LOST_S = 2.0
# About half of a place may fit at a wrong pose, too, with little contradicted: the map is searched.
_HALF_EXPLAINED = 0.6
# Static far surfaces of the newest looks: if less agrees, the chair is at another place. People
# hide surfaces but contradict none: if that share of what agrees is contradicted, more must agree.
_RECENT, _FAR_LOST = 5, 0.4
_FAR_CONTRADICTED, _FAR_LOST_CONTRADICTED = 0.5, 0.65
_LEAST_FAR_M = 1.0
# If fits turn the pose this far against odometry within a second, a lidar was bumped: odometry
# follows the heading sensor. A share of the chair's turn is odometry's own error.
_ASKEW_RAD, _ASKEW_S, _ASKEW_SHARE = math.radians(1.2), 1.0, 0.04
_STILL_M = 1.0  # agreed length that keeps a pose while people hide the rest
_PLACED_M, _PLACED_RAD = 0.1, math.radians(2.0)
_SHUT = 1e6  # information that stands for odometry's


class Localization:
    """Feed it looks with the odometry's pose at each; `location` is None while it is not known."""

    def __init__(self, grid: OccupancyGrid) -> None:
        self._map = MapMatch(grid)
        self._looks = RecentLooks()
        self._newest: tuple[FloatArray, float] | None = None  # look: odometry's pose, time
        self._compared = 0  # how often since the start
        self._kept: list[FloatArray] = []  # frames of candidates
        self._claim: Candidate | None = None  # by which a pose was found
        self._confirmed = 0  # how often in a row
        self._odometry: FloatArray = np.zeros(3)
        self._hold = Hold(np.zeros(3), np.zeros(3))
        self._doubt, self._half = Lasting(_LOST_S), Lasting(_LOST_S)
        self._agrees = True  # far static surfaces with the map, at the known pose
        self._pulled_rad, self._pulled_s = 0.0, math.inf  # recent turn by fits against odometry
        self._unsteady = Unsteady()
        self._open = OpenDirections()
        self.location: Location | None = None
        self.askew = False
        """Whether the newest look ended the location because the map turned against odometry."""
        self.searched = False
        """Whether the newest look was searched in the whole map."""

    def look(
        self, look: Look, odometry: FloatArray, time_s: float, odometry_sigma_m: float = 0.0
    ) -> Location | None:
        """The location after this look; `odometry` (3,): the pose in odometry's frame.

        `odometry_sigma_m`: standard deviation of its position, since its beginning.
        """
        self.searched = self.askew = False
        self._open.odometry_sigma_m = odometry_sigma_m
        if not len(look.points_m):
            if self.location is not None:
                self._drift(odometry, time_s, self.location)
        elif self.location is not None:
            self._follow(look, odometry, time_s, self.location.pose)
        elif self._remember(look, odometry, time_s):
            self._search(odometry)
        self._odometry = odometry
        return self.location

    @property
    def sure(self) -> bool:
        """Whether the newest look alone supports the location."""
        location = self.location
        if location is None or self._doubt.since_s is not None:
            return False
        return location.evidence.explained >= _SURE and location.sigma_rad <= _SURE_RAD

    def place(self, pose: FloatArray, odometry: FloatArray) -> None:
        """Set the pose, known from just having made the map; later looks verify it."""
        self.forget()
        self.location = Location(pose, Evidence(1.0, 0.0), _PLACED_M, _PLACED_RAD)
        self._open.none()
        self._hold = Hold(pose, odometry)
        self._odometry = odometry

    def forget(self) -> None:
        """Start again: the chair was lifted, or the map is another."""
        self.lose()
        self._unsteady.forget()

    def lose(self) -> None:
        """Drop the location; odometry continues."""
        self._forget_looks()
        self._claim, self._confirmed = None, 0
        self._pulled_rad, self._pulled_s = 0.0, math.inf
        self._doubt.end()
        self._half.end()
        self.location = None

    def is_rivalled_by(self, other: Localization) -> bool:
        """Whether the looks that found this location may be from the other's map as well."""
        claim = self._claim
        if claim is None:
            return False
        rivals = other._candidates(claim.settled, claim.odometry, other._kept)
        return not claim.excludes_all(rivals)

    def _images(self, claim: Candidate) -> list[Candidate]:
        """Where in the map the mirror image of what was seen fits; best first."""
        return self._candidates(claim.settled.mirrored(), claim.odometry * (1.0, -1.0, -1.0), [])

    def _forget_looks(self) -> None:
        self._looks.forget()
        self._newest, self._kept, self._compared, self._agrees = None, [], 0, True

    def _remember(self, look: Look, odometry: FloatArray, time_s: float) -> bool:
        """Keep a look; False: it is too similar to the one before."""
        if self._newest is not None:
            before, before_s = self._newest
            alike = _is_within(before, odometry, _LOOK_M, _LOOK_RAD)
            if alike and time_s - before_s < _AGAIN_S:
                return False
        self._newest = odometry, time_s
        placed = look.moved(odometry)
        self._looks.add(placed.origins_m, placed.points_m, odometry[:2])
        return True

    def _search(self, odometry: FloatArray) -> None:
        settled = self._looks.settled()
        if settled is None:
            return
        self.searched = self._compared % _EVERY == 0 or not self._kept
        self._compared += 1
        candidates = self._candidates(settled, odometry, self._kept, self.searched)
        self._kept = [one.frame for one in candidates[:_KEPT]]
        if not candidates or not is_only(candidates):
            self._claim, self._confirmed = None, 0
            return
        best = candidates[0]
        agrees = self._claim is not None and _is_at(
            compose(self._claim.frame, odometry), best.fitted.pose
        )
        self._confirmed = self._confirmed + 1 if agrees else 1
        self._claim = best
        if self._confirmed >= _CONFIRMED:
            location = self._located(best)
            if location.is_open or location.sigma_m > FOUND_M or not best.is_certain(self._images):
                return
            self._keep(location)
            self._hold = Hold(best.fitted.pose, odometry)
            self._forget_looks()

    def _candidates(
        self, settled: Settled, odometry: FloatArray, frames: list[FloatArray], whole: bool = True
    ) -> list[Candidate]:
        """Distinct poses, best first: with one of `frames` or, if `whole`, in the whole map."""
        field = self._map.coarse
        points = from_frame(settled.surfaces_m, odometry)
        guesses = [compose(frame, odometry) for frame in frames]
        if whole:
            few = points[:: max(1, len(points) // _POINTS)]
            least = _LEAST, _APART_M, _RATIO, _CANDIDATES
            found = search(field, few, field.low_m, field.high_m, _HEADINGS_RAD, *least)
            guesses += [one.pose for one in found]
        back = between(odometry, np.zeros(3))
        fits = []
        for guess in guesses:
            fitted = ndt.fit(self._map.ndt, points, guess, origins_m=np.zeros(2))
            soft, firm = np.linalg.eigvalsh(fitted.information[:2, :2])
            if soft > _FIRM * firm and self._map.near_free_floor(fitted.pose):
                frame = compose(fitted.pose, back)
                fits.append(Candidate(self._map, settled, odometry, frame, fitted))
        chosen: list[Candidate] = []
        for one in sorted(fits, key=lambda one: -one.agreement.value_m):
            if not any(_is_same(one.fitted.pose, other.fitted.pose) for other in chosen):
                chosen.append(one)
        return chosen

    def _located(self, one: Candidate) -> Location:
        agreement = one.agreement
        whole_m = CELL_M * len(agreement.agreed)
        shares = agreement.agreed_m / whole_m, agreement.contradicted_m / whole_m
        look = Look(from_frame(one.settled.surfaces_m, one.odometry), np.zeros(2))
        seen = PoseInformation.of(self._map.ndt, look, one.fitted.pose)
        doubtful = np.concatenate((seen.open_axes, seen.by_one))
        return self._location(one.fitted.pose, Evidence(*shares), look, seen, doubtful)

    def _location(
        self,
        pose: FloatArray,
        evidence: Evidence,
        look: Look,
        seen: PoseInformation,
        open_axes: FloatArray,
        held: FloatArray | None = None,
    ) -> Location:
        """`seen`: what the look tells; `open_axes`: the directions that it leaves open."""
        information = seen.information.copy()
        information[:2, :2] += _SHUT * open_axes.T @ open_axes
        disagrees = disagreement(self._map.ndt, look.points_m, pose, look.origins_m, held)
        sigma_m, sigma_rad = sigmas_of(information, self._map.cell_m, disagrees)
        if len(open_axes):
            sigma_m = max(sigma_m, self._open.sigma_m)
        return Location(pose, evidence, sigma_m, sigma_rad, len(open_axes) > 0)

    def _keep(self, location: Location) -> None:
        self.location = location
        if not location.is_open:
            self._open.none(location.sigma_m)

    def _follow(self, look: Look, odometry: FloatArray, time_s: float, pose: FloatArray) -> None:
        guess = compose(pose, between(self._odometry, odometry))
        self._hold.move(self._odometry, odometry)
        held = compose(self._hold.pose, between(self._hold.odometry, odometry))
        there, sure = self._fit(look, guess, held)
        seen = PoseInformation.of(self._map.ndt, look, there)
        off_m = guess[:2] - there[:2]
        open_axes = self._open.axes(seen, off_m)
        there[:2] += open_axes.T @ (open_axes @ off_m)
        if sure and fits_elsewhere(self._map.ndt, look, there, seen.weak_axes):
            self.lose()
            return
        evidence = self._map.evidence(look, there)
        deviations = _FOLLOW_SIGMAS if sure else self._hold.deviations
        location = self._location(there, evidence, look, seen, open_axes, deviations)
        off_rad = float(between(guess, there)[2])
        own_rad = _ASKEW_SHARE * abs(float(between(pose, guess)[2]))
        off_rad -= min(max(off_rad, -own_rad), own_rad)
        if sure and self._is_pulled(off_rad, time_s):
            self.lose()
            self.askew = True
            return
        contradicted = (
            evidence.through > _LOST_CONTRADICTED * (evidence.explained + evidence.through)
            and evidence.crossed > _LOST_CONTRADICTED
        )
        if self._remember(look, odometry, time_s):
            self._agrees = self._agrees_far(there, odometry)
        fits = sure or self._hold.holds(held, there)
        fits = fits and evidence.explained >= _LOST_EXPLAINED and not contradicted
        if fits and self._agrees:
            unsteady_m = self._unsteady.judge(there, odometry)
            location = replace(location, sigma_m=math.hypot(location.sigma_m, unsteady_m))
            if location.sigma_m > KEPT_M or self._fits_half(evidence, there, odometry, time_s):
                self.lose()
                return
            if len(seen.by_one):
                self.location = location
                self._open.follow_one(guess[:2] - there[:2])
            else:
                self._keep(location)
            self._doubt.end()
            if sure or self._hold.driven_m > _HELD_FOR_M:
                self._hold = Hold(there, odometry)
            return
        # People distort a fit.
        if self._doubts(location, guess, time_s):
            still = None if contradicted else self._still_at(guess, odometry)
            if still is None or (still.is_open and still.sigma_m > KEPT_M):
                self.lose()
            else:
                # People who stand distort the static surfaces as well.
                self.location = replace(still, pose=guess)
                self._doubt.end()

    def _fits_half(
        self, evidence: Evidence, pose: FloatArray, odometry: FloatArray, time_s: float
    ) -> bool:
        """Whether so little fits, and has for so long, that the chair may well be elsewhere."""
        if evidence.explained >= _HALF_EXPLAINED:
            self._half.end()
        elif self._half.holds(time_s):
            self._half.end()
            return self._still_at(pose, odometry) is None
        return False

    def _drift(self, odometry: FloatArray, time_s: float, location: Location) -> None:
        """Nothing is in range: odometry alone, in doubt, and not for long."""
        self._hold.move(self._odometry, odometry)
        guess = compose(location.pose, between(self._odometry, odometry))
        if self._doubts(location, guess, time_s):
            self.lose()

    def _doubts(self, location: Location, guess: FloatArray, time_s: float) -> bool:
        """Use odometry alone until the pose is confirmed; whether that has lasted too long."""
        self.location = replace(location, pose=guess)
        return self._doubt.holds(time_s)

    def _fit(self, look: Look, guess: FloatArray, held: FloatArray) -> tuple[FloatArray, bool]:
        """The pose by this look, and whether the look alone determines it; else see Hold."""
        evidence = self._map.evidence(look, guess)
        if evidence.explained >= _SURE:
            free = ndt.fit(self._map.ndt, look.points_m, guess, _FOLLOW_SIGMAS, look.origins_m)
            if sigmas_of(free.information, self._map.cell_m)[1] <= _SURE_RAD:
                return free.pose, True
        deviations = self._hold.deviations
        return ndt.fit(self._map.ndt, look.points_m, held, deviations, look.origins_m).pose, False

    def _is_pulled(self, turn_rad: float, time_s: float) -> bool:
        """Whether fits have turned the pose against odometry; the first look does not count."""
        passed_s = time_s - self._pulled_s
        self._pulled_s = time_s
        if passed_s >= 0.0:
            self._pulled_rad = self._pulled_rad * math.exp(-passed_s / _ASKEW_S) + turn_rad
        return abs(self._pulled_rad) > _ASKEW_RAD

    def _agrees_far(self, pose: FloatArray, odometry: FloatArray) -> bool:
        settled = self._looks.settled(_RECENT)
        if settled is None:
            return True
        far = far_of(settled, odometry)
        if CELL_M * far.sum() < _LEAST_FAR_M:
            return True
        frame = compose(pose, between(odometry, np.zeros(3)))
        agreement = self._map.agreement(settled, frame)
        agreed = agreement.agreed[far]
        contradicted = agreement.contradicted_m > _FAR_CONTRADICTED * CELL_M * agreed.sum()
        least = _FAR_LOST_CONTRADICTED if contradicted else _FAR_LOST
        return bool(agreed.mean() >= least)

    def _still_at(self, pose: FloatArray, odometry: FloatArray) -> Location | None:
        """The location at a known pose of which people may hide most surfaces.

        None: the pose is unlikely by now, or another one in the map is clearly better.
        """
        self.searched = True
        settled = self._looks.settled(_RECENT)
        if settled is None:
            return None
        frame = compose(pose, between(odometry, np.zeros(3)))
        candidates = self._candidates(settled, odometry, [frame])
        here = next((one for one in candidates if _is_at(one.fitted.pose, pose)), None)
        if here is None or not here.is_still_possible(_STILL_M):
            return None
        if any(one.leads(here) for one in candidates):
            return None
        return self._located(here)


def _is_same(one: FloatArray, other: FloatArray) -> bool:
    return _is_within(one, other, _SAME_M, _SAME_RAD)


def _is_at(one: FloatArray, other: FloatArray) -> bool:
    return _is_within(one, other, _CONFIRM_M, _CONFIRM_RAD)


def _is_within(one: FloatArray, other: FloatArray, most_m: float, most_rad: float) -> bool:
    off = between(one, other)
    return math.hypot(off[0], off[1]) < most_m and abs(float(off[2])) < most_rad
