"""Mapping's part in the daemon: its child process, its inbox, the chair's map and pose."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gazechair.base import health as states
from gazechair.base.health import Health
from gazechair.base.latest_value import Latest
from gazechair.base.supervisor import Status
from gazechair.config.settings import LidarConfig
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.inbox_service import InboxService
from gazechair.sensing.mapping.locating.whereabouts import Fix, Whereabouts, onward
from gazechair.sensing.mapping.stored.picture import Picture
from gazechair.sensing.mapping.worker import AGAIN, KNOW, MAKE, SAVE, UNKNOWN
from gazechair.sensing.odometry.estimate import Estimate

LOST = "map_lost"
NOWHERE = "map_unknown"
TWINS = "map_twins"
DAMAGED = "map_damaged"
ASKEW = "lidar_turned"
_LASTS_S = 10.0  # an unknown pose is reported after this
_NICE = 10  # lower priority than what drives the chair, and odometry
_PATIENCE_S = 20.0  # how long it may wait for a processor without counting as hung


@dataclass(frozen=True)
class Ended:
    """How the making of a map ended."""

    reason: str
    """A key of the texts; "": it is stored."""
    detail: str
    map: str


class MappingService(InboxService):
    """The daemon never waits for mapping, and driving by hand does not need it."""

    def __init__(self, lidars: tuple[LidarConfig, ...], folder: Path, health: Health) -> None:
        """`lidars`: in the order in which their scans are numbered; `folder`: of the maps."""
        super().__init__(lidars)
        self._folder = folder
        self._health = health
        self._lock = threading.Lock()
        self._number = 0
        self._wants = KNOW
        self._word: bytes | None = None  # the newest request, as sent
        self._lost_s: float | None = None  # since when the pose is unknown
        self._listeners: list[Callable[[Whereabouts], None]] = []
        self._fix: Fix | None = None
        self.latest: Latest[Whereabouts] = Latest()
        """At odometry's newest estimate, and as old as that; cleared when the pose is unknown."""
        self.state = UNKNOWN
        self.making: dict[str, Any] | None = None
        """Progress of the map that is being made; see Making.as_json."""
        self.ended: Ended | None = None
        """How the newest making of a map ended."""
        self.picture: Picture | None = None
        """Picture of the map that is being made."""

    def subscribe(self, listener: Callable[[Whereabouts], None]) -> None:
        """Call before the start. `listener` gets each pose, on a thread that must not block."""
        self._listeners.append(listener)

    def start(self) -> None:
        """Start the child process."""
        self._supervise(
            "gazechair.sensing.mapping.child",
            "map",
            {"folder": str(self._folder)},
            lost_reason=LOST,
            listens=True,
            nice=_NICE,
            patience_s=_PATIENCE_S,
            on_facts=self._on_facts,
        )
        with self._lock:  # after renew: its child must end what the one before it began
            if self._word is not None and self._supervisor is not None:
                self._supervisor.send(self._word)

    def renew(self, lidars: tuple[LidarConfig, ...]) -> None:
        """Restart the child process with other lidars."""
        self._give_up("map_making_lost", "the lidars' masks have changed")
        super().renew(lidars)

    def estimate(self, estimate: Estimate) -> None:
        """Take odometry's estimate. Never waits."""
        inbox.send(self._writers.fileno(), inbox.pack_estimate(estimate))
        fix = self._fix
        where = onward(fix, estimate) if fix is not None else None
        if where is None:
            self.latest.clear()
            return
        self.latest.put(where, where.time_s)
        for listener in self._listeners:
            listener(where)

    def make(self) -> bool:
        """Begin to make a map; False: one is being made."""
        with self._lock:
            if self._wants != KNOW:
                return False
            self.ended = self.picture = None
            self._want(MAKE)
            return True

    def save(self, path: Path, name: str) -> bool:
        """Store the map that is being made; `ended` gets the result. False: there is none."""
        with self._lock:
            if self._wants != MAKE:
                return False
            self.ended = None
            self._want(SAVE, path=str(path), name=name)
            return True

    def discard(self) -> bool:
        """Discard the map that is being made. False: there is none, or it is being stored."""
        with self._lock:
            if self._wants != MAKE:
                return False
            self._want(KNOW)
            return True

    @property
    def wants(self) -> str:
        """The current request: KNOW, MAKE or SAVE."""
        return self._wants

    def _want(self, do: str, **more: str) -> None:
        self._number += 1
        self._wants = do
        self._word = json.dumps({"n": self._number, "do": do, **more}).encode()
        if self._supervisor is not None:
            self._supervisor.send(self._word)

    def _on_data(self, payload: bytes) -> None:
        fields = json.loads(payload)
        self.state = str(fields["state"])
        self.making = fields["making"] if self._wants != KNOW else None
        fix = fields["fix"]
        self._fix = Fix(**fix) if fix is not None else None
        if fix is None:
            self.latest.clear()
        self._judge(str(fields["problem"]), bool(fields["askew"]), bool(fields["twins"]))

    def _judge(self, problem: str, askew: bool, twins: bool) -> None:
        now_s = time.monotonic()
        if self.state != UNKNOWN:
            self._lost_s = None
        elif self._lost_s is None:
            self._lost_s = now_s
        if problem:
            self._health.set(states.DEGRADED, DAMAGED, problem)
        elif askew:
            self._health.set(states.DEGRADED, ASKEW, "the map has turned under the chair")
        elif self._lost_s is not None and now_s - self._lost_s >= _LASTS_S:
            if twins:
                self._health.set(states.DEGRADED, TWINS, "two maps fit what it sees")
            else:
                text = "not in any of the maps, as far as it sees"
                self._health.set(states.DEGRADED, NOWHERE, text)
        elif self._lost_s is None or self._health.reason not in (NOWHERE, TWINS):
            self._health.set(states.OK)

    def _on_facts(self, payload: bytes) -> None:
        line, _, rest = payload.partition(b"\n")
        fields = json.loads(line)
        if "picture" in fields:
            place = fields["picture"]
            sides = int(place["width"]), int(place["height"])
            self.picture = Picture(rest, place["cell_m"], place["x"], place["y"], *sides)
            return
        ended = fields["ended"]
        with self._lock:
            if ended["n"] != self._number:
                return
            self.ended = Ended(ended["reason"], ended["detail"], ended["map"])
            if ended["reason"] in AGAIN and self._wants == SAVE:
                self._wants = MAKE
            else:
                self._want(KNOW)

    def _on_status(self, status: Status) -> None:
        self._fix = None
        self.latest.clear()
        self._lost_s = None
        if status.state == states.LOST:
            self._give_up("map_making_lost", status.detail)
        self._health.set(status.state, status.reason, status.detail)

    def _give_up(self, reason: str, detail: str) -> None:
        """The child has ended: what it had collected is lost, what it was storing may be stored."""
        with self._lock:
            if self._wants == MAKE:
                self.ended = Ended(reason, detail, "")
                self._want(KNOW)
            self.making = None
