"""Tables of published and simulated values, as text."""

from __future__ import annotations

from gazesim.chair_axis import Axis
from gazesim.profiles import PROFILES
from gazetwin.clues import CLUES, TENTH_DEG, Match, profile_axis
from gazetwin.experiment import CUTOFF_DEG, run
from gazetwin.prototype import PUBLISHED, Reading

_FITTED = ("dead_time_s", "deadband", "lag_s", "accelerate", "brake", "friction", "stiction")


def chair(turn: Axis) -> str:
    """The parameters of a chair's turns, on one line."""
    return ", ".join(f"{name} {getattr(turn, name):.3g}" for name in _FITTED)


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
