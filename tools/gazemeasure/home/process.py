"""Odometry's process, fed in real time as the lidars' process and the board feed it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from gazechair.base.health import Health
from gazechair.config.settings import LidarConfig
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.obeys import Obeys
from gazechair.sensing.odometry.service import OdometryService
from gazemeasure.growth import Holding, cpu_s, slope_per_hour
from gazemeasure.report import Report, percentile
from gazemeasure.stalls import StallProbe
from gazesim import home_plans
from gazesim.home_drive import FRONT, Drive

_SECONDS, _SECONDS_QUICK = 120.0, 8.0
_STARTS_S = 30.0
_SHARE, _MOST_MB = 25.0, 200.0
_AGE_S, _LEAST_HZ = 0.15, 10.0
_WARM_S, _LOOK_S = 30.0, 1.0
_HOME = 2


def measure(report: Report, quick: bool, per_turn: int) -> None:
    """Add the rows: share of a core, memory and its growth, number and ages of the estimates.

    An estimate's age counts from its measurements until the daemon has it.
    """
    seconds = _SECONDS_QUICK if quick else _SECONDS
    events = list(Drive(home_plans.home(_HOME), _HOME, (FRONT,), per_turn).events(seconds))
    lidar = LidarConfig(kind="s2", x_m=FRONT.x_m)
    service = OdometryService((lidar,), Health("odometry"), Obeys(Health("motion"), lambda: None))
    received: list[tuple[float, float]] = []  # when it was measured, and when it came

    def receive(estimate: Estimate) -> None:
        received.append((estimate.time_s, time.monotonic()))

    service.subscribe(receive)
    service.start()
    try:
        first = next(event for event in events if not isinstance(event, Motion))
        end_s = time.monotonic() + _STARTS_S
        while not received and time.monotonic() < end_s:
            _send(service, first, time.monotonic() - first.times_s[-1])
            time.sleep(0.05)
        assert service.pid is not None
        holding, before_s = Holding(), cpu_s(service.pid)
        holding.look(service.pid, 0.0)
        received.clear()
        with StallProbe() as probe:
            begin_s = time.monotonic()
            next_s = 0.0
            for event in events:
                at_s = event.time_s if isinstance(event, Motion) else event.times_s[-1]
                time.sleep(max(0.0, begin_s + at_s - time.monotonic()))
                _send(service, event, begin_s)
                if time.monotonic() - begin_s > next_s:
                    holding.look(service.pid, time.monotonic() - begin_s)
                    next_s += _LOOK_S
        passed_s = time.monotonic() - begin_s
        core = 100.0 * (cpu_s(service.pid) - before_s) / passed_s
        report.add("odometry's process, a dense lidar: share of a core", core, "%", _SHARE)
        holding.look(service.pid, passed_s)
        add_memory(report, holding.memory_mb)
        add_estimates(report, received, passed_s, probe.stalled)
    finally:
        service.stop()


def add_estimates(
    report: Report,
    received: list[tuple[float, float]],
    passed_s: float,
    stalled: Callable[[float, float], bool],
) -> None:
    """Add how many came, and their ages; `received`: when each was measured and when it came, s.

    What is left out is decided before an estimate is late: a late one has more time for stalls.
    """
    report.add("  estimates a second", len(received) / passed_s, "", _LEAST_HZ, at_least=True)
    ages_s = [came - at for at, came in received if not stalled(at, at + _AGE_S)]
    report.add("  age of an estimate, 99 %", percentile(ages_s, 0.99), "s", _AGE_S)
    dropped = len(received) - len(ages_s)
    report.note(f"({dropped} of {len(received)} ages overlap a stall of the machine: dropped)")


def add_memory(report: Report, memory_mb: list[tuple[float, float]]) -> None:
    """Add the memory, and what it becomes in an hour if it goes on growing as once it was warm."""
    (begin_s, before_mb), (end_s, after_mb) = memory_mb[0], memory_mb[-1]
    report.add("  memory", after_mb, "MB", _MOST_MB)
    report.add(f"  grown in {end_s - begin_s:.0f} s", after_mb - before_mb, "MB")
    warm = [point for point in memory_mb if point[0] >= _WARM_S]
    if warm:  # not in a quick run
        hour_mb = after_mb + slope_per_hour(warm) * (1.0 - end_s / 3600.0)
        report.add(f"  after an hour, at the slope since {_WARM_S:g} s", hour_mb, "MB", _MOST_MB)


def _send(service: OdometryService, event: Motion | Piece, later_s: float) -> None:
    if isinstance(event, Motion):
        datagram = inbox.pack_motion(replace(event, time_s=event.time_s + later_s))
    else:
        times = float(event.times_s[0]) + later_s, float(event.times_s[-1]) + later_s
        datagram = inbox.pack_scan(HalfTurn(0, event.directions_deg, event.distances_m, *times))
    inbox.send(service.inbox_fd, datagram)
