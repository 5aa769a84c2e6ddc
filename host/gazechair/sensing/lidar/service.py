"""The lidars' part in the daemon: watches the child process and publishes the clearance."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict

from gazechair.base import health as states
from gazechair.base.health import Health
from gazechair.base.reasons import PARTS
from gazechair.base.supervisor import Status, Supervised, Supervisor
from gazechair.board.board_commands import Clearance
from gazechair.board.zone import NOT_KNOWN, BoardZone
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.sensing.lidar import zone_message
from gazechair.sensing.lidar.recorded import unpack
from gazechair.sensing.lidar.report import DAMAGED, LOST, ONE, VIEW, LidarReport, Report

# Equal reports in a row, some 0.3 s, before another verdict on the view counts.
_STEADY = 12
_DAMAGED_SHARE = 0.02

Publish = Callable[[Clearance], None]
# Gets name, monotonic seconds and beams in mm: see recorded.
Record = Callable[[str, float, bytes], None]


class LidarService(Supervised):
    """Runs the lidars and publishes the clearance with each renewed scan.

    Without new data it publishes nothing: the age of the last clearance keeps growing.
    """

    def __init__(
        self,
        lidars: tuple[LidarConfig, ...],
        footprint: FootprintConfig,
        publish: Publish,
        health: Health,
        record: Record | None = None,
        inbox_fds: tuple[int, ...] = (),
    ) -> None:
        """`publish` is called on the lidars' thread, some 40 times a second, and must not block;
        the same for `record`, twice a second for each lidar. `inbox_fds`: get every half turn.
        """
        self._inbox_fds = inbox_fds
        self._configs = tuple(config for config in lidars if config.kind != "off")
        self._footprint = footprint
        self._publish = publish
        self._health = health
        self._record = record
        self._published: Clearance | None = None
        self._verdict = _Steady()
        self.report: Report | None = None
        self._zone = zone_message.pack(NOT_KNOWN)

    def start(self) -> None:
        """Start the child process; with kind "off" only report that in the health."""
        if not self._configs:
            self._health.set(states.LOST, LOST, 'no lidar is configured: set lidar.kind = "s2"')
            return
        argument = {
            "lidars": [asdict(config) for config in self._configs],
            "footprint": asdict(self._footprint),
            "record": self._record is not None,
            "inbox_fds": self._inbox_fds,
        }
        self._supervisor = Supervisor(
            "gazechair.sensing.lidar.child",
            json.dumps(argument),
            self._on_data,
            self._on_status,
            lost_reason=LOST,
            silent_s=PARTS["lidar"].silent_s,
            listens=True,
            on_facts=self._on_scan,
            fds=self._inbox_fds,
        )
        self._supervisor.send(self._zone)
        self._supervisor.start()

    def renew(self, lidars: tuple[LidarConfig, ...]) -> None:
        """Restart the child process with these lidars."""
        self.stop()
        self._configs = tuple(config for config in lidars if config.kind != "off")
        self.start()

    def zone(self, zone: BoardZone) -> None:
        """The board's new stopping distances. From any thread, also before the start."""
        self._zone = zone_message.pack(zone)
        if self._supervisor is not None:
            self._supervisor.send(self._zone)

    def describe(self) -> str:
        """What the lidars deliver now, in one line."""
        found = []
        for one in self.report.lidars if self.report else ():
            if one.rate_hz is not None and one.coverage is not None:
                figures = f"{one.points} points, {one.rate_hz:.1f} turns/s"
                found.append(f"{one.name} {figures}, sees {one.coverage:.0%} of its view")
        return "; ".join(found) or "delivers nothing"

    def _on_data(self, payload: bytes) -> None:
        report = Report.unpack(payload)
        self.report = report
        found = report.evaluation
        if report.acquired_s is not None and report.source is not None and found is not None:
            # Its time is the oldest measurement's: where one is late, others may have news.
            newest = Clearance(source=report.source, acquired_s=report.acquired_s, **found)
            if newest != self._published:
                self._published = newest
                self._publish(newest)
        self._publish_health(report)

    def _on_scan(self, payload: bytes) -> None:
        if self._record is not None:
            self._record(*unpack(payload))

    def _publish_health(self, report: Report) -> None:
        lost = [one for one in report.lidars if one.state != states.OK]
        if lost:
            self._verdict.forget()
            worst = min(lost, key=lambda one: one.state != states.LOST)
            if worst.state == states.LOST and len(lost) < len(report.lidars):
                detail = self._named(worst, worst.detail or worst.reason)
                self._health.set(states.DEGRADED, ONE, detail)
            elif worst.state != states.STARTING or self._health.state != states.LOST:
                self._health.set(worst.state, worst.reason, self._named(worst, worst.detail))
            return
        verdict = self._verdict.settle(tuple(_doubt(one) for one in report.lidars))
        if verdict is None:
            return
        for one, reason in zip(report.lidars, verdict, strict=True):
            if reason:
                self._health.set(states.DEGRADED, reason, self._named(one, _explain(one, reason)))
                return
        self._health.set(states.OK)

    def _named(self, lidar: LidarReport, detail: str) -> str:
        return f"{lidar.name}: {detail}" if len(self._configs) > 1 else detail

    def _on_status(self, status: Status) -> None:
        self._verdict.forget()
        self._health.set(status.state, status.reason, status.detail)


class _Steady:
    """A verdict counts once it has been the same for a while; a first good one at once."""

    def __init__(self) -> None:
        self._candidate: tuple[str, ...] = ()
        self._count = 0
        self._settled: tuple[str, ...] | None = None

    def forget(self) -> None:
        self._settled = None
        self._count = 0

    def settle(self, verdict: tuple[str, ...]) -> tuple[str, ...] | None:
        self._count = self._count + 1 if verdict == self._candidate else 1
        self._candidate = verdict
        if self._count >= _STEADY or (self._settled is None and not any(verdict)):
            self._settled = verdict
        return self._settled


def _doubt(lidar: LidarReport) -> str:
    """Reason key for what is wrong with its data, "" for nothing."""
    if lidar.lost_share > _DAMAGED_SHARE:
        return DAMAGED
    return VIEW if lidar.blind_deg else ""


def _explain(lidar: LidarReport, reason: str) -> str:
    if reason == DAMAGED:
        return f"{lidar.lost_share:.0%} of the lidar's bytes arrive damaged: check its cable"
    arcs = ", ".join(f"{start}..{end}" for start, end in lidar.blind_deg)
    return f"the lidar is blind at {arcs} degrees (left positive): clean or clear its view"
