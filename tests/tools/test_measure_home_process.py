"""The benchmark of odometry's process: estimates late, too few, or none fall short."""

from __future__ import annotations

import pytest

from gazemeasure.home.process import add_estimates
from gazemeasure.report import Report

AGE, NUMBER = "age of an estimate, 99 %", "estimates a second"
PASSED_S = 10.0


def every(period_s: float, late_s: float) -> list[tuple[float, float]]:
    """When each of these was measured, and when it came."""
    count = round(PASSED_S / period_s)
    return [(period_s * n, period_s * n + late_s) for n in range(count)]


def short(received: list[tuple[float, float]], stall_each_s: float = 100.0) -> set[str]:
    """What falls short if the machine stalls for 6 ms so often."""

    def stalled(start_s: float, end_s: float) -> bool:
        return end_s % stall_each_s < 0.006 or end_s // stall_each_s > start_s // stall_each_s

    report = Report("home")
    add_estimates(report, received, PASSED_S, stalled)
    assert report.ok is all(figure.ok for figure in report.figures)
    return {figure.name.strip() for figure in report.figures if not figure.ok}


@pytest.mark.parametrize(
    ("received", "falls_short"),
    [
        (every(0.05, 0.04), set()),
        (every(0.05, 0.4), {AGE}),
        (every(0.2, 0.04), {NUMBER}),
        ([], {AGE, NUMBER}),
    ],
)
def test_late_or_seldom_or_never_falls_short(
    received: list[tuple[float, float]], falls_short: set[str]
) -> None:
    assert short(received) == falls_short


def test_one_in_25_that_is_late_falls_short() -> None:
    received = [
        (at, came + 2.0 if n % 25 == 0 else came) for n, (at, came) in enumerate(every(0.05, 0.04))
    ]
    assert short(received) == {AGE}


def test_late_ones_are_not_left_out_sooner_than_others() -> None:
    received = [
        (at, came + 0.5 if n % 8 == 0 else came) for n, (at, came) in enumerate(every(0.05, 0.04))
    ]
    assert short(received, stall_each_s=0.33) == {AGE}
