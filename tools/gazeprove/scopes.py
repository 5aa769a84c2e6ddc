"""The explorations that make up the proof: some causes in pairs, the others alone, other rules."""

from __future__ import annotations

from gazelink import codes
from gazeprove.inputs import CAUSES, Scope

# Those that meet in the same lines of the core; all others meet in the random runs only.
_PAIRS = (
    ("emergency", "exception"),
    ("emergency", "session"),
    ("host", "service"),
    ("imu", "heading"),
    ("lidar", "source"),
    ("session", "stop"),
    ("obeys", "exception"),
    ("obeys", "wiper"),
    ("stop", "tilt"),
    ("wiper", "exception"),
)


def _of(*causes: str) -> Scope:
    return Scope(" + ".join(causes), frozenset(causes))


def scopes(quick: bool) -> list[Scope]:
    """The explorations of the quick or of the full form."""
    if quick:
        return [Scope("nothing goes wrong")]
    # The longest first, so that no process waits for the last one.
    return [
        Scope("every command and order", all_commands=True),
        # What a pair explores holds all that happens with either of its causes alone.
        *(_of(cause) for cause in reversed(CAUSES) if not any(cause in pair for pair in _PAIRS)),
        *(_of(*pair) for pair in reversed(_PAIRS)),
        Scope("a contact that nobody fitted", frozenset({"relay"}), relay_fitted=False),
        Scope("no relay feedback", frozenset({"wiper"}), relay_fitted=False),
        Scope("simulated board", frozenset({"source"}), simulated=True),
        Scope("no hard timer", boot_faults=1 << codes.NO_HARD_TIMER, never_drives=True),
        Scope("emergency stored", boot_faults=1 << codes.EMERGENCY),
    ]
