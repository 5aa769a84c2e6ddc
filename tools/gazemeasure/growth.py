"""Resources of a process: processor time, memory, threads, files; whether they grow."""

from __future__ import annotations

import contextlib
import itertools
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

_MOST_POINTS = 300


def slope_per_hour(points: Sequence[tuple[float, float]]) -> float:
    """The median of the slopes between all pairs of points (s, value): robust against peaks.

    NaN for fewer than three points.
    """
    points = points[:: 1 + len(points) // _MOST_POINTS]
    if len(points) < 3:
        return float("nan")
    pairs = itertools.combinations(points, 2)
    return 3600 * median((b - a) / (t - s) for (s, a), (t, b) in pairs if t > s)


def cpu_s(pid: int) -> float:
    """Its processor time. Raises OSError when it has ended."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def family(pid: int) -> list[int]:
    """It and all its descendants, without those that end meanwhile."""
    found = [pid]
    for one in found:
        with contextlib.suppress(OSError):
            for task in Path(f"/proc/{one}/task").iterdir():
                found += map(int, (task / "children").read_text().split())
    return found


@dataclass
class Holding:
    """The resources of one process over time: (s, value)."""

    memory_mb: list[tuple[float, float]] = field(default_factory=list)
    threads: list[tuple[float, float]] = field(default_factory=list)
    files: list[tuple[float, float]] = field(default_factory=list)

    def look(self, pid: int, now_s: float) -> None:
        """Record the present resources of `pid`. Raises OSError when it has ended."""
        status = dict(
            line.partition(":")[::2] for line in Path(f"/proc/{pid}/status").read_text().split("\n")
        )
        if "VmRSS" not in status:
            raise ProcessLookupError(f"{pid} has ended")
        self.memory_mb.append((now_s, int(status["VmRSS"].split()[0]) / 1000))
        self.threads.append((now_s, int(status["Threads"])))
        self.files.append((now_s, len(os.listdir(f"/proc/{pid}/fd"))))
