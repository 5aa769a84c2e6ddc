"""Tables of published and simulated values, as text."""

from __future__ import annotations

from gazesim.chair_axis import Axis
from gazesim.profiles import PROFILES
from gazetwin.clues import CLUES, TENTH_DEG, Match, profile_axis
from gazetwin.experiment import CUTOFF_DEG, run
from gazetwin.fit import BOUNDS, Candidate, ranges
from gazetwin.prototype import PUBLISHED, Reading


def chair(turn: Axis) -> str:
    """The fitted numbers of a chair, on one line."""
    return ", ".join(f"{name} {getattr(turn, name):.3g}" for name in BOUNDS)


def clues(found: Match) -> str:
    """One line per clue: published, the range for it, simulated, whether it holds."""
    width = max(len(clue.published) for clue in CLUES.values())
    lines = [f"  {'published':<{width}}  {'taken as':>12}  {'simulated':>10}"]
    for key, value in found.found.items():
        clue = CLUES[key]
        taken = f"{clue.low:g}..{clue.high:g}"
        verdict = "holds" if clue.miss(value) == 0.0 else "MISSES"
        lines.append(
            f"  {clue.published:<{width}}  {taken:>12}  {value:>10.2f} {clue.unit:<4} {verdict}"
        )
    return "\n".join(lines)


def profiles(turn: Axis, reading: Reading) -> str:
    """Experiment B on every profile of the same chair, for 60 s."""
    lines = ["  experiment B     to within 10 %   left after 60 s"]
    for profile in PROFILES:
        trace = run(profile_axis(turn, profile), reading, PUBLISHED, 60.0, CUTOFF_DEG, profile)
        settled = trace.settled_s(TENTH_DEG)
        lines.append(
            f"  profile {profile}    {settled:>12.1f} s  {trace.error_deg(60.0):>12.2f} deg"
        )
    return "\n".join(lines)


def fitted(reading: Reading, tried: list[Candidate]) -> str:
    """What a search found under one reading: how many chairs, the best, ranges, what it misses."""
    holding = [c for c in tried if c.match.holds()]
    lines = [
        (
            f"{reading.name}: {len(tried)} chairs near the clues, "
            f"all {len(CLUES)} clues hold in {len(holding)}"
        )
    ]
    if not tried:
        return lines[0]
    best = tried[0]
    lines.append(f"  best (cost {best.match.cost:.2f}): {chair(best.axis())}")
    missed = [
        f"{CLUES[key].published}: {value:.2f}"
        for key, value in best.match.found.items()
        if CLUES[key].miss(value)
    ]
    lines += [f"  misses {text}" for text in missed]
    if holding:
        lines.append("  ranges in which all clues held, over every chair found:")
        for name, (low, high) in ranges(holding).items():
            lines.append(f"    {name:<12} {low:8.3g} .. {high:<8.3g} searched {BOUNDS[name]}")
    return "\n".join(lines)


def slices(found: dict[str, list[tuple[float, float]]], turn: Axis) -> str:
    """Around the twin, one number changed at a time: the range in which every clue still holds."""
    lines = ["  changed alone    twin    every clue holds from .. to"]
    for name, points in found.items():
        here = getattr(turn, name)
        low, high = holds_around(points, here)
        lines.append(f"  {name:<12} {here:>8.3g}    {low:.3g} .. {high:.3g}")
    return "\n".join(lines)


def holds_around(points: list[tuple[float, float]], here: float) -> tuple[float, float]:
    """The stretch of points (value, cost) around `here` along which the cost stays zero."""
    low = high = here
    for value, cost in sorted((p for p in points if p[0] <= here), reverse=True):
        if cost:
            break
        low = value
    for value, cost in sorted(p for p in points if p[0] >= here):
        if cost:
            break
        high = value
    return low, high
