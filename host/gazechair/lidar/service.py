"""The lidar's part in the daemon: watches the child process and publishes the obstacle flags."""

from __future__ import annotations

import json
from collections.abc import Callable

from gazechair import health as states
from gazechair.children import Status, Supervisor
from gazechair.config import LidarConfig, SectorsConfig
from gazechair.health import Health
from gazechair.lidar.report import LOST, VIEW, Report
from gazechair.lidar.sectors import ALL_BLOCKED, MIN_COVERAGE, Reading, Sector, blocked_bits
from gazelink import codes

# So many reports in a row, some 0.3 s, before the view counts as poor, or as good again.
_STEADY = 12

Publish = Callable[[int, int, float], None]


class LidarService:
    """Runs the lidar and publishes (blocked bits, source, acquired_s) with each renewed scan.

    While nothing new comes nothing is published: the age of the last word grows by itself.
    """

    def __init__(
        self,
        lidars: tuple[LidarConfig, ...],
        sectors: SectorsConfig,
        publish: Publish,
        health: Health,
    ) -> None:
        """`publish` is called on the lidar's thread, some 40 times a second, and must not block."""
        self._config = lidars[0]
        self._sectors = classic(sectors)
        self._distance_m = sectors.distance_m
        self._publish = publish
        self._health = health
        self._bits = ALL_BLOCKED
        self._view = _View(tuple(_name(s) for s in self._sectors))
        self.report: Report | None = None
        self._supervisor: Supervisor | None = None

    @property
    def restarts(self) -> int:
        """How often the child process had to be started again."""
        return self._supervisor.restarts if self._supervisor else 0

    @property
    def pid(self) -> int | None:
        """Process id of the child, None while there is none."""
        return self._supervisor.pid if self._supervisor else None

    def start(self) -> None:
        """Start the child process; with kind "off" only the health says so."""
        if self._config.kind == "off":
            self._health.set(states.LOST, LOST, 'no lidar is configured: set lidar.kind = "s2"')
            return
        argument = {
            "port": self._config.port,
            "sectors": [(s.direction, s.from_deg, s.to_deg) for s in self._sectors],
        }
        self._supervisor = Supervisor(
            "gazechair.lidar.child",
            json.dumps(argument),
            self._on_data,
            self._on_status,
            lost_reason=LOST,
        )
        self._supervisor.start()

    def stop(self) -> None:
        """Stop the lidar's motor, its process and its thread."""
        if self._supervisor is not None:
            self._supervisor.stop()

    def _on_data(self, payload: bytes) -> None:
        report = Report.unpack(payload)
        self._bits = blocked_bits(self._sectors, report.readings, self._distance_m, self._bits)
        self._publish(self._bits, report.source, report.acquired_s)
        self.report = report
        poor = self._view.judge(report.readings)
        if poor is None:
            return
        if poor:
            names = ", ".join(poor)
            self._health.set(
                states.DEGRADED, VIEW, f"the lidar hardly sees {names}: clean or clear its view"
            )
        else:
            self._health.set(states.OK)

    def _on_status(self, status: Status) -> None:
        self._bits = ALL_BLOCKED
        self._view.forget()
        if status.state == states.STARTING and self._health.state == states.LOST:
            return  # one more attempt: it stays lost, with its explanation, until it delivers
        self._health.set(status.state, status.reason, status.detail)


class _View:
    """Which sectors are seen too poorly, once that has been so for a while."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self._names = names
        self._candidate: tuple[str, ...] = ()
        self._count = 0
        self._settled: tuple[str, ...] | None = None

    def forget(self) -> None:
        self._settled = None
        self._count = 0

    def judge(self, readings: tuple[Reading, ...]) -> tuple[str, ...] | None:
        """Names of the poorly seen sectors; None until the first verdict."""
        pairs = zip(self._names, readings, strict=True)
        poor = tuple(name for name, reading in pairs if reading.coverage < MIN_COVERAGE)
        self._count = self._count + 1 if poor == self._candidate else 1
        self._candidate = poor
        if self._count >= _STEADY or (self._settled is None and not poor):
            self._settled = poor
        return self._settled


def classic(config: SectorsConfig) -> tuple[Sector, ...]:
    """The first prototype's sectors, and the rear when it is configured."""
    arcs = (
        (codes.DIR_FORWARD, config.front_deg),
        (codes.DIR_LEFT, config.left_deg),
        (codes.DIR_RIGHT, config.right_deg),
        (codes.DIR_BACKWARD, config.rear_deg),
    )
    return tuple(Sector(direction, *arc) for direction, arc in arcs if arc is not None)


def _name(sector: Sector) -> str:
    return str(codes.DIRECTIONS[sector.direction])
