"""The rows and notes that every kind of mission has in the report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from gazemeasure.go.record import Result
from gazemeasure.report import Report, percentile

RATIO = 1.3
"""Time divided by the ideal time, at most."""


class Drive(Protocol):
    """What the truth says of a mission."""

    @property
    def arrived(self) -> bool: ...
    @property
    def collisions(self) -> int: ...
    @property
    def least_m(self) -> float: ...
    @property
    def ratio(self) -> float: ...


class Explained(Result, Protocol):
    """A result that says why the chair did not arrive."""

    @property
    def why(self) -> str: ...


def add_arrived(report: Report, kind: str, done: Sequence[Drive], least_percent: float) -> None:
    """Add how many arrived, and their collisions."""
    arrived = 100.0 * float(np.mean([one.arrived for one in done]))
    report.add(f"{kind}: arrived", arrived, f"% of {len(done)}", least_percent, at_least=True)
    report.add("  collisions", sum(one.collisions for one in done), "", 0.0)


def add_gap(report: Report, done: Sequence[Drive]) -> None:
    """Add how near the chair came to anything."""
    report.add("  smallest gap to anything", min(one.least_m for one in done), "m")


def add_ratio(report: Report, done: Sequence[Drive], limit: float | None) -> None:
    """Add the time of those that arrived."""
    ratios = [one.ratio for one in done if one.arrived]
    if ratios:
        report.add("  time by the ideal, median", percentile(ratios, 0.5), "", limit)


def note_failures(report: Report, done: Sequence[Explained]) -> None:
    """Note why a chair did not arrive."""
    for one in done:
        if not one.arrived:
            report.note(f"{one.job.kind} {one.job.seed}: {one.why}")
