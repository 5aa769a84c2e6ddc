"""A pose that may be the chair's: what the static surfaces around the chair say for and against it.

Contradictions come from moved furniture: metres, plus a share of what is agreed; less where little
is agreed, as that comes from people, who contradict nothing. A long straight surface where the map
has free floor is no person, and hardly furniture: it contradicts as well, and counts twice, since
it hides what the map has behind it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray
from gazechair.sensing.mapping.locating.map_match import Agreement, MapMatch
from gazechair.sensing.mapping.locating.recent_looks import CELL_M, Settled
from gazechair.sensing.mapping.matching import ndt

_AGREED_M = 4.0
_CONTRADICTED_M, _CONTRADICTED, _MOST_AGREED = 0.1, 0.3, 0.8
# A straight surface that is not on the map: this much may be anything; the rest counts so often.
_STRAIGHT_M, _STRAIGHT_COUNTS = 0.8, 2.0
# Of surfaces beyond this distance, which people close by hide less, a larger share must agree: else
# it is another home.
_FAR_M, _FAR_AGREED = 2.0, 0.7
# Required lead over every other pose: metres, plus a share of what it does not explain.
_LEAD_M, _LEAD_OF_UNEXPLAINED = 2.5, 0.05
# Of that lead, what more agreement must give where the other pose is possible, too; and what is
# enough where it is not.
_HALF = 0.5
# Where an unmapped place of the same kind is no likely explanation: little is contradicted, a share
# of what agrees that grows with the share of what is far that agrees, and the pose leads its mirror
# image. Such a place agrees less the more of it is seen: so the chair has seen most bearings, or
# it leads by more and less is contradicted, hardly anything where less of what is far agrees.
_AGAINST, _AGAINST_FAR, _AGAINST_GROWS, _AGAINST_MOST = 0.05, 0.75, 1.5, 0.2
_AROUND, _PART_LEADS, _PART_FAR, _PART_AGAINST, _PART_AGAINST_FAR = 0.85, 1.4, 0.85, 0.125, 0.025
_BEARINGS, _FLOOR_M = 36, 1.0  # floor at that distance shows that nothing stands there
# Or the chair has seen most bearings, much agrees, and almost all that is far.
_AMPLE_M, _AMPLE_FAR = 14.0, 0.95


@dataclass(frozen=True)
class Candidate:
    """A fitted pose and what was seen, static, around the chair."""

    known: MapMatch
    settled: Settled
    odometry: FloatArray
    """The chair's pose in the frame of `settled`, which is odometry's."""
    frame: FloatArray
    """Pose of odometry's frame in the map."""
    fitted: ndt.Fit

    @cached_property
    def agreement(self) -> Agreement:
        """Agreement with the map here."""
        return self.known.agreement(self.settled, self.frame)

    @cached_property
    def far_agreed(self) -> float:
        """Share of the surfaces that are not close to the chair, 0..1."""
        far = far_of(self.settled, self.odometry)
        return float(self.agreement.agreed[far].mean()) if far.any() else 1.0

    @cached_property
    def seen_around(self) -> float:
        """Share of the bearings in which something static, or floor, was seen, 0..1."""
        step_rad = 2.0 * math.pi / _BEARINGS
        off_m = self.settled.surfaces_m - self.odometry[:2]
        bearings_rad = step_rad * (np.arange(_BEARINGS) + 0.5)
        seen = np.floor(np.arctan2(off_m[:, 1], off_m[:, 0]) / step_rad).astype(np.int64)
        ring_m = _FLOOR_M * np.stack((np.cos(bearings_rad), np.sin(bearings_rad)), axis=1)
        floor = self.settled.is_free(self.odometry[:2] + ring_m)
        floor[seen % _BEARINGS] = True
        return float(floor.mean())

    @cached_property
    def against_m(self) -> float:
        """Length of what contradicts the pose: of the map's surfaces, and of a new straight one."""
        straight_m = self.known.new_straight_m(self.settled, self.agreement, self.frame)
        new_m = _STRAIGHT_COUNTS * max(0.0, straight_m - _STRAIGHT_M)
        return self.agreement.contradicted_m + new_m

    def is_possible(self) -> bool:
        """Whether the chair may be here, of which nothing else is known."""
        return self._agrees(_AGREED_M, self.against_m)

    def is_still_possible(self, least_m: float) -> bool:
        """Whether a chair that was here still may be, with `least_m` of what agrees.

        People who stand in a row may look like a wall; the chair has seen that there is none.
        """
        return self._agrees(least_m, self.agreement.contradicted_m)

    def _agrees(self, least_m: float, against_m: float) -> bool:
        agreed, agreed_m = self.agreement.agreed, self.agreement.agreed_m
        if self.far_agreed < _FAR_AGREED or agreed_m < least_m:
            return False
        share = min(1.0, float(agreed.mean()) / _MOST_AGREED)
        return against_m <= _CONTRADICTED_M + _CONTRADICTED * share**2 * agreed_m

    def leads(self, other: Candidate, share: float = 1.0) -> bool:
        """Whether what is seen fits better here than at the other, by `share` of the least lead."""
        return self.agreement.value_m - other.agreement.value_m >= share * self._lead_m

    @property
    def _lead_m(self) -> float:
        unexplained_m = CELL_M * len(self.agreement.agreed) - self.agreement.agreed_m
        return _LEAD_M + _LEAD_OF_UNEXPLAINED * unexplained_m

    def excludes(self, other: Candidate) -> bool:
        """Whether the chair is far more likely here than at the other.

        Where the chair may be at the other, too, more has to agree here: a lead that comes from
        what is gone there may be one piece of furniture.
        """
        more_m = self.agreement.agreed_m - other.agreement.agreed_m
        if self.leads(other) and more_m >= _HALF * self._lead_m:
            return True
        return self.leads(other, _HALF) and not other.is_possible()

    def excludes_all(self, others: list[Candidate]) -> bool:
        """Whether the chair is far more likely here than at any of the others."""
        return all(self.excludes(one) for one in others)

    def is_certain(self, images: Callable[[Candidate], list[Candidate]]) -> bool:
        """Whether an unmapped place of the same kind is no likely explanation.

        `images` gives the poses at which the mirror image of what was seen fits, which is nowhere:
        what fits as well as that shows only the kind of place, as the end of a corridor.
        """
        around = self.seen_around >= _AROUND
        most, lead = _AGAINST_MOST, 1.0
        if not around:
            most = _PART_AGAINST if self.far_agreed >= _PART_FAR else _PART_AGAINST_FAR
            lead = _PART_LEADS
        if around and self.agreement.value_m >= _AMPLE_M and self.far_agreed >= _AMPLE_FAR:
            return True
        against = _AGAINST + _AGAINST_GROWS * max(0.0, self.far_agreed - _AGAINST_FAR)
        if self.against_m > min(against, most) * self.agreement.agreed_m:
            return False
        return all(self.leads(one, lead) for one in images(self))


def far_of(settled: Settled, odometry: FloatArray) -> BoolArray:
    """(N,): which surfaces are not close to the chair."""
    return np.asarray(np.hypot(*(settled.surfaces_m - odometry[:2]).T) > _FAR_M)


def is_only(candidates: list[Candidate]) -> bool:
    """Whether the first may be the chair's pose, and none of the others."""
    best = candidates[0]
    return best.is_possible() and best.excludes_all(candidates[1:])
