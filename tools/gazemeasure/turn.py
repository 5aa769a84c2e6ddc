"""Turns that land: the board's turn controller beside the time-optimal bound of the same chair.

Chairs are gazesim's twin; the board's own motion code turns them at 1 kHz by a heading sensor of
100 Hz. The bound knows the chair and what disturbs it beforehand: see turn_bound.
"""

from __future__ import annotations

from collections.abc import Sequence

from gazemeasure import turn_bound
from gazemeasure.report import Report, percentile
from gazemeasure.turn_cases import grid, monte_carlo
from gazemeasure.turn_jobs import DEFAULTS, KNOWN, TUNED, Done, Job, run_all
from gazemeasure.turn_judge import DEFINITIONS

_CHAIRS = 1000
_CHAIRS_QUICK = 24


def measure(quick: bool) -> Report:
    """Run everything; see Report."""
    chairs = monte_carlo(_CHAIRS_QUICK if quick else _CHAIRS)
    cases = grid()
    report = Report(f"turn: 50 undisturbed turns and {len(chairs)} random chairs")
    found = run_all([Job(TUNED, drawn) for drawn in cases])
    bounds = list(turn_bound.bounds([drawn.case for drawn in cases]))
    _grid_figures(report, found, bounds)
    _grid_table(report, found, bounds)
    found = run_all([Job(TUNED, drawn) for drawn in chairs])
    bounds = list(turn_bound.bounds([drawn.case for drawn in chairs]))
    _chair_figures(report, found, bounds)
    _default_figures(report, run_all([Job(DEFAULTS, drawn) for drawn in chairs]))
    found = run_all([Job(KNOWN, drawn) for drawn in chairs])
    report.add("exactly known: settle within 2.5 x", _within(found, bounds), "%")
    for line in DEFINITIONS:
        report.note(line)
    return report


def _grid_figures(report: Report, found: Sequence[Done], bounds: Sequence[float]) -> None:
    ratios = _ratios(found, bounds)
    report.add("grid: settling / bound, median", percentile(ratios, 0.5), "x", 1.5)
    report.add("grid: settling / bound, p95", percentile(ratios, 0.95), "x", 2.0)
    tens = [done for done in found if abs(done.job.drawn.case.angle_deg) == 10]
    slow = [_settled(done) for done in tens if done.job.drawn.profile == "1.2"]
    fast = [_settled(done) for done in tens if done.job.drawn.profile != "1.2"]
    report.add("grid: 10 deg on 2.1-5.1, slowest", max(fast), "s", 3.0)
    report.add("grid: 10 deg on 1.2, slowest", max(slow), "s", 4.5)
    report.add("grid: overshoot, most", max(d.verdict.overshoot_deg for d in found), "deg", 1.0)


def _chair_figures(report: Report, found: Sequence[Done], bounds: Sequence[float]) -> None:
    ratios = _ratios(found, bounds)
    within = _within(found, bounds)
    report.add("chairs: settle within 2.5 x their bound", within, "%", 99, at_least=True)
    report.add("chairs: tuning refused", sum(d.refused != "" for d in found), "")
    report.add("chairs: settling / bound, median", percentile(ratios, 0.5), "x")
    report.add("chairs: oscillate", sum(d.verdict.oscillates for d in found), "", 0)
    off = sum(d.verdict.end_error_deg > 2.0 for d in found)
    report.add("chairs: end more than 2 deg off", off, "", 0)
    report.add("chairs: largest rest error", max(d.verdict.end_error_deg for d in found), "deg")


def _default_figures(report: Report, found: Sequence[Done]) -> None:
    report.add("untuned defaults: unstable", sum(d.verdict.unstable for d in found), "", 0)
    report.add("untuned defaults: do not stop", sum(not d.verdict.stands for d in found), "", 0)
    report.add("untuned defaults: oscillate", sum(d.verdict.oscillates for d in found), "")
    error = percentile([d.verdict.end_error_deg for d in found], 0.95)
    report.add("untuned defaults: rest error, p95", error, "deg")


def _grid_table(report: Report, found: Sequence[Done], bounds: Sequence[float]) -> None:
    report.note("profile angle  ours s  bound s  ratio  overshoot  rest error deg")
    for done, bound in zip(found, bounds, strict=True):
        v, drawn = done.verdict, done.job.drawn
        report.note(
            f"{drawn.profile:>7} {drawn.case.angle_deg:>5.0f} {_settled(done):>7.2f} {bound:>8.2f}"
            f" {_settled(done) / bound:>6.2f} {v.overshoot_deg:>10.2f} {v.end_error_deg:>11.2f}"
        )


def _settled(done: Done) -> float:
    """Settling time, s; inf when it never settled."""
    seconds = done.verdict.settled_s
    return float("inf") if seconds != seconds else seconds


def _within(found: Sequence[Done], bounds: Sequence[float]) -> float:
    """Share, %, that settle within 2.5 x their own bound."""
    return 100 * sum(ratio <= 2.5 for ratio in _ratios(found, bounds)) / len(found)


def _ratios(found: Sequence[Done], bounds: Sequence[float]) -> list[float]:
    return [_settled(done) / bound for done, bound in zip(found, bounds, strict=True)]
