"""What must hold after every tick of a motion that nobody holds (P17-P20), as invariants.py."""

from __future__ import annotations

from collections.abc import Callable

from gazelink import codes
from gazeprove import abstract
from gazeprove.around import AUTO_CAP
from gazeprove.inputs import Blocked
from gazeprove.seen import After


def auto_moves_by_its_planner_and_under_supervision(a: After) -> bool:
    """A value of the planner no older than 150 ms, and someone seen watching this press (P17, P18).

    The supervision lasts no longer than its setting.
    """
    s = a.core.safety
    left_ms = s._supervised_ms
    watched = (
        a.read.get("supervision_edge") == a.read.get("edge")
        and 0 < left_ms <= abstract.SUPERVISION_MS
    )
    # The exploration changes commands also without a new value; then the old one counts down.
    lives = 0 < s.ttl_ms <= 150 or s.ttl_ms == a.was["ttl_ms"] - 1 > 0
    return not a.auto or bool(lives and watched)


def auto_moves_only_where_it_is_seen(a: After) -> bool:
    """Each direction of its output looked at and seen, and no faster than it may (P19)."""
    if not a.auto:
        return True
    unseen = a.read.get("clearance_unseen")
    outputs = (a.linear > 0, a.linear < 0, a.turn > 0, a.turn < 0)
    seen = isinstance(unseen, Blocked) and all(
        unseen.known.get(1 << way, 1) == 0 for way, goes in enumerate(outputs) if goes
    )
    return seen and max(abs(a.linear), abs(a.turn)) <= AUTO_CAP


def auto_is_a_drive_and_ends_with_any_press(a: After) -> bool:
    """The press that began it is the only one, and none came since (P20)."""
    if not a.auto:
        return True
    begins = a.read.get("edge") != a.was["edge"]
    return a.read.get("verb") == codes.DRIVE and a.facts.presses == int(begins)


def auto_ends_in_time(a: After) -> bool:
    """Not beyond its limit; and 10 s overruled, its press never moves again (P20)."""
    auto = a.core.safety.auto
    if a.auto:
        return bool(0 < auto.left_ms <= 1000 * abstract.AUTO_LIMIT_S and auto.overruled_ms < 10_000)
    return bool(a.core.safety.edge == 0 or auto.overruled_ms <= 10_000)


AUTO_INVARIANTS: tuple[Callable[[After], bool], ...] = (
    auto_moves_by_its_planner_and_under_supervision,
    auto_moves_only_where_it_is_seen,
    auto_is_a_drive_and_ends_with_any_press,
    auto_ends_in_time,
)
