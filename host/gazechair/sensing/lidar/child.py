"""The lidars' child process: one thread per lidar reads and decodes; all are evaluated together.

A single process, because each clearance depends on all lidars. The evaluation runs after each
quarter turn of any lidar, on that lidar's thread: waking another one costs a tenth of an
evaluation. When a thread hangs, the process ends, and the daemon restarts it.
"""

from __future__ import annotations

import gc
import math
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from io import FileIO, RawIOBase
from typing import Any, BinaryIO

import numpy as np

from gazechair.base import health as states
from gazechair.base.child_main import child_main
from gazechair.base.child_records import RecordWriter
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.sensing.clearance.evaluate import Evaluator, footprint_of
from gazechair.sensing.inbox.half_turns import HalfTurns
from gazechair.sensing.lidar import recorded, zone_message
from gazechair.sensing.lidar.blind import BINS, BLIND, MASKED, SEEN, Blindness
from gazechair.sensing.lidar.reader import Reader
from gazechair.sensing.lidar.report import LOST, LidarReport, Report
from gazechair.sensing.lidar.scan import ChairView, Placing, Pose, Scan, view_of
from gazechair.sensing.lidar.stream import Tap

_PULSE_S = 0.1  # a report at least this often, also without scans
_HANGS_S = 12.0
_LINE = 4096  # bytes of a line from the parent
_SWITCH_S = 0.0005  # a computing thread yields to one with a scan this soon

# Gets each report, one at a time, on any thread.
Deliver = Callable[[Report], None]
# Evaluates all views to plain JSON values. One view for each lidar, in the configuration's order; a
# lidar that delivers nothing has a view without points that is blind wherever it is not masked.
Evaluate = Callable[[tuple[ChairView, ...]], dict[str, Any]]


class Lidar:
    """One lidar as the evaluation sees it: its reader, its pose and its newest view."""

    def __init__(
        self, config: LidarConfig, renewed: Callable[[], None], tap: Tap | None = None
    ) -> None:
        pose = Pose(config.x_m, config.y_m, config.heading_deg, config.upside_down)
        self._placing = Placing(pose, config.mask)
        self.reader = Reader(config, renewed, tap, self._placing)
        self.scan: Scan | None = None
        self._seen: Scan | None = None
        self._blindness = Blindness()
        # However narrow its view: one that delivers nothing sees nothing.
        blind = np.where(self._placing.masked_bins, MASKED, BLIND).astype(np.uint8)
        self._nothing = replace(view_of(_no_scan(), self._placing), states=blind)
        self.view = self._nothing

    def renew(self) -> None:
        """Take the reader's newest scan, if it has changed."""
        self.scan = self.reader.scan
        if self.scan is None:
            self.view = self._nothing
            self._seen = None
        elif self.scan is not self._seen:
            self._seen = self.scan
            self.view = view_of(self.scan, self._placing, self._blindness)

    def report(self) -> LidarReport:
        """Its condition, for the daemon."""
        condition, stream, scan = self.reader.condition, self.reader.stream, self.scan
        named = (self.reader.config.name, condition.state, condition.reason, condition.detail)
        if scan is None or stream is None:
            return LidarReport(*named)
        seen = self.view.states.tobytes()
        unmasked = BINS - seen.count(MASKED)
        return LidarReport(
            *named,
            source=scan.source,
            acquired_s=scan.acquired_s,
            rate_hz=round(stream.rate_hz, 2),
            coverage=round(seen.count(SEEN) / max(1, unmasked), 3),
            blind_deg=_arcs(self.view.states == BLIND) if BLIND in seen else (),
            points=len(scan),
            quarters=stream.quarters,
            lost_share=round(stream.lost_share, 4),
            resyncs=stream.resyncs,
        )


class Pipeline:
    """Runs all lidars, and evaluates them with each scan.

    Call `open`, `begin`, and then `watch` in a loop.
    """

    def __init__(
        self,
        configs: tuple[LidarConfig, ...],
        deliver: Deliver,
        inbox_fds: Sequence[int] = (),
    ) -> None:
        """`inbox_fds`: inboxes that get every half turn."""
        self._evaluate: Evaluate | None = None
        self._deliver = deliver
        self._lock = threading.Lock()  # one thread at a time evaluates and delivers
        self._due_s = time.monotonic() + _PULSE_S
        self._failed: Exception | None = None
        self._begun = False
        self.lidars = tuple(
            Lidar(config, self._renewed, HalfTurns(at, inbox_fds).take if inbox_fds else None)
            for at, config in enumerate(configs)
        )

    def _renewed(self) -> None:
        try:
            with self._lock:
                self._report()
        except Exception as error:  # end the process, not only this lidar's thread
            self._failed = error

    def open(self) -> None:
        """Start every lidar's thread; shortens the time that one thread of the process can take."""
        sys.setswitchinterval(_SWITCH_S)
        for lidar in self.lidars:
            lidar.reader.start()

    def begin(self, evaluate: Evaluate | None = None) -> None:
        """Deliver from now on, with an evaluation if there is one."""
        self._evaluate = evaluate
        self._begun = True

    def stop(self) -> None:
        """Stop every lidar's motor and thread."""
        for lidar in self.lidars:
            lidar.reader.stop()

    def hanging(self) -> str | None:
        """The name of a lidar whose thread does not return; None when all do."""
        oldest_s = time.monotonic() - _HANGS_S
        for lidar in self.lidars:
            if lidar.reader.alive_s < oldest_s:
                return lidar.reader.config.name
        return None

    def watch(self) -> None:
        """Wait at most 0.1 s; deliver a report if none was delivered in that time.

        Raises the exception of a failed evaluation or delivery.
        """
        time.sleep(max(0.0, self._due_s - time.monotonic()))
        if self._failed is not None:
            raise self._failed
        with self._lock:
            if time.monotonic() >= self._due_s:
                self._report()

    def _report(self) -> None:
        if not self._begun:
            return
        self._due_s = time.monotonic() + _PULSE_S
        for lidar in self.lidars:
            lidar.renew()
        scans = [lidar.scan for lidar in self.lidars if lidar.scan is not None]
        evaluation = None
        if scans and self._evaluate is not None:
            evaluation = self._evaluate(tuple(lidar.view for lidar in self.lidars))
        report = Report(
            lidars=tuple(lidar.report() for lidar in self.lidars),
            acquired_s=min((scan.acquired_s for scan in scans), default=None),
            source=max((scan.source for scan in scans), default=None),
            evaluation=evaluation,
        )
        self._deliver(report)


def _no_scan() -> Scan:
    return Scan(np.zeros(0), np.zeros(0), 0.0, 0)


def _arcs(flags: np.ndarray[Any, np.dtype[np.bool_]]) -> tuple[tuple[int, int], ...]:
    """Runs of flagged degrees as [from, to) in -180..180; one that passes 180 is cut there."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int8), [0]))))
    half = BINS // 2
    return tuple(
        (int(a) - half, int(b) - half) for a, b in zip(edges[::2], edges[1::2], strict=True)
    )


def read_zones(lines: BinaryIO | RawIOBase, evaluator: Evaluator) -> None:
    """Take the board's stopping distances and times from the parent, until it ends."""
    while line := lines.readline(_LINE):
        evaluator.zone = zone_message.unpack(line)


def run(argument: Mapping[str, Any], out: RecordWriter) -> int:
    """Serve until the parent closes the pipe (BrokenPipeError); 1 when a thread hangs."""
    configs = tuple(
        LidarConfig(**{**fields, "mask": tuple(tuple(arc) for arc in fields["mask"])})
        for fields in argument["lidars"]
    )
    fields = argument["footprint"]
    corners_m = tuple((x, y) for x, y in fields["corners_m"])
    footprint = footprint_of(FootprintConfig(**{**fields, "corners_m": corners_m}))
    record_s = time.monotonic() if argument["record"] else math.inf

    def deliver(report: Report) -> None:
        nonlocal record_s
        out.data(report.pack())
        if time.monotonic() >= record_s:
            record_s = time.monotonic() + recorded.PERIOD_S
            for lidar in pipeline.lidars:
                if lidar.scan is not None:
                    out.facts(recorded.pack(lidar.reader.config.name, lidar.scan))

    pipeline = Pipeline(configs, deliver, argument["inbox_fds"])
    try:
        pipeline.open()
        # Its tables take some tenths of a second: meanwhile devices open and motors run up.
        evaluator = Evaluator(footprint, [(config.x_m, config.y_m) for config in configs])
        pipeline.begin(evaluator)
        # Unbuffered: a thread waiting in stdin's own buffer at the process's end makes it crash.
        lines = FileIO(sys.stdin.fileno(), closefd=False)
        ear = threading.Thread(target=read_zones, args=(lines, evaluator), name="zone", daemon=True)
        ear.start()
        gc.freeze()  # present objects stay: exclude them from collections
        while (name := pipeline.hanging()) is None:
            pipeline.watch()
    finally:
        pipeline.stop()
    out.status(states.LOST, LOST, f"{name} hangs; starting it again")
    return 1


def main() -> int:
    """Entry of `python -m gazechair.sensing.lidar.child JSON`: lidars, footprint, ..."""
    return child_main(run)


if __name__ == "__main__":
    sys.exit(main())
