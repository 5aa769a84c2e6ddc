"""The daemon's side of the black box: takes records from any thread, never waits for a disk."""

from __future__ import annotations

import json
import logging
import socket
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from gazechair.base import health as states
from gazechair.base.health import HealthRegistry
from gazechair.base.latest_value import Entry
from gazechair.base.reasons import PARTS
from gazechair.base.supervisor import Status, Supervised, Supervisor
from gazechair.blackbox.ring import Ring
from gazechair.config.settings import LidarConfig, LogConfig
from gazechair.picture.camera import Frame
from gazechair.picture.reducer import LEVELS, Reducer
from gazechair.sensing.mapping.locating.whereabouts import Whereabouts
from gazechair.sensing.odometry.estimate import Estimate

LOST = "log_lost"
MISSING = "log_missing"
DROPPING = "log_dropping"
_PICTURE_MOST = 1 << 16  # bytes
_PICTURE_LEVEL = LEVELS.index(next(level for level in LEVELS if level.width >= 320))
_PACE_S = 0.1
_HEALTH_S = 1.0
_MOTION_S = 0.095  # a lidar's half turns come each 50 ms
_PATIENCE_S = 57.0  # a disk may take that long
_LAST_PACE_S = 0.01
_LAST_S = 2.0  # at the end, queued records are handed over for this long, to a process that reads
_NICE = 10
_LINE = 500  # characters
_LOGGED = tuple(
    f"gazechair.{room}"
    for room in ("base", "board", "daemon", "driving", "picture", "plugins", "sensing", "threads")
)


class BlackBox(Supervised):
    """The parts call this to record something; when the log is off it does nothing.

    Records are queued in a bounded ring; a thread hands them to the log's process.
    """

    def __init__(
        self,
        config: LogConfig,
        folder: Path,
        parts: HealthRegistry,
        picture: Callable[[], Entry[Frame] | None] = lambda: None,
        lidars: Sequence[LidarConfig] = (),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`folder`: where the files go; `picture`: the camera's newest; `lidars`: where
        each sits."""
        self._config = config
        self._folder = folder
        self._parts = parts
        self._newest_picture = picture
        self._places = [
            (lidar.name, lidar.x_m, lidar.y_m, lidar.heading_deg, lidar.upside_down)
            for lidar in lidars
            if lidar.kind != "off"
        ]
        self._clock = clock
        self._ring = Ring()
        self._on = False
        self._reducer: Reducer | None = None
        self._picture = 0
        self._late_s = 0.0
        self._motion_due_s = self._pose_due_s = 0.0
        self._reported_dropped = 0
        self._status: Status | None = None  # the newest of its process
        self._figures: dict[str, int] = {}
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="log", daemon=True)
        self._handler = _Lines(self)

    def start(self) -> None:
        """Start the log's process, if the configuration enables the log."""
        health = self._parts.part("log")
        if find_spec("mcap_ros2") is None:
            health.set(states.LOST, MISSING, "nothing is recorded: pip install 'gazechair[log]'")
            return
        self._ours, self._its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._ours.setblocking(False)
        argument = {
            "folder": str(self._folder),
            "max_bytes": self._config.max_mb * 1000000,
            "keep_s": self._config.keep_days * 86400.0,
            "fd": self._its.fileno(),
        }
        self._supervisor = Supervisor(
            "gazechair.blackbox.child",
            json.dumps(argument),
            self._on_figures,
            self._on_status,
            lost_reason=LOST,
            silent_s=PARTS["log"].silent_s,
            patience_s=_PATIENCE_S,
            nice=_NICE,
            fds=(self._its.fileno(),),
        )
        self._on = True
        self._supervisor.start()
        self._thread.start()
        logging.getLogger("gazechair").addHandler(self._handler)

    def stop(self) -> None:
        """Hand over the queued records, and end the process, which writes them."""
        if not self._on:
            return
        logging.getLogger("gazechair").removeHandler(self._handler)
        self._on = False
        self._ended.set()
        self._thread.join(5.0)
        super().stop()
        self._ours.close()
        self._its.close()

    def note(self, kind: str, at_s: float, payload: Any) -> None:
        """Record `payload`; see topics. Callable from any thread."""
        if self._on:
            self._ring.put(kind, at_s, payload)

    def scan(self, name: str, acquired_s: float, beams_mm: bytes) -> None:
        """Record one turn of a lidar."""
        self.note("scan", acquired_s, (name, beams_mm))

    def motion(self, estimate: Estimate) -> None:
        """Record odometry's estimate with its age; at most one per 0.1 s."""
        now_s = self._clock()
        if now_s >= self._motion_due_s:
            self._motion_due_s = now_s + _MOTION_S
            age_s = now_s - estimate.time_s
            self.note("motion", estimate.time_s, {**asdict(estimate), "age_s": age_s})

    def pose(self, where: Whereabouts) -> None:
        """Record the chair's pose in a map; at most one per 0.1 s."""
        if self._clock() < self._pose_due_s:
            return
        self._pose_due_s = self._clock() + _MOTION_S
        self.note("pose", where.time_s, (where.map, where.x_m, where.y_m, where.heading_deg))

    def _on_figures(self, figures: bytes) -> None:
        self._figures = json.loads(figures)

    def _on_status(self, status: Status) -> None:
        self._status = status
        self._parts.part("log").set(status.state, status.reason, status.detail)

    def _run(self) -> None:
        due_s = self._clock()
        health_s = 0.0
        while not self._ended.is_set():
            self._late_s = max(self._late_s, self._clock() - due_s)
            if self._clock() >= health_s:
                health_s = self._clock() + _HEALTH_S
                self._look()
            self._ring.hand_over(self._ours)
            due_s = self._clock() + _PACE_S
            self._ended.wait(_PACE_S)
        end_s = self._clock() + _LAST_S
        self._ring.hand_over(self._ours)
        while len(self._ring) and self._clock() < end_s:
            time.sleep(_LAST_PACE_S)
            self._ring.hand_over(self._ours)

    def _look(self) -> None:
        now_s = self._clock()
        parts = self._parts.states().items()
        rows = [(name, part.state, part.reason, part.detail) for name, part in parts]
        self.note("health", now_s, rows)
        figures = {
            "late_ms": round(1000 * self._late_s, 1),
            "waiting": len(self._ring),
            "dropped": self._ring.dropped,
            **self._figures,
        }
        self._late_s = 0.0
        self.note("figures", now_s, figures)
        self.note("places", now_s, self._places)
        self._note_picture()
        drops = self._ring.dropped != self._reported_dropped
        self._reported_dropped = self._ring.dropped
        health, status = self._parts.part("log"), self._status
        if status is None:
            return
        if drops and status.state == states.OK:  # else the process has reported the reason
            detail = f"{self._ring.dropped} records were dropped: the disk is too slow"
            health.set(states.DEGRADED, DROPPING, detail)
        elif health.reason == DROPPING:
            health.set(status.state, status.reason, status.detail)

    def _note_picture(self) -> None:
        entry = self._newest_picture() if self._config.pictures else None
        if entry is None or entry.version == self._picture:
            return
        self._picture = entry.version
        self._reducer = self._reducer or Reducer()
        jpeg = self._reducer.reduced(entry.value, min(_PICTURE_LEVEL, self._reducer.top))
        if len(jpeg) <= _PICTURE_MOST:
            self.note("picture", entry.born_s, jpeg)


class _Lines(logging.Handler):
    """The host's own log, from the packages whose lines name no person."""

    def __init__(self, box: BlackBox) -> None:
        super().__init__(logging.INFO)
        self._box = box

    def emit(self, record: logging.LogRecord) -> None:
        if not record.name.startswith(_LOGGED):
            return
        try:
            text = record.getMessage()[:_LINE]
        except Exception:  # a malformed log call is not our error
            return
        self._box.note("line", time.monotonic(), (record.levelno, record.name, text))
