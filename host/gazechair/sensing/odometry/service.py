"""Odometry's part in the daemon: its child process, its inbox, and the newest estimate."""

from __future__ import annotations

import json
from dataclasses import asdict

from gazechair.base.latest_value import Latest
from gazechair.base.supervisor import Status, Supervised, Supervisor
from gazechair.config.configuration import LidarConfig
from gazechair.sensing.odometry import inbox
from gazechair.sensing.odometry.odometry import Estimate, Motion

LOST = "odometry_lost"
_SILENT_S = 2.0
_NICE = 5  # what drives the chair comes first


class OdometryService(Supervised):
    """Nothing here waits for odometry, and nothing that drives the chair needs it."""

    def __init__(self, lidars: tuple[LidarConfig, ...]) -> None:
        """`lidars`: in the order in which their scans are numbered."""
        self._lidars = lidars
        self._writers, self._reader = inbox.open_inbox()
        self.latest: Latest[Estimate] = Latest()
        """Born when its measurements were made."""
        self.status: Status | None = None

    @property
    def inbox_fd(self) -> int:
        """Where the lidars' child sends its half turns."""
        return self._writers.fileno()

    def start(self) -> None:
        """Start the child process."""
        fd = self._reader.fileno()
        lidars = [asdict(config) for config in self._lidars]
        self._supervisor = Supervisor(
            "gazechair.sensing.odometry.child",
            json.dumps({"lidars": lidars, "fd": fd}),
            self._on_data,
            self._on_status,
            lost_reason=LOST,
            silent_s=_SILENT_S,
            start_s=60.0,
            nice=_NICE,
            fds=(fd,),
        )
        self._supervisor.start()

    def stop(self) -> None:
        """End the child process."""
        super().stop()
        self._writers.close()
        self._reader.close()

    def motion(self, motion: Motion) -> None:
        """What the board said. Never waits."""
        inbox.send(self._writers.fileno(), inbox.pack_motion(motion))

    def _on_data(self, payload: bytes) -> None:
        fields = json.loads(payload)
        if fields is None:  # nothing is measured
            self.latest.clear()
            return
        fields["doubts"] = tuple(fields["doubts"])
        estimate = Estimate(**fields)
        self.latest.put(estimate, estimate.time_s)
        self.status = None

    def _on_status(self, status: Status) -> None:
        self.status = status
        self.latest.clear()
