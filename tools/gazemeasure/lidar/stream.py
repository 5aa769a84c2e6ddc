"""Measures the lidar's stream: cost of decoding, effect of damage, delay until a scan counts."""

from __future__ import annotations

import json
import tempfile
import threading
import time
from dataclasses import dataclass, replace
from pathlib import Path
from queue import SimpleQueue

from gazechair.config.settings import LidarConfig
from gazechair.sensing.lidar.child import Pipeline
from gazechair.sensing.lidar.report import Report as Delivered
from gazemeasure.lidar import damage
from gazemeasure.lidar.emulator import MASK, started
from gazemeasure.lidar.process import core_share
from gazemeasure.report import Report, percentile
from gazemeasure.stalls import StallProbe

_START_S = 20.0
_ATTEMPTS = 4
_KINDS = (("wrong", 0.001, 0.0), ("lost", 0.0, 0.001))


def stream_figures(report: Report, quick: bool) -> None:
    """Append the figures; about 20 s when `quick`, else some 6 minutes."""
    alone, with_scans = damage.decode_share(5.0 if quick else 30.0)
    report.add("dense decoding, share of a core", 100.0 * alone, "%", 5.0)
    report.add("the same with freeze watch and scans", 100.0 * with_scans, "%")
    _damage(report, 60_000 if quick else 2_000_000)
    passes, wrong = damage.longest_extension(100 if quick else 3000, seed=1)
    report.add("wrong points make a degree free for at most", passes, "turns", 1.0)
    report.note(f"(turns: {wrong} capsules slipped through on purpose, 1 byte in 1000 lost)")
    _live(report, 4.0 if quick else 30.0)
    share, rate_hz = core_share(10.0 if quick else 30.0)
    report.add("the lidars' process, one lidar: share of a core", 100.0 * share, "%", 6.0)
    report.note(f"(it evaluated {rate_hz:.1f} times a second)")


def _damage(report: Report, capsules: int) -> None:
    for what, corrupt, drop in _KINDS:
        count = damage.count_undetected(capsules, corrupt, drop, seed=7)
        report.add(
            f"1 byte in 1000 {what}: undetected of 50,000 capsules",
            count.undetected * 50_000 / count.sent,
            "",
            1.0,
        )
        report.add(f"  coverage kept ({what})", 100.0 * count.decoded / count.sent, "%", 85.0, True)
        report.note(
            f"({what}: {count.undetected} of {count.sent:,} sent, some {count.hit:,} hit; "
            f"{100.0 * count.reported_share:.1f} % loss reported)"
        )


def _live(report: Report, seconds: float) -> None:
    calm, busy = _undisturbed(seconds, busy=False), _undisturbed(seconds, busy=True)
    report.add("scan end to evaluated, median", percentile(calm.latencies_ms, 0.5), "ms")
    report.add("  95 %", percentile(calm.latencies_ms, 0.95), "ms")
    report.add("  median beside a busy thread", percentile(busy.latencies_ms, 0.5), "ms")
    for name, one in (("calm", calm), ("busy thread beside", busy)):
        report.add(f"turns missing, {name}", one.missing, "", 0.0)
        report.add(f"resyncs and restarts, {name}", one.resyncs + one.restarts, "", 0.0)
        report.add("  runs until the port lost nothing", one.attempts, f"of {_ATTEMPTS}")
    report.note(
        f"(evaluated: from the port to the report, without the clearance; {calm.dropped} of "
        f"{calm.dropped + len(calm.latencies_ms)} turns left out, as the machine stood still)"
    )


@dataclass
class Live:
    """The results of a running pipeline with an emulated lidar."""

    latencies_ms: list[float]
    dropped: int
    missing: int
    resyncs: int
    restarts: int
    overflowed: int
    """Bytes that the port's driver lost."""
    attempts: int = 1


def _undisturbed(seconds: float, busy: bool) -> Live:
    """A run in which the port's driver lost nothing because the machine stalled."""
    for attempt in range(1, _ATTEMPTS + 1):
        live = replace(_run(seconds, busy), attempts=attempt)
        if not live.overflowed:
            break
    return live


def _run(seconds: float, busy: bool) -> Live:
    stopping = threading.Event()
    load = threading.Thread(target=_spin, args=(stopping,), name="busy", daemon=True)
    with tempfile.TemporaryDirectory() as folder, StallProbe() as probe:
        path = str(Path(folder) / "lidar")
        emulator = started(path)
        reports: SimpleQueue[Delivered] = SimpleQueue()
        lidar = LidarConfig(kind="s2", port=path, mask=MASK)
        pipeline = Pipeline((lidar,), reports.put)
        try:
            pipeline.open()
            pipeline.begin()
            seen_s, resyncs, restarts = _watch(reports, seconds, load if busy else None)
        finally:
            stopping.set()
            pipeline.stop()
            printed, _ = emulator.communicate(timeout=10.0)
        counted = json.loads(printed)
        ends_s: list[float] = counted["turn_ends_s"]
        pairs = [(ends_s[turn - 1], at) for turn, at in seen_s.items() if 0 < turn <= len(ends_s)]
        # A busy thread stalls the probe as well.
        good = [pair for pair in pairs if busy or not probe.stalled(*pair)]
    return Live(
        [(at - end) * 1000.0 for end, at in good],
        len(pairs) - len(good),
        # The newest turn may still be in transit.
        max(0, len(ends_s) - max(seen_s, default=0) - 1),
        resyncs,
        restarts,
        counted["lost"],
    )


def _watch(
    reports: SimpleQueue[Delivered], seconds: float, load: threading.Thread | None
) -> tuple[dict[int, float], int, int]:
    """({complete turns: time of their evaluation}, resyncs, restarts of the scan)."""
    seen_s: dict[int, float] = {}
    resyncs = restarts = turn = 0
    end_s = time.monotonic() + _START_S
    while time.monotonic() < end_s:
        (lidar,) = reports.get(timeout=_START_S).lidars
        if lidar.acquired_s is None:
            continue
        if not turn:
            end_s = time.monotonic() + seconds
            if load is not None:
                load.start()
        if lidar.quarters // 4 < turn:
            restarts += 1
            seen_s.clear()
        turn, resyncs = lidar.quarters // 4, lidar.resyncs
        if turn not in seen_s:
            seen_s[turn] = time.monotonic()
    return seen_s, resyncs, restarts


def _spin(stopping: threading.Event) -> None:
    number = 0
    while not stopping.is_set():
        for _ in range(10_000):
            number = (number * 1103515245 + 12345) & 0x7FFFFFFF
