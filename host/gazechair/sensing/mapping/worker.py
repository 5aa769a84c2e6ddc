"""The work of mapping's process, without its pipes: makes a map, or localizes the chair."""

from __future__ import annotations

import json
import logging
import math
import queue
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol

from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.pieces import Lidars
from gazechair.sensing.mapping.keeping import Keeping
from gazechair.sensing.mapping.locating.atlas import Atlas
from gazechair.sensing.mapping.locating.looks import Looks, Seen
from gazechair.sensing.mapping.locating.whereabouts import Fix
from gazechair.sensing.mapping.making import SILENT, Making
from gazechair.sensing.mapping.stored.picture import sketched
from gazechair.sensing.mapping.stored.places import EditRefused
from gazechair.sensing.mapping.stored.store import MapStore
from gazechair.sensing.odometry.estimate import Estimate

# Reasons after which saving can be retried: the collected key scans are kept.
AGAIN = ("map_not_stored", "map_full", "map_empty")

# The daemon's requests: locate the chair, make a map, store the one that was made.
KNOW, MAKE, SAVE = "know", "make", "save"
# States.
NO_MAPS, UNKNOWN, KNOWN, MAKING, SAVING = "no_maps", "unknown", "known", "making", "saving"

PULSE_S = 0.5
_LOOK_S = 0.1  # from one look to the next
_STORED_S = 1.0  # from one look at the folder to the next
_PICTURE_S = 2.0
_EAGER_S = 20.0  # full search effort for this long after the pose was known, or the maps changed
_SHARES = 1.0, 0.15  # of a core for searching: during that time, and later
_ESTIMATE_OLD_S = 1.0

log = logging.getLogger(__name__)


class Out(Protocol):
    """Receiver of its reports; see RecordWriter."""

    def data(self, payload: bytes) -> None: ...
    def facts(self, payload: bytes) -> None: ...


class Worker:
    """Feed it requests, half turns and estimates, and call `tick`."""

    def __init__(
        self,
        lidars: Lidars,
        folder: Path,
        out: Out,
        clock: Callable[[], float] = time.monotonic,
        utc: Callable[[], float] = time.time,
    ) -> None:
        self._lidars = lidars
        self._store = MapStore(folder)
        self._out = out
        self._clock = clock
        self._looks = Looks()
        self._atlas = Atlas(self._pulse)
        self._keeping = Keeping(self._store, utc)
        self._making: Making | None = None
        self._saving: threading.Thread | None = None
        self._saved: queue.Queue[dict[str, Any]] = queue.Queue()
        self._number = 0  # of the newest request
        self._newest: Estimate | None = None
        self._looked: Estimate | None = None  # the last estimate that was searched for in the maps
        self._look_s = self._stored_s = self._picture_s = self._sent_s = -math.inf
        self._eager_s = clock() + _EAGER_S
        self._drawn = 0  # key scans in the newest picture
        self._problem = ""

    def word(self, word: Mapping[str, Any]) -> None:
        """The daemon's request: KNOW, MAKE or SAVE (name, path); `n` counts requests."""
        if word["n"] == self._number or self._saving is not None:
            return
        self._number = int(word["n"])
        if word["do"] == SAVE:
            self._save(Path(word["path"]), str(word["name"]))
        elif word["do"] == MAKE:
            if find_spec("g2opy") is None:
                self._end("map_missing", "making a map needs: pip install 'gazechair[home]'")
                return
            self._making, self._drawn = Making(), 0
            self._atlas.forget()
        else:
            self._making = None
            self._eager_s = self._clock() + _EAGER_S
        self._send()

    def half(self, half: HalfTurn) -> None:
        """Take a half turn of a lidar."""
        piece = self._lidars.piece(half)
        if piece is not None:
            self._looks.piece(piece)

    def estimate(self, estimate: Estimate) -> None:
        """Take odometry's estimate."""
        self._newest = estimate
        if not self._looks.estimate(estimate) or self._saving is not None:
            return
        if self._making is not None:
            if self._making.take(self._looks) or self._clock() - self._sent_s > _LOOK_S:
                self._send()
            return
        if not self._atlas.ids or self._clock() < self._look_s:
            return
        spent_s = time.process_time()
        known = self._atlas.id
        seen = self._looks.seen()
        found, self._looked = self._atlas.look(seen), seen.estimate
        if found is None and known:
            self._eager_s = self._clock() + _EAGER_S
        self._keep(seen)
        spent_s = time.process_time() - spent_s
        searched = found is None and self._atlas.searched
        pause_s = spent_s / _SHARES[self._clock() > self._eager_s] if searched else 0.0
        self._look_s = self._clock() + max(_LOOK_S, pause_s)
        self._send()

    def _keep(self, seen: Seen) -> None:
        """Keep the stored map current."""
        location = self._atlas.location
        if location is None or not self._atlas.sure:
            self._keeping.unsure()
        elif self._keeping.look(self._atlas.id, self._atlas.grid, seen, location):
            self._look_at_store()

    def tick(self) -> None:
        """Call at least twice a second."""
        now_s = self._clock()
        self._ended()
        if now_s >= self._stored_s + _STORED_S and self._making is None and self._saving is None:
            self._look_at_store()
        if self._making is not None and now_s >= self._picture_s + _PICTURE_S:
            self._picture_s = now_s
            self._draw(self._making)
        self._pulse()

    def _look_at_store(self) -> None:
        self._stored_s = self._clock()
        before = self._atlas.ids
        stored = self._store.all()
        self._problem = next((one.problem for one in stored if one.problem), "")
        self._atlas.know({one.id: one.map.grid for one in stored if one.map is not None})
        if self._atlas.ids != before:
            self._eager_s = self._clock() + _EAGER_S
            self._send()

    def _pulse(self) -> None:
        if self._clock() >= self._sent_s + PULSE_S:
            self._send()

    def _send(self) -> None:
        self._sent_s = self._clock()
        status: dict[str, Any] = {"state": self._state(), "making": None, "problem": self._problem}
        status["askew"] = self._atlas.askew
        status["twins"] = self._atlas.rivalled
        fix = self._found() if status["state"] == KNOWN else None
        status["fix"] = None if fix is None else asdict(fix)
        if self._making is not None:
            status["making"] = self._making.as_json()
            if not status["making"]["doubt"] and self._gets_nothing():
                status["making"]["doubt"] = SILENT
        self._out.data(json.dumps(status).encode())

    def _found(self) -> Fix | None:
        location, at = self._atlas.location, self._looked
        if location is None or at is None:
            return None
        x_m, y_m, heading_rad = location.pose.tolist()
        return Fix(
            at.time_s,
            self._atlas.id,
            x_m,
            y_m,
            math.degrees(heading_rad) % 360.0,
            location.sigma_m,
            math.degrees(location.sigma_rad),
            location.evidence.explained,
            (at.x_m, at.y_m, at.heading_deg),
            at.track,
            mounting_m=location.mounting_m,
            mounting_deg=math.degrees(location.mounting_rad),
        )

    def _state(self) -> str:
        if self._saving is not None:
            return SAVING
        if self._making is not None:
            return MAKING
        if not self._atlas.ids:
            return NO_MAPS
        return KNOWN if self._atlas.id and not self._gets_nothing() else UNKNOWN

    def _gets_nothing(self) -> bool:
        """Whether odometry sends nothing: it has no scans, or does not run."""
        return self._newest is None or self._clock() - self._newest.time_s > _ESTIMATE_OLD_S

    def _draw(self, making: Making) -> None:
        if len(making.keys) == self._drawn:
            return
        self._drawn = len(making.keys)
        picture = sketched(making.keys)
        self._out.facts(json.dumps({"picture": picture.as_json()}).encode() + b"\n" + picture.png)

    def _save(self, path: Path, name: str) -> None:
        if path.exists():  # a process before this one has done it
            self._end("", "", path.stem)
        elif self._making is None:
            self._end("map_making_lost", "what was collected is gone")
        else:
            making, number = self._making, self._number

            def work() -> None:
                reason = detail = ""
                try:
                    self._store.add(making.finished(name), path.name)
                except EditRefused as error:
                    reason, detail = error.reason, str(error)
                except ValueError as error:
                    reason, detail = "map_empty", str(error)
                except Exception as error:
                    log.exception("making the map failed")
                    reason, detail = "map_not_made", repr(error)
                self._saved.put({"n": number, "reason": reason, "detail": detail, "map": path.stem})

            self._saving = threading.Thread(target=work, name="save map", daemon=True)
            self._saving.start()

    def _ended(self) -> None:
        try:
            ended = self._saved.get_nowait()
        except queue.Empty:
            return
        self._saving = None
        making = self._making
        if ended["reason"] not in AGAIN:
            self._making = None
            self._look_at_store()
        if not ended["reason"] and making is not None:
            place = making.place(self._looks)
            if place is not None:
                self._atlas.place(ended["map"], place, self._looks.pose, self._looks.track)
                self._looked = self._looks.newest
        self._out.facts(json.dumps({"ended": ended}).encode() + b"\n")
        self._send()

    def _end(self, reason: str, detail: str, map_: str = "") -> None:
        ended = {"n": self._number, "reason": reason, "detail": detail, "map": map_}
        self._out.facts(json.dumps({"ended": ended}).encode() + b"\n")
