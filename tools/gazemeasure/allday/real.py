"""The demo's processes in real time, a random part of which fails each 20 s: recovery, growth."""

from __future__ import annotations

import random
import tempfile
import time
from pathlib import Path

from gazedemo.packages import package
from gazedemo.stack import Stack
from gazemeasure.allday.faults import (
    BACK_S,
    DAEMON,
    Background,
    Fault,
    Recovery,
    Well,
    by_part,
    shuffled,
)
from gazemeasure.allday.person import Person
from gazemeasure.allday.service import Service
from gazemeasure.growth import Holding, slope_per_hour
from gazemeasure.report import Report, percentile
from gazemeasure.stalls import StallProbe
from gazereplay.replay import replay
from gazereplay.result import NoTrace

_PERIOD_S = 20.0
_LOOK_S = 2.0
_DRIVES_S = 30.0
_WARM_S = 120.0  # after the daemon's start: then its caches are full
_LIFE_S = _WARM_S + 600.0  # of the last daemon: then slopes say something
_WHOLE_S = 1800.0  # a run of this length must judge growth
# Of recorded drives: the board sends 100 decisions a second; gaps were 0.2 % on a free machine.
_COMPARED_HZ, _UNCHECKED = 50.0, 5.0
# Nobody listens there: failed alerts are retried again and again.
_CONFIG = """
[[alerts.route]]
name = "anna"
url = "json://127.0.0.1:9/anna"
[input.quiet0]
"""


def packages(folder: Path) -> str:
    """An installed package with the plug-in."""
    inputs = {"quiet0": "gazemeasure.plugins_samples:Quiet"}
    return package(folder, "gazemeasure_allday", {"gazechair.inputs": inputs})


class _Growth:
    """Resources of the present daemon; a new daemon starts a new record."""

    def __init__(self, stack: Stack) -> None:
        self._stack = stack
        self._pid = 0
        self.began_s = 0.0
        self.holding = Holding()

    def look(self) -> None:
        """Record them now."""
        if self._stack.pid("host") != self._pid:
            self._pid = self._stack.pid("host")
            self.began_s = time.monotonic()
            self.holding = Holding()
        self.holding.look(self._pid, time.monotonic())


def add(report: Report, micropython: str, lasts_s: float, seed: int = 14) -> None:
    """Run for `lasts_s`. Faults of the daemon come first, so that the last daemon can grow."""
    plan = shuffled(random.Random(seed), round(lasts_s / _PERIOD_S))
    plan.sort(key=lambda fault: fault.part != DAEMON)
    times: dict[Fault, list[Well]] = {}
    stuck: list[str] = []
    planned = 0
    with (
        tempfile.TemporaryDirectory(prefix="gazechair-") as name,
        StallProbe() as probe,
    ):
        service = Service(Path(name))
        with (
            Stack(
                micropython,
                "open",
                more_config=_CONFIG,
                packages=packages(Path(name)),
                environment=service.environment,
            ) as stack,
            service.of(stack),
            Person(stack, probe) as person,
        ):
            growth, recovery = _Growth(stack), Recovery(stack)
            try:
                with Background("growth", _LOOK_S, growth.look):
                    for fault in plan:
                        begun_s, aborted = time.monotonic(), service.aborted
                        times.setdefault(fault, []).append(recovery.of(fault))
                        if person.drove_after(time.monotonic(), _DRIVES_S) == float("inf"):
                            stuck.append(
                                f"{fault.part} {fault.how}: {person.state} {stack.health()}"
                            )
                        time.sleep(max(0.0, begun_s + _PERIOD_S - time.monotonic()))
                        planned += restarts_due(fault, service.aborted - aborted)
            finally:
                recovery.close()
            log_mb = sum(f.stat().st_size for f in (stack.state_folder / "log").iterdir()) / 1e6
            _add_replay(report, sorted((stack.state_folder / "log").iterdir()), lasts_s)
    _add_recovery(report, times, stuck)
    report.add("  restarts of the daemon that no fault explains", service.restarts - planned, "", 0)
    _add_growth(report, growth.holding, growth.began_s, person, lasts_s)
    report.add("  log", log_mb, "MB")
    report.note(f"daemon: {service.restarts} restarts, {service.aborted} by the watchdog; started")
    report.note("again as the unit file says. Well: its health is ok, and its process another one.")


def restarts_due(fault: Fault, aborted: int) -> int:
    """How often the daemon starts anew by `fault`, the watchdog having ended it that often."""
    if fault.part != DAEMON:
        return 0
    return min(1, aborted) if fault.how == "starved" else 1


def _add_replay(report: Report, logs: list[Path], lasts_s: float) -> None:
    """Replay the recorded drives, each up to where its log was cut."""
    ticks = compared = unchecked = differing = skipped = 0
    for path in logs:
        try:
            result = replay(path)
        except NoTrace:  # it ended before the board had sent anything
            skipped += 1
            continue
        ticks += result.ticks
        compared += result.compared
        unchecked += result.unchecked
        differing += result.difference is not None
        if result.difference is not None:
            report.note(f"{path.name}: {result.difference}")
    report.add("processes: ticks of the recorded drives replayed", ticks, "")
    least = _COMPARED_HZ * lasts_s
    report.add("  decisions compared", compared, "", least, at_least=True)
    share = 100.0 * unchecked / max(1, ticks + unchecked)
    report.add("  ticks in gaps of the record", share, "%", _UNCHECKED)
    report.add("  files without a trace", skipped, f"of {len(logs)}")
    report.add("  files with a different decision", differing, "", 0)


def _add_recovery(report: Report, times: dict[Fault, list[Well]], stuck: list[str]) -> None:
    report.add("processes: faults", sum(map(len, times.values())), "")
    for part, values in sorted(by_part(times).items()):
        own, took = [one.own_s for one in values], [one.took_s for one in values]
        report.add(f"  {part}: well again, p95", percentile(own, 0.95), "s", BACK_S)
        report.add("    and with waiting for a processor", percentile(took, 0.95), "s")
    report.add("  not driving again by arm and press", len(stuck), "", 0)
    for fault, values in times.items():
        if max(one.own_s for one in values) > BACK_S:
            seconds = ", ".join(f"{one.own_s:.1f} ({one.took_s:.1f})" for one in values)
            report.note(f"{fault.part} {fault.how}: {seconds} s")
            for one in values:
                if one.health:
                    report.note(f"  {one.health}")
    for line in stuck[:5]:
        report.note(line)


def _add_growth(
    report: Report, holding: Holding, began_s: float, person: Person, lasts_s: float
) -> None:
    """`began_s`: of the last daemon. A whole run has limits even if that one did not live long."""
    warm_s = began_s + _WARM_S
    lived_s = holding.memory_mb[-1][0] - began_s
    whole = lasts_s >= _WHOLE_S
    judged = whole or lived_s >= _LIFE_S

    def slope(name: str, points: list[tuple[float, float]], unit: str, most: float) -> None:
        warm = [point for point in points if point[0] >= warm_s]
        report.add(f"  {name}, slope", slope_per_hour(warm), unit, most if judged else None)

    report.add("  the last daemon's life", lived_s, "s", _LIFE_S if whole else None, at_least=True)
    report.add("  its memory", holding.memory_mb[-1][1], "MB")
    slope("memory", holding.memory_mb, "MB/h", 5.0)
    slope("threads", holding.threads, "1/h", 0.0)
    slope("open files", holding.files, "1/h", 0.0)
    latency = person.to_wipers
    report.add("  press -> wipers, p95", percentile([ms for _, ms in latency], 0.95), "ms")
    share = 100.0 * len(latency) / max(1, person.presses)
    report.add("    measured: it drove, and without a stall", share, "%")
    slope("press -> wipers", latency, "ms/h", 5.0)
