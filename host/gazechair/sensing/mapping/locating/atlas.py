"""Finds in which of the known maps the chair is, and where. No answer is better than a wrong one.

A pose counts when it fits one map alone, or continues from where the chair was known moments before
and odometry went on without a break. There, a pose elsewhere needs stronger evidence: an unmapped
room may look like a mapped one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between, compose
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.locating.localization import Localization
from gazechair.sensing.mapping.locating.location import Location
from gazechair.sensing.mapping.locating.looks import Seen
from gazechair.sensing.odometry.doubts import TURNED

# Error of odometry since the pose was last known, plus a share of the distance driven.
_OFF_M, _OFF_SHARE, _OFF_RAD = 0.5, 0.05, math.radians(10.0)
_ASKEW_M = 4.0  # to drive after a lidar seems turned: by then odometry knows better
_ELSEWHERE_EXPLAINED, _ELSEWHERE_THROUGH = 0.8, 0.02
# Known so recently, the chair is still in the same map: to another floor a lift takes longer, from
# door to door. To find a pose again takes 3 s.
_RECENT_S = 8.0
_KNOWN_DEG = 2.0  # a standard deviation of the lidars' directions: driving has verified them
_RIVALLED_S = 30.0  # after this long the map is unknown for other reasons


@dataclass
class _Sheet:
    grid: OccupancyGrid
    localization: Localization


@dataclass
class _Known:
    """Where the chair was when it was last known."""

    id: str
    pose: FloatArray
    odometry: FloatArray
    time_s: float
    driven_m: float = 0.0


class Atlas:
    """Feed it looks; `location` is the chair's pose, `id` its map; "": not known."""

    def __init__(self, alive: Callable[[], None] = lambda: None) -> None:
        """`alive` is called after each map is read or searched, as many maps take long."""
        self._alive = alive
        self._sheets: dict[str, _Sheet] = {}
        self._last: _Known | None = None
        self._odometry: FloatArray | None = None
        self._track = 0
        self._askew_m = 0.0  # still to be driven
        self._look_s = 0.0
        self._mounting_sigma_deg = 0.0  # see Estimate
        self._lidar_m = 0.0  # of the farthest lidar from the axle
        self._rivalled_s = -math.inf  # when another map fitted a pose as well
        self.id = ""
        self.searched = False
        """Whether the newest look was searched in whole maps."""

    @property
    def ids(self) -> list[str]:
        """The maps that it knows."""
        return list(self._sheets)

    @property
    def location(self) -> Location | None:
        """None: not known."""
        location = self._sheets[self.id].localization.location if self.id else None
        if location is None:
            return None
        # A lidar that is turned turns the pose about itself.
        mounting_rad = math.radians(self._mounting_sigma_deg)
        mounting_m = mounting_rad * self._lidar_m
        return replace(
            location,
            sigma_m=math.hypot(location.sigma_m, mounting_m),
            sigma_rad=math.hypot(location.sigma_rad, mounting_rad),
            mounting_m=mounting_m,
            mounting_rad=mounting_rad,
        )

    @property
    def grid(self) -> OccupancyGrid:
        """Grid of the map in which the chair is known to be."""
        return self._sheets[self.id].grid

    @property
    def askew(self) -> bool:
        """Whether every pose is rejected, because a lidar seems to be turned on its mount."""
        return self._askew_m > 0.0

    @property
    def rivalled(self) -> bool:
        """Whether it is not known where the chair is because two maps fit what is seen."""
        return not self.id and self._look_s - self._rivalled_s < _RIVALLED_S

    @property
    def sure(self) -> bool:
        """Whether the newest look alone supports the pose (see Localization.sure), and the lidars
        are known to sit right."""
        known = self._mounting_sigma_deg <= _KNOWN_DEG
        return bool(self.id) and known and self._sheets[self.id].localization.sure

    def know(self, grids: Mapping[str, OccupancyGrid]) -> None:
        """Use these maps from now on; an empty one is left out."""
        for id_ in [one for one in self._sheets if one not in grids]:
            del self._sheets[id_]
            self._rivalled_s = -math.inf
        for id_, grid in grids.items():
            known = self._sheets.get(id_)
            if known is not None and known.grid.same_as(grid):
                continue
            self._sheets.pop(id_, None)
            if grid.occupied.any():
                self._sheets[id_] = _Sheet(grid, Localization(grid))
                if id_ == self.id and known is not None and known.grid.lies_as(grid):
                    self._hand_over(known.localization, self._sheets[id_].localization)
                if self.id not in self._sheets:
                    self.id = ""
                self._alive()
        if self.id not in self._sheets or self.location is None:
            self.id = ""
        if self._last is not None and self._last.id not in self._sheets:
            self._last = None

    def look(self, seen: Seen) -> Location | None:
        """The location after this look."""
        track = seen.estimate.track
        if self._odometry is not None and track != self._track:
            self.forget()  # carried, or odometry has started again
        self._advance(seen.odometry, track)
        at_s, self.searched = seen.estimate.time_s, False
        sigma_m = max(seen.estimate.along_sigma_m, seen.estimate.across_sigma_m)
        self._look_s = at_s
        self._mounting_sigma_deg = seen.estimate.mounting_sigma_deg
        self._lidar_m = float(np.hypot(*seen.look.origins_m.T).max(initial=0.0))
        if self.askew or TURNED in seen.estimate.doubts:  # every pose would be turned by as much
            self.id = ""
            self._forget_looks()
            return None
        if self.id:
            location = self._sheets[self.id].localization.look(
                seen.look, seen.odometry, at_s, sigma_m
            )
            if location is not None:
                self._last = _Known(self.id, location.pose, seen.odometry, at_s)
                return self.location
            self._askew_m = _ASKEW_M if self._sheets[self.id].localization.askew else 0.0
            self.id = ""
            self._forget_looks()
            return None
        last = self._last.id if self._last is not None else ""
        for id_, sheet in sorted(self._sheets.items(), key=lambda one: one[0] != last):
            found = sheet.localization.look(seen.look, seen.odometry, at_s, sigma_m)
            self.searched = self.searched or sheet.localization.searched
            self._alive()
            if found is not None and self._settles(id_, found, seen):
                return self.location
        return None

    def place(self, id_: str, pose: FloatArray, odometry: FloatArray, track: int) -> None:
        """Set the chair's pose in the map that it has just made."""
        self.forget()
        if id_ in self._sheets:
            self._sheets[id_].localization.place(pose, odometry)
            self.id, self._odometry, self._track = id_, odometry, track
            self._last = _Known(id_, pose, odometry, self._look_s)
            self._askew_m = 0.0

    def forget(self) -> None:
        """Start again: discard all that was known."""
        self.id, self._last, self._odometry = "", None, None
        self._rivalled_s = -math.inf
        for sheet in self._sheets.values():
            sheet.localization.forget()

    def _settles(self, id_: str, found: Location, seen: Seen) -> bool:
        last, continues = self._last, self._continues(id_, found, seen.odometry)
        if last is not None and not continues and not _is_strong(found):
            self._forget_looks()
            return False
        recent = last is not None and self._look_s - last.time_s < _RECENT_S
        if not (continues and recent) and self._is_rivalled(id_):
            # The others' looks are kept: the chair may be where it was last known.
            self._sheets[id_].localization.lose()
            self._rivalled_s = self._look_s
            return False
        self.id = id_
        self._last = _Known(id_, found.pose, seen.odometry, self._look_s)
        return True

    def _is_rivalled(self, id_: str) -> bool:
        return any(
            self._sheets[id_].localization.is_rivalled_by(other.localization)
            for one, other in self._sheets.items()
            if one != id_
        )

    def _continues(self, id_: str, found: Location, odometry: FloatArray) -> bool:
        """Whether the chair is where odometry expects it, in the map where it was last known."""
        last = self._last
        if last is None or last.id != id_:
            return False
        guess = compose(last.pose, between(last.odometry, odometry))
        off = between(guess, found.pose)
        off_m = math.hypot(off[0], off[1])
        return bool(off_m < _OFF_M + _OFF_SHARE * last.driven_m and abs(off[2]) < _OFF_RAD)

    def _hand_over(self, before: Localization, after: Localization) -> None:
        """Keep the pose when the chair's map is replaced by a changed version."""
        if before.location is not None and self._odometry is not None:
            after.place(before.location.pose, self._odometry)

    def _advance(self, odometry: FloatArray, track: int) -> None:
        if self._odometry is not None:
            moved = between(self._odometry, odometry)
            driven_m = math.hypot(moved[0], moved[1])
            self._askew_m = max(0.0, self._askew_m - driven_m)
            if self._last is not None:
                self._last.driven_m += driven_m
        self._odometry, self._track = odometry, track

    def _forget_looks(self) -> None:
        for sheet in self._sheets.values():
            sheet.localization.lose()


def _is_strong(found: Location) -> bool:
    evidence = found.evidence
    return evidence.explained >= _ELSEWHERE_EXPLAINED and evidence.through <= _ELSEWHERE_THROUGH
