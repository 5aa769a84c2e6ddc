"""The figures and the table of the turn benchmark."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gazeboard.core.limits import WIPER_MAX, WIPER_MIN
from gazechair.base.arrays import FloatArray
from gazemeasure.report import Report, percentile
from gazemeasure.turn.jobs import Done, Steps
from gazemeasure.turn.judge import Verdict
from gazemeasure.turn.stops import Stops

_TIMES = 2.5  # x the bound: limit for tuned chairs
_OFF_DEG = 2.0


def of_grid(report: Report, found: Sequence[Done], best: FloatArray) -> None:
    """Add the figures of tuned, undisturbed chairs."""
    ratios = _ratios(found, best)
    report.add("undisturbed: settling / bound, median", percentile(ratios, 0.5), "x", 1.5)
    report.add("undisturbed: settling / bound, p95", percentile(ratios, 0.95), "x", 2.0)
    tens = [done for done in found if abs(done.job.drawn.case.angle_deg) == 10]
    slow = [settled_s(done) for done in tens if done.job.drawn.profile == "1.2"]
    fast = [settled_s(done) for done in tens if done.job.drawn.profile != "1.2"]
    report.add("undisturbed: 10 deg on 2.1-5.1, slowest", max(fast), "s", 3.0)
    report.add("undisturbed: 10 deg on 1.2, slowest", max(slow), "s", 4.5)
    over = max(done.verdict.overshoot_deg for done in found)
    report.add("undisturbed: overshoot, most", over, "deg", 1.0)


def of_steps(report: Report, steps: Sequence[Steps]) -> None:
    """Add the figures of ten steps in a row."""
    shown = max(abs(abs(s.shown_deg) - 100.0) for s in steps)
    true = max(abs(abs(s.true_deg) - 100.0) for s in steps)
    report.add("ten steps of 10 deg: off by the sensor, most", shown, "deg", _OFF_DEG)
    report.add("ten steps of 10 deg: truly off, most", true, "deg")


def of_chairs(report: Report, found: Sequence[Done], best: FloatArray) -> None:
    """Add the figures of tuned random chairs and floors."""
    ratios = _ratios(found, best)
    within = 100 * sum(ratio <= _TIMES for ratio in ratios) / len(ratios)
    verdicts = [done.verdict for done in found]
    report.add("random chairs: settle within 2.5 x their bound", within, "%", 99, at_least=True)
    report.add("random chairs: settling / bound, median", percentile(ratios, 0.5), "x")
    report.add("random chairs: settling / bound, p99", percentile(ratios, 0.99), "x")
    report.add("random chairs: oscillate", sum(v.oscillates for v in verdicts), "", 0)
    off = sum(v.end_error_deg > _OFF_DEG for v in verdicts)
    report.add("random chairs: end more than 2 deg off", off, "", 0)
    report.add("random chairs: rest error, most", max(v.end_error_deg for v in verdicts), "deg")
    report.add("random chairs: left the band again", sum(v.left_again for v in verdicts), "")
    report.add("random chairs: tuning refused", sum(done.refused != "" for done in found), "")
    for text in sorted({done.refused for done in found if done.refused}):
        report.note(f"tuning refused: {text}")


def of_defaults(report: Report, found: Sequence[Done]) -> None:
    """Add the figures of the same chairs, untuned: with their profile's default settings."""
    verdicts = [done.verdict for done in found]
    report.add("untuned defaults: unstable", sum(v.unstable for v in verdicts), "", 0)
    report.add("untuned defaults: do not stop", sum(not v.stands for v in verdicts), "", 0)
    report.add("untuned defaults: oscillate", sum(v.oscillates for v in verdicts), "")
    error = percentile([v.end_error_deg for v in verdicts], 0.95)
    report.add("untuned defaults: rest error, p95", error, "deg")


def of_published(report: Report, ours: Sequence[Done], first: Sequence[Done]) -> None:
    """Add the figures of the published turn, on the chairs identified from it."""
    report.add("published 10 deg on 4.1: ours, slowest", max(map(settled_s, ours)), "s")
    report.add("published 10 deg on 4.1: first prototype", max(map(settled_s, first)), "s")


def of_stops(report: Report, stops: Stops, done: Sequence[Done]) -> None:
    """Add the figures of interrupted turns, and of the wipers in all runs."""
    report.add("paths that cut a turn short", stops.paths, "")
    report.add("  did not end it", stops.never, "", 0)
    report.add("  ticks not neutral without permission", stops.not_neutral, "", 0)
    report.add("  Stop decoded to neutral", stops.worst_stop_ticks, "ticks", 1)
    low = min([stops.lowest, *(each.verdict.counts[0] for each in done)])
    high = max([stops.highest, *(each.verdict.counts[1] for each in done)])
    report.add("turn wiper, lowest count", low, "", WIPER_MIN, at_least=True)
    report.add("turn wiper, highest count", high, "", WIPER_MAX)


def table(
    report: Report, found: Sequence[Done], best: FloatArray, rivals: dict[str, list[Done]]
) -> None:
    """Add a table of all controllers' settling times per undisturbed turn."""
    report.note("settling time, s, the slower of left and right; undisturbed")
    names = list(rivals)
    report.note(
        f"{'profile':>8}{'angle':>6}{'bound':>8}{'ours':>8}{'ratio':>7}{'over':>6}"
        + ("".join(f"{name:>11}" for name in names))
    )
    for at in range(0, len(found), 2):
        both, drawn = found[at : at + 2], found[at].job.drawn
        bound, ours = max(best[at : at + 2]), max(map(settled_s, both))
        over = max(done.verdict.overshoot_deg for done in both)
        line = f"{drawn.profile:>8}{abs(drawn.case.angle_deg):>6.0f}{bound:>8.2f}{ours:>8.2f}"
        line += f"{max(_ratios(both, best[at : at + 2])):>7.2f}{over:>6.2f}"
        for name in names:
            theirs = [
                done.verdict
                for done in rivals[name]
                if done.job.drawn.profile == drawn.profile
                and abs(done.job.drawn.case.angle_deg) == abs(drawn.case.angle_deg)
            ]
            line += f"{_words(theirs):>11}"
        report.note(line)


def _words(verdicts: Sequence[Verdict]) -> str:
    if not verdicts:
        return "-"
    slowest = max(_or_inf(v.settled_s) for v in verdicts)
    swings = " ~" if any(v.oscillates for v in verdicts) else ""
    return ("never" if math.isinf(slowest) else f"{slowest:.2f}") + swings


def settled_s(done: Done) -> float:
    """Settling time, s; inf when it never settled."""
    return _or_inf(done.verdict.settled_s)


def _or_inf(seconds: float) -> float:
    return math.inf if math.isnan(seconds) else seconds


def _ratios(found: Sequence[Done], best: FloatArray) -> list[float]:
    return [settled_s(done) / bound for done, bound in zip(found, best, strict=True)]
