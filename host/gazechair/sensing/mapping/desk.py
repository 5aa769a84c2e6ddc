"""Caretakers' requests about maps, and what is sent to the pages about them."""

from __future__ import annotations

import threading
import time
import zlib
from typing import Any

from gazechair.sensing.mapping.service import MappingService
from gazechair.sensing.mapping.stored import packed_map
from gazechair.sensing.mapping.stored.picture import Picture, drawn
from gazechair.sensing.mapping.stored.places import EditRefused
from gazechair.sensing.mapping.stored.ros_map import RosMapError
from gazechair.sensing.mapping.stored.store import ACTS, MapStore, Stored
from gazechair.sensing.mapping.worker import KNOW, MAKE, SAVE

_POSE_OLD_S = 1.0


class MapDesk:
    """Thread-safe. `service` None: there is no lidar, so no map is made and no pose known."""

    def __init__(self, store: MapStore, service: MappingService | None) -> None:
        self._store = store
        self._service = service
        self._lock = threading.Lock()
        self._drawn: tuple[Stored, Picture] | None = None  # the newest picture

    def tidy(self) -> None:
        """Clear up after an earlier daemon; no other may have the state folder."""
        self._store.tidy()

    def as_json(self) -> dict[str, Any]:
        """All maps, what is being made, and where the chair is."""
        service = self._service
        ended = service.ended if service is not None else None
        return {
            "state": service.state if service is not None else "off",
            "wants": service.wants if service is not None else KNOW,
            "making": service.making if service is not None else None,
            "ended": vars(ended) if ended is not None else None,
            "where": self.where(),
            "most_file_bytes": packed_map.MOST_BYTES,
            "maps": [self._row(one) for one in self._store.all()],
        }

    def where(self) -> dict[str, Any] | None:
        """The chair's pose in its map; None: not known."""
        entry = self._service.latest.entry() if self._service is not None else None
        if entry is None or time.monotonic() - entry.born_s > _POSE_OLD_S:
            return None
        one = entry.value
        return {
            "map": one.map,
            "version": self._store.version(one.map),
            "x": round(one.x_m, 3),
            "y": round(one.y_m, 3),
            "heading": round(one.heading_deg, 1),
            "sigma": round(one.sigma_m, 3),
            "sigma_deg": round(one.sigma_deg, 2),
        }

    def details(self, id_: str) -> dict[str, Any]:
        """One map: its picture's position, and what is drawn on it. Raises EditRefused."""
        stored = self._usable(id_)
        assert stored.map is not None
        picture = self._picture(stored)
        return {**self._row(stored), "picture": picture.as_json(), **stored.map.drawn.as_json()}

    def picture(self, id_: str) -> bytes:
        """A map as PNG. Raises EditRefused."""
        return self._picture(self._usable(id_)).png

    def files(self, id_: str) -> bytes:
        """A map as a zip file of what ROS reads. Raises EditRefused."""
        home = self._usable(id_).map
        assert home is not None
        return packed_map.pack(home)

    def add(self, data: bytes) -> str:
        """Add the map in a zip file (see `files`); returns its id. Raises EditRefused."""
        try:
            return self._store.add(packed_map.unpack(data))
        except RosMapError as error:
            raise EditRefused(error.reason, str(error)) from None

    def growing(self) -> Picture | None:
        """The map that is being made; None before there is something to see."""
        return self._service.picture if self._service is not None else None

    def change(self, request: dict[str, Any]) -> None:
        """Do one act: on the map being made, or on the stored map `map`. Raises EditRefused."""
        acts = [key for key in request if key != "map"]
        if len(acts) != 1:
            raise EditRefused("map_request", "send one act")
        (act,) = acts
        value = request[act]
        if "map" not in request:
            self._making(act, value)
            return
        id_ = request["map"]
        if not isinstance(id_, str):
            raise EditRefused("map_request", '"map" is a text')
        if act in ACTS:
            self._store.draw(id_, act, value)
        elif act == "rename":
            self._store.rename(id_, value)
        elif act == "delete" and value is True:
            self._store.delete(id_)
        elif act == "back" and value is True:
            if not self._store.take_back(id_):
                raise EditRefused("map_no_update", "no drive has changed it")
        else:
            raise EditRefused("map_request", f"there is no act {act!r}")

    def _making(self, act: str, value: Any) -> None:
        service = self._service
        if act not in (MAKE, SAVE, "discard") or (act != SAVE and value is not True):
            raise EditRefused("map_request", f"there is no act {act!r}")
        if service is None:
            raise EditRefused("map_no_lidar", "there is no lidar, or odometry is off")
        if act == MAKE:
            if len(self._store.all()) >= MapStore.MOST:
                raise EditRefused("map_full", f"there are at most {MapStore.MOST} maps")
            done = service.make()
        elif act == SAVE:
            name = self._store.check_name(value)
            done = service.save(self._store.path_of_new(), name)
        else:
            done = service.discard()
        if not done:
            raise EditRefused("map_busy", f"it is doing something else: {service.wants}")

    def _usable(self, id_: str) -> Stored:
        stored = self._store.get(id_)
        if stored is None:
            raise EditRefused("map_gone", f"there is no map {id_!r} any more")
        if stored.map is None:
            raise EditRefused("map_damaged", stored.problem)
        return stored

    def _picture(self, stored: Stored) -> Picture:
        assert stored.map is not None
        with self._lock:
            if self._drawn is None or self._drawn[0] is not stored:
                self._drawn = stored, drawn(stored.map)
            return self._drawn[1]

    def _row(self, stored: Stored) -> dict[str, Any]:
        home = stored.map
        problem = "map_before" if stored.problem else ""
        return {
            "map": stored.id,
            "name": home.name if home is not None else "",
            "made": home.made if home is not None else "",
            "floor_m2": stored.floor_m2,
            "updates": self._store.updates(stored.id),
            "updated": home.updated if home is not None else "",
            "drawn": zlib.crc32(repr(home.drawn).encode()) if home is not None else 0,
            "problem": problem if home is not None else "map_damaged",
        }
