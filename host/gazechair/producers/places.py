"""The places that the driver can choose now: their tiles and targets."""

from __future__ import annotations

import math
import time
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from gazechair.base.latest_value import Clock
from gazechair.config.rules import WORD
from gazechair.sensing.mapping.stored.places import Place
from gazechair.sensing.mapping.stored.store import MapStore, Stored

_PREFIX = "to"
_KEPT_S = 20.0  # the tiles of a map stay this long after the chair's pose in it is lost


@dataclass(frozen=True)
class Target:
    """One tile of a producer."""

    name: str
    """Its name for people."""
    icon: str
    """A sign that the page draws: one of stored.places.ICONS, or the producer's own."""
    more: Mapping[str, Any]
    """Data for its producer; a change here ends a motion to it."""
    english: str = ""
    """Its English name, unless people named it."""


class Places:
    """The places of the map that the chair is in."""

    def __init__(
        self,
        store: MapStore,
        here: Callable[[], str],
        allowed: Callable[[], bool],
        clock: Clock = time.monotonic,
    ) -> None:
        """`here`: the id of that map, "" unknown; `allowed`: this driver may use auto motions."""
        self._store = store
        self._here = here
        self._allowed = allowed
        self._clock = clock
        self._known, self._known_s = "", -math.inf

    def __call__(self) -> dict[str, Target]:
        """The targets by the name of their mode, which is unique across maps."""
        map_ = self._map() if self._allowed() else ""
        stored = self._store.get(map_) if map_ else None
        if stored is None or stored.map is None:
            return {}
        drawn = f"{stored.map.drawn.no_go}"
        mark = f"{zlib.crc32(stored.id.encode()):08x}"
        found = {
            f"{_PREFIX}-{mark}-{place.number}": _target(stored, place, drawn)
            for place in stored.map.drawn.places
        }
        return {mode: target for mode, target in found.items() if WORD.fullmatch(mode)}

    def _map(self) -> str:
        """The present map; for a moment the previous one, so that tiles do not flicker."""
        here = self._here()
        if here or self._clock() > self._known_s + _KEPT_S:
            self._known, self._known_s = here, self._clock()
        return self._known


def _target(stored: Stored, place: Place, drawn: str) -> Target:
    spot = place.spot
    more = {
        "map": stored.id,
        "x": spot.x_m,
        "y": spot.y_m,
        "heading": spot.heading_deg,
        "drawn": zlib.crc32(drawn.encode()),
    }
    return Target(place.name, place.icon, more)
