"""Keeps the stored map current while the chair is driven in it: which looks count, and when.

Looks count only while the pose is known well, from separate places, and after the pose has stayed
known for some seconds. A drive lasts half an hour; the next one that counts begins hours later,
also when the host was switched off in between.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from datetime import datetime, timezone

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.locating.location import Location
from gazechair.sensing.mapping.locating.looks import Seen
from gazechair.sensing.mapping.stored.places import EditRefused
from gazechair.sensing.mapping.stored.store import MapStore
from gazechair.sensing.mapping.upkeep import Upkeep, load_ledger

DRIVE_S, APART_S = 1800.0, 7200.0
_LOOK_M, _LOOK_RAD = 0.15, math.radians(9.0)  # least motion of the chair between two looks
_SLOW_DEG_S = 15.0  # faster turns blur
_SETTLED_S = 5.0  # known without a break
_STORED_S = 60.0
_MOST_CELLS = 4 << 20  # larger maps are not updated: it would take too much memory

log = logging.getLogger(__name__)


class Keeping:
    """Feed it looks at known poses."""

    def __init__(self, store: MapStore, utc: Callable[[], float] = time.time) -> None:
        """`utc`: seconds since 1970."""
        self._store = store
        self._utc = utc
        self._id = ""
        self._grid: OccupancyGrid | None = None
        self._upkeep: Upkeep | None = None
        self._began_s = self._next_s = self._stored_s = self._settled_s = -math.inf
        self._noted_s: dict[str, float] = {}  # when the newest drive was, by map
        self._ahead_s: dict[str, float] = {}  # since when that time is in the future by the clock
        self._odometry: FloatArray | None = None  # at the newest look that counts
        self._too_large: set[str] = set()  # maps that the log has named

    def unsure(self) -> None:
        """The pose is unknown or in doubt: discard the newest looks, too."""
        self._settled_s = math.inf
        if self._upkeep is not None:
            self._upkeep.drop()

    def look(self, id_: str, grid: OccupancyGrid, seen: Seen, location: Location) -> bool:
        """Take a look at a well-known pose in map `id_`; True: the stored map has been updated."""
        now_s = seen.estimate.time_s
        if id_ != self._id or grid is not self._grid:
            self._id, self._grid, self._upkeep = id_, grid, None
            self._next_s = -math.inf
        if self._upkeep is None and now_s >= self._next_s:
            self._begin(id_, grid, now_s)
        upkeep = self._upkeep
        if upkeep is None:
            return False
        self._settled_s = min(self._settled_s, now_s)
        if self._counts(seen):
            upkeep.look(seen.look, location.pose)
        if now_s >= self._settled_s + _SETTLED_S:
            upkeep.settle()
            self._settled_s = now_s
        if now_s < self._stored_s + _STORED_S:
            return False
        self._stored_s = now_s
        if now_s >= self._began_s + DRIVE_S:
            self._upkeep, self._next_s = None, now_s + _STORED_S
        self._noted_s[id_] = now_s
        return self._take_over(upkeep)

    def _begin(self, id_: str, grid: OccupancyGrid, now_s: float) -> None:
        self._next_s = now_s + _STORED_S
        if grid.hits.size > _MOST_CELLS:
            if id_ not in self._too_large:
                self._too_large.add(id_)
                line = "map %s is not kept current: it has %d cells, more than %d"
                log.warning(line, id_, grid.hits.size, _MOST_CELLS)
            return
        before = load_ledger(self._store.ledger_path(id_), grid)
        if self._apart(id_, before.drive_s, now_s):
            self._upkeep = Upkeep(grid, before)
            self._began_s = self._stored_s = self._settled_s = now_s
            self._odometry = None

    def _apart(self, id_: str, drive_s: float, now_s: float) -> bool:
        """Whether the newest drive is long enough ago, even if the clock was changed since."""
        if now_s < self._noted_s.get(id_, -math.inf) + APART_S:
            return False
        if self._utc() < drive_s:  # the clock was set back: trust it again after that time
            return now_s >= self._ahead_s.setdefault(id_, now_s) + APART_S
        self._ahead_s.pop(id_, None)
        return self._utc() >= drive_s + APART_S

    def _counts(self, seen: Seen) -> bool:
        if abs(seen.estimate.yaw_rate_deg_s) > _SLOW_DEG_S:
            return False
        if self._odometry is not None:
            moved = between(self._odometry, seen.odometry)
            if math.hypot(moved[0], moved[1]) < _LOOK_M and abs(moved[2]) < _LOOK_RAD:
                return False
        self._odometry = seen.odometry
        return True

    def _take_over(self, upkeep: Upkeep) -> bool:
        now_s = self._utc()
        updated = upkeep.updated(now_s)
        try:
            if upkeep.too_much:
                log.warning("so much has changed that the map is left as it is: make a new one")
            if updated is None or self._grid is None:
                self._store.note(self._id, upkeep.ledger(now_s).save)
                return False
            when = datetime.fromtimestamp(now_s, timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
            if not self._store.update(self._id, self._grid, updated[0], when):
                return False  # the map was changed meanwhile: it is read again soon
            self._upkeep = self._grid = None
            self._store.note(self._id, updated[1].save)
            return True
        except EditRefused as error:
            log.warning("the map is not kept current: %s", error)
            return False
