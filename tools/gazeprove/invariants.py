"""What must hold after every tick, stated from docs/safety.md and not taken from the core's code.

An input that the core did not look at cannot have been judged: then it must not have mattered.
"""

from __future__ import annotations

from collections.abc import Callable

from gazelink import codes
from gazeprove import abstract
from gazeprove.inputs import Blocked
from gazeprove.invariants_auto import AUTO_INVARIANTS
from gazeprove.seen import After, bits

_HEADING = bits(codes.HEADING_FROZEN, codes.HEADING_BUS, codes.HEADING_RESET, codes.HEADING_JUMP)
_WARNINGS = _HEADING | bits(codes.OBSTACLE_DATA_OLD)
_RELAY = bits(codes.RELAY_OPEN, codes.RELAY_STUCK)
_WIPER = bits(codes.WIPER)
_ONLY_NEUTRAL = bits(codes.HOST_SILENT, codes.SERVICE_STALLED, codes.TILT, codes.TILT_UNKNOWN)
_LATCHED = bits(
    codes.WIPER,
    codes.TICK_EXCEPTION,
    codes.EMERGENCY,
    codes.WATCHDOG_BOOTS,
    codes.STORAGE,
    codes.DISOBEYS,
    codes.RELAY_UNEXPECTED,
)


def _ahead(edge: int, old: int) -> bool:
    """Serial numbers of one byte."""
    return (edge - old) % 256 in range(1, 128)


def motion_only_when_armed(a: After) -> bool:
    """Not a count from neutral unless armed before this tick, enabled and permitted."""
    s = a.core.safety
    before = a.was["state"] == codes.ARMED and a.was["owner"] != codes.NOBODY
    tripped = (not a.facts.verified and s._wiper_bad == 3) or a.facts.often
    return not a.moving or (before and (tripped or (s.state == codes.ARMED and s.enable)))


def motion_only_while_all_live(a: After) -> bool:
    """Host and service loop heard, no lost tick, contact not open for long (P2, P9, P10)."""
    s = a.core.safety
    return not a.moving or (
        s._host_age_ms < 98
        and s._service_age_ms < 48
        and not a.facts.late
        and s._steady_ms >= 500
        and (not a.fitted or s._open_ms < 25)
        and a.read.get("calibrated") is True
    )


def motion_only_by_the_owner(a: After) -> bool:
    """The command's owner is the owner, and a session began before (P13)."""
    s = a.core.safety
    owner = a.was["owner"] if s.state != codes.ARMED else s.owner
    return not a.moving or (
        a.read.get("owner") == owner != codes.NOBODY and not a.facts.new_session
    )


def motion_only_on_a_fresh_command(a: After) -> bool:
    """Time to live is left, or a step with an end of its own is under way (P3, P4)."""
    if not a.moving:
        return True
    running = a.was["edge"] != 0 and a.was["edge"] == a.read.get("edge")
    step = a.read.get("mode") == codes.STEP and a.read.get("verb") != codes.DRIVE
    straight = a.read.get("verb") in (codes.FORWARD, codes.BACKWARD)
    limit_ms = abstract.STEP_MS if straight else abstract.TURN_LIMIT_MS
    in_time = not step or a.core.motion._elapsed_ms <= limit_ms
    return (a.core.safety.ttl_ms > 0 or (step and running)) and in_time


def motion_only_where_it_is_free(a: After) -> bool:
    """Obstacle data fresh, and looked at and free in each direction of the output (P5, P6)."""
    if not a.moving:
        return True
    blocked = a.read.get("clearance_blocked")
    age_ms = a.core.safety._clearance_age_ms
    old = a.was["faults"] >> codes.OBSTACLE_DATA_OLD & 1
    if not isinstance(blocked, Blocked) or age_ms >= (248 if old else 298):
        return False
    ways = [1 << codes.DIR_FORWARD] if a.linear > 0 else []
    ways += [1 << codes.DIR_BACKWARD] if a.linear < 0 else []
    ways += [1 << codes.DIR_LEFT] if a.turn > 0 else []
    ways += [1 << codes.DIR_RIGHT] if a.turn < 0 else []
    return all(blocked.known.get(way, way) == 0 for way in ways)


def turns_only_with_a_heading(a: After) -> bool:
    """Heading sampled in time and no heading fault (P7)."""
    return a.turn == 0 or (a.core.safety._heading_age_ms < 48 and a.read.get("heading_faults") == 0)


def motion_only_without_faults(a: After) -> bool:
    """No tilt, no emergency, no fault but warnings that leave this way possible (P11, P16)."""
    s = a.core.safety
    faults = s.faults & ~_WARNINGS & ~(_WIPER if a.badly_written else 0)
    return not a.moving or (
        faults == 0
        and a.read.get("tilted") is False
        and a.read.get("service_faults") == 0
        and not a.facts.emergency_open
        and not a.facts.message
    )


def motion_only_by_a_live_press(a: After) -> bool:
    """Its number is ahead of all before, no stop came after it, and it never changes (P14)."""
    if not a.moving:
        return True
    edge = a.read.get("edge", 0)
    if edge == 0:
        return False
    if edge != a.was["edge"]:
        # The newest before it is what was spent, or what a stop in this tick spends: only numbers
        # within half the circle are ahead or behind, so the one counts or the other.
        newest = a.was["edge"] or a.was["spent_edge"]
        stop = a.read.get("stop_edge", 0) if a.facts.stopped else 0
        if stop and (newest == 0 or _ahead(stop, newest)):
            newest = stop
        return newest == 0 or _ahead(edge, newest)
    same = a.read.get("verb") == a.was["_verb"] and a.read.get("mode") == a.was["_mode"]
    return same and not a.facts.stopped and not a.handed_over


def motion_goes_as_asked(a: After) -> bool:
    """Direction as commanded, size within the settings; STOP is never a motion."""
    if not a.moving:
        return True
    settings = a.core.motion._settings
    verb = a.read.get("verb", codes.STOP)
    stepwise = verb != codes.DRIVE and a.read.get("mode") != codes.CONTINUOUS
    turn_limit = settings.step_turn_permille if stepwise else settings.turn_permille
    if abs(a.linear) > settings.linear_permille or abs(a.turn) > turn_limit:
        return False
    if verb == codes.DRIVE:
        linear, turn = a.read["linear_permille"], a.read["turn_permille"]
        if turn == 0:
            held = settings.hold_permille if linear > 0 else 0
            return abs(a.turn) <= held and a.linear * linear >= 0
        return bool(a.linear * linear >= 0 and a.turn * turn >= 0)
    if verb in (codes.FORWARD, codes.BACKWARD):
        held = settings.hold_permille if verb == codes.FORWARD else 0
        return abs(a.turn) <= held and (a.linear > 0) == (verb == codes.FORWARD)
    held = a.read.get("mode") == codes.CONTINUOUS
    turning = verb in (codes.LEFT, codes.RIGHT) and a.linear == 0
    return turning and (not held or (a.turn > 0) == (verb == codes.LEFT))


def the_enable_line_needs_verified_writes(a: After) -> bool:
    """It toggles only in a tick whose writes were read back, armed or arming (P8)."""
    armed = a.core.safety.state != codes.DISARMED
    return not a.facts.toggled or (a.facts.verified and armed and not a.facts.raised)


def disarmed_is_whole(a: After) -> bool:
    """Disarmed: no owner, no enable line, no press under way. Armed or arming: one owner."""
    s = a.core.safety
    if s.state == codes.DISARMED:
        return s.owner == codes.NOBODY and not s.enable and s.edge == 0 and not s.permitted
    return s.owner in (codes.DRIVER, codes.CARETAKER) and s.enable


def some_causes_disarm(a: After) -> bool:
    """A grave fault, a long silence, a new session or an exception leaves nothing armed."""
    s = a.core.safety
    grave = s.faults & ~_WARNINGS & ~_ONLY_NEUTRAL
    lost = s._host_age_ms >= 498 or s._service_age_ms >= 498
    return s.state == codes.DISARMED or not (grave or lost or a.facts.raised)


def arming_needs_everything(a: After) -> bool:
    """Arming begins with a valid order, no fault, neutral proven, idle, the contact open."""
    s = a.core.safety
    if not (a.was["state"] != codes.ARMING and s.state == codes.ARMING):
        return True
    return (
        a.was["state"] == codes.DISARMED
        and a.facts.arms > 0
        and not (a.facts.disarm or a.facts.reset or a.facts.new_session)
        and a.read.get("arm_owner") == s.owner
        and s.faults == 0
        and s._session_count > 0
        and a.was["_neutral_ms"] >= 500
        and s._idle_ms >= 300
        and (not a.fitted or not a.facts.contact)
        and (a.simulated or a.read.get("clearance_source") == codes.REAL)
    )


def armed_needs_the_relay(a: After) -> bool:
    """Armed only from arming, without any fault, after the contact was proven; not yet a motion."""
    s = a.core.safety
    if not (a.was["state"] != codes.ARMED and s.state == codes.ARMED):
        return True
    proven = s._closed_ms >= 50 if a.fitted else s._arming_ms >= 50
    return a.was["state"] == codes.ARMING and s.faults == 0 and proven and not a.moving


def a_press_ends_for_good(a: After) -> bool:
    """A press that no longer moves is the spent one, or a newer one is."""
    s = a.core.safety
    old = a.was["edge"]
    if s.edge == old or old == 0:
        return True
    newer = s.spent_edge in (old, a.read.get("edge", old), a.read.get("stop_edge", old))
    return s.edge == a.read.get("edge") or newer or a.facts.new_session


def disarming_is_never_lost(a: After) -> bool:
    """Whatever else is ordered in the same tick (P13)."""
    disarmed = a.core.safety.state == codes.DISARMED
    return disarmed or not (a.facts.stepped and (a.facts.disarm or a.facts.new_session))


def a_take_over_is_never_lost(a: After) -> bool:
    """Armed or arming, whoever asked last owns the chair (P13)."""
    s = a.core.safety
    asked = a.facts.stepped and a.facts.arms > 0 and a.was["state"] != codes.DISARMED
    if not asked or a.facts.new_session or s.state == codes.DISARMED:
        return True
    return a.read.get("arm_owner") in (s.owner, codes.NOBODY, 3)


def a_drive_ends_with_what_would_end_it_in_motion(a: After) -> bool:
    """Held at rest or not, old data ends its press; after a lost heading it turns no more (P14)."""
    s = a.core.safety
    if not a.facts.stepped or a.read.get("verb") != codes.DRIVE or not s.permitted:
        return True
    went_on = a.was["edge"] == a.read.get("edge")
    heading = a.was["faults"] & _HEADING and went_on
    return not s.faults >> codes.OBSTACLE_DATA_OLD & 1 and not (heading and a.turn)


def latched_faults_stay(a: After) -> bool:
    """They clear by a reset only, and never when their cause comes in the same tick."""
    s = a.core.safety
    kept = a.reset or a.was["faults"] & _LATCHED & ~s.faults == 0
    emergency = a.facts.stepped and (a.facts.emergency_open or a.facts.message)
    return kept and (not emergency or s.faults >> codes.EMERGENCY & 1 == 1)


def faults_say_what_is(a: After) -> bool:
    """Each fault that does not latch is set exactly while its cause stands."""
    s = a.core.safety
    if not a.facts.stepped:
        return True
    old = a.was["faults"] >> codes.OBSTACLE_DATA_OLD & 1
    stale = s._clearance_age_ms >= (248 if old else 298)
    unreal = not a.simulated and a.read.get("clearance_source") != codes.REAL and not stale
    lost = s._heading_age_ms >= 48
    expected = (
        (s._host_age_ms >= 98) << codes.HOST_SILENT
        | (s._service_age_ms >= 48) << codes.SERVICE_STALLED
        | stale << codes.OBSTACLE_DATA_OLD
        | (a.read["heading_faults"] & _HEADING)
        | lost << codes.HEADING_BUS
        | (s._steady_ms < 500) << codes.TICK_STALLED
        | a.read["tilted"] << codes.TILT
        | (a.read["service_faults"] & ~_LATCHED)
        | (not a.read["calibrated"]) << codes.CALIBRATION
        | unreal << codes.SIMULATED_SOURCE
        | s._standing
    )
    return bool(s.faults & ~_LATCHED & ~_RELAY == expected)


def relay_faults_stand_until_the_contact_is_open(a: After) -> bool:
    """Set while disarmed, they clear after half a second of an open contact and no enable line."""
    s = a.core.safety
    if a.core.relay_follows and s.faults & _RELAY:
        return False  # what abstract.Core.read() relies on
    cleared = a.was["faults"] & _RELAY and not s.faults & _RELAY
    return not cleared or (s._open_ms >= 500 and s._off_ms >= 500)


def every_refusal_has_a_reason(a: After) -> bool:
    """What is asked and not done is explained, except the press of a step that ended as asked."""
    s = a.core.safety
    if not a.facts.stepped:
        return True
    asked = a.read.get("verb", codes.STOP) != codes.STOP and not s.permitted
    if asked and s.override == codes.NO_REASON and not s._quiet:
        return False
    if s._quiet and not a.was["_quiet"] and a.facts.end_reason != codes.NO_REASON:
        return False
    return bool(s.state != codes.DISARMED or s.faults == 0 or s.arm_reason != codes.NO_REASON)


def refused_arming_has_a_reason(a: After) -> bool:
    """Somebody who may arm and cannot is told why."""
    s = a.core.safety
    refused = (
        a.facts.stepped
        and a.facts.arms > 0
        and not (a.facts.disarm or a.reset or a.facts.new_session)
        and a.read.get("arm_owner") in (codes.DRIVER, codes.CARETAKER)
        and s.state == codes.DISARMED
    )
    return not refused or s.arm_reason != codes.NO_REASON


def the_first_reason_is_kept(a: After) -> bool:
    """A fault has a first reason, and it stays until all are gone, a reset, or arming."""
    s = a.core.safety
    if s.faults and s.first_fault == codes.NO_REASON:
        return False
    kept = s.first_fault == a.was["first_fault"]
    # The old ones cleared in this tick, and then its end failed.
    late = a.facts.raised or a.badly_written or a.facts.disobeys
    after_all = a.was["faults"] & s.faults == 0 and late
    begun = s.faults == 0 and s.state == codes.ARMING
    return kept or a.was["faults"] == 0 or a.reset or after_all or begun


def a_chair_that_disobeys_is_disarmed(a: After) -> bool:
    """In the very tick: neutral, enable line off, latched, with the reason (P21)."""
    if not a.facts.disobeys:
        return True
    s = a.core.safety
    off = s.state == codes.DISARMED and not s.enable and not a.facts.toggled
    return off and not a.moving and s.faults >> codes.DISOBEYS & 1 == 1 and s.first_fault != 0


def writes_that_often_fail_disarm(a: After) -> bool:
    """As three in a row do (P8)."""
    s = a.core.safety
    off = s.state == codes.DISARMED and not a.facts.toggled and s.faults >> codes.WIPER & 1 == 1
    return not a.facts.often or off


def no_contact_moves_where_none_is_fitted(a: After) -> bool:
    """Seen open and closed, 25 ms each: nothing is armed until it was reset, and why is said."""
    s = a.core.safety
    if a.fitted or not a.facts.stepped:
        return True
    moved = (a.was["_contact"] == 1 and s._closed_ms >= 25 and not a.reset) or (
        a.was["_contact"] == 2 and s._open_ms >= 25 and not a.reset
    )
    return not moved or (
        s.state == codes.DISARMED and s.faults >> codes.RELAY_UNEXPECTED & 1 == 1 and not a.moving
    )


INVARIANTS: tuple[Callable[[After], bool], ...] = (
    motion_only_when_armed,
    motion_only_while_all_live,
    motion_only_by_the_owner,
    motion_only_on_a_fresh_command,
    motion_only_where_it_is_free,
    turns_only_with_a_heading,
    motion_only_without_faults,
    motion_only_by_a_live_press,
    motion_goes_as_asked,
    the_enable_line_needs_verified_writes,
    disarmed_is_whole,
    some_causes_disarm,
    arming_needs_everything,
    armed_needs_the_relay,
    a_press_ends_for_good,
    disarming_is_never_lost,
    a_take_over_is_never_lost,
    a_drive_ends_with_what_would_end_it_in_motion,
    latched_faults_stay,
    faults_say_what_is,
    relay_faults_stand_until_the_contact_is_open,
    every_refusal_has_a_reason,
    refused_arming_has_a_reason,
    the_first_reason_is_kept,
    a_chair_that_disobeys_is_disarmed,
    writes_that_often_fail_disarm,
    no_contact_moves_where_none_is_fitted,
    *AUTO_INVARIANTS,
)
