"""Odometry's part in the daemon: its child process, its inbox, and the newest estimate."""

from __future__ import annotations

import json
import time
from collections.abc import Callable

from gazechair.base import health as states
from gazechair.base.health import Health
from gazechair.base.latest_value import Latest
from gazechair.base.supervisor import Status
from gazechair.config.settings import LidarConfig
from gazechair.sensing.inbox.inbox_service import InboxService
from gazechair.sensing.odometry import doubts
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.obeys import Obeys

LOST = "odometry_lost"
UNSURE = "odometry_unsure"
DIFFERS = "odometry_heading"
_DIFFERS_S = 10.0  # shown for this long: a scale error shows in turns only
_LASTS_S = 5.0  # a doubt that lasts for less is not reported
_NICE = 5  # lower priority than what drives the chair


class OdometryService(InboxService):
    """The daemon never waits for odometry, and driving by hand does not need it."""

    def __init__(self, lidars: tuple[LidarConfig, ...], health: Health, obeys: Obeys) -> None:
        """`lidars`: in the order in which their scans are numbered."""
        super().__init__(lidars)
        self._health = health
        self._listeners: list[Callable[[Estimate], None]] = []
        self._obeys = obeys
        self._doubted_s: float | None = None
        self._differs_s = 0.0
        self._turned: int | None = None
        self._turned_by_walls = False
        self.latest: Latest[Estimate] = Latest()
        """Its age counts from its measurements."""

    def subscribe(self, listener: Callable[[Estimate], None]) -> None:
        """Call before the start. `listener` gets each estimate, on a thread that must not block."""
        self._listeners.append(listener)

    def start(self) -> None:
        """Start the child process."""
        child = "gazechair.sensing.odometry.child"
        self._supervise(child, "odometry", {}, lost_reason=LOST, nice=_NICE)

    def _on_data(self, payload: bytes) -> None:
        fields = json.loads(payload)
        if fields is None:  # nothing is measured
            self.latest.clear()
            self._obeys.unknown()
            if self._health.now().state != states.STARTING:
                self._judge("no scans arrive")
            return
        fields["doubts"] = tuple(fields["doubts"])
        estimate = Estimate(**fields)
        self.latest.put(estimate, estimate.time_s)
        self._obeys.judge(estimate)
        if doubts.DIFFERS in estimate.doubts:
            self._differs_s = time.monotonic()
        self._turned, self._turned_by_walls = estimate.turned_lidar, estimate.turned_by_walls
        self._judge(", ".join(doubts.UNSURE.intersection(estimate.doubts)))
        for listener in self._listeners:
            listener(estimate)

    def _judge(self, doubt: str) -> None:
        """Report a doubt once it has lasted."""
        now_s = time.monotonic()
        if not doubt:
            self._doubted_s = None
        if self._turned is not None:
            names = [config.name for config in self._lidars]
            names.insert(0, names.pop(self._turned))
            names = names[:1] if self._turned_by_walls else names
            text = f"a lidar seems to be turned on its mount: {' or '.join(names)}"
            self._health.set(states.DEGRADED, doubts.TURNED, text, " / ".join(names))
        elif now_s < self._differs_s + _DIFFERS_S:
            self._health.set(states.DEGRADED, DIFFERS, "the lidars see another heading")
        elif not doubt:
            self._health.set(states.OK)
        elif self._doubted_s is None:
            self._doubted_s = now_s
        elif now_s - self._doubted_s >= _LASTS_S:
            self._health.set(states.DEGRADED, UNSURE, doubt)

    def _on_status(self, status: Status) -> None:
        self.latest.clear()
        self._obeys.unknown()
        self._doubted_s = None
        self._turned = None
        self._health.set(status.state, status.reason, status.detail)
