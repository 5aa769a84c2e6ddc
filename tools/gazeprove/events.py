"""One tick of the real core from any state, every event of it chosen."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gazeboard.core import limits
from gazeboard.core.tick import PERIOD_US
from gazelink import codes
from gazeprove import abstract
from gazeprove.abstract import FRESH, OLD, State
from gazeprove.around import Around, Facts, Raised
from gazeprove.core import Core
from gazeprove.inputs import AnyTurn, Choices, LazyInputs, Scope


def begin(core: Core, state: State, scope: Scope, inputs: LazyInputs) -> None:
    """All ticks from now on are from `state`."""
    core.begin(state)
    presses = (0, abstract.get(state, "edge"), abstract.get(state, "spent_edge"), FRESH)
    inputs.presses = tuple(dict.fromkeys((*presses, OLD) if scope.all_commands else presses))


def tick(
    core: Core, scope: Scope, inputs: LazyInputs, choices: Choices
) -> tuple[Facts, dict[str, Any]]:
    """One tick of the real objects from the state that they began with, all events chosen.

    Returns what happened, and safety's fields before the tick, time passed included.
    """
    causes = scope.causes
    pick = choices.pick
    state = core.state
    enable, before = abstract.get(state, "enable"), abstract.get(state, "state")

    def strikes(cause: str) -> bool:
        return cause in causes and pick(2) == 1

    mute = strikes("host")
    stalled = strikes("service")
    blind = strikes("lidar")
    lost = strikes("imu")
    disarm, arms, reset = _orders(scope, pick)
    facts = Facts(
        contact=(enable and scope.relay_fitted) != strikes("relay"),
        emergency_open=strikes("emergency"),
        message="emergency" in causes and pick(2) == 1,
        button=strikes("button"),
        late=strikes("late"),
        disarm=disarm,
        arms=arms,
        reset=reset,
        stopped=strikes("stop"),
        new_session=strikes("session") or abstract.get(state, "_session_count") == 0,
    )
    auto = "auto" in causes and before == codes.ARMED  # before that, it is nothing
    facts.presses = pick(3) if auto else 0
    watched = auto and pick(2) == 1
    commanded = pick(2) == 1
    settled = before == codes.DISARMED or facts.new_session
    passing = (  # in the order of PASSING
        mute,
        stalled,
        blind,
        lost,
        before == codes.ARMING,
        facts.contact and (before != codes.ARMED or not scope.relay_fitted),
        not facts.contact and not core.relay_follows,
        not enable and not core.relay_follows,
        not facts.late,
        facts.button,
        not commanded,
        settled,
        settled,
        not watched,
    )
    open_ended = [name for at, name in core.passable if passing[at]]
    elapsed = core.step_can_pass and pick(2) == 1
    was = core.load((*open_ended, *core.auto_passable), elapsed)
    i = inputs
    read: dict[str, Any] = {}
    i.read = read
    i.host_count = 0 if mute else 1
    i.service_count = 0 if stalled else 1
    i.clearance_count = 0 if blind else 1
    i.heading_count = 0 if lost else 1
    i.command_count = 1 if commanded else 0
    i.session_count = core.safety._session_count + (1 if facts.new_session else 0)
    i.stop_count = 1 if facts.stopped else 0
    i.emergency_count = 1 if facts.message else 0
    i.disarm_count = 1 if disarm else 0
    i.arm_count = arms
    i.reset_count = 1 if reset else 0
    i.press_count = facts.presses
    i.supervision_count = 1 if watched else 0
    raised = pick(3) if "exception" in causes else 0
    facts.raised = raised > 0
    facts.stepped = raised < 2
    run(core, inputs, facts, strikes)
    if before != codes.DISARMED and core.safety.state == codes.DISARMED:
        _reveal(core, before)
    facts.well = not (
        mute or stalled or blind or lost or facts.raised or facts.late or facts.emergency_open
    )
    facts.well &= not (facts.message or facts.disobeys or facts.often) and facts.verified
    facts.well &= facts.contact == (enable and scope.relay_fitted) and _all_well(read)
    return facts, was


def run(core: Core, inputs: Any, facts: Facts, strikes: Callable[[str], bool]) -> None:
    """The tick itself. `strikes` tells what happens after the decision; `facts` are completed."""
    core.around.facts = facts
    core.around.strikes = strikes
    tick = core.tick
    try:
        if not facts.stepped:
            raise Raised
        tick.decide(inputs, PERIOD_US, facts.contact, facts.emergency_open, facts.button)
        facts.verified = not strikes("wiper")
        tick.enable_level = 0
        neutral = core.motion.linear_permille == core.motion.turn_permille == 0
        facts.toggled = tick.written(facts.verified, neutral) == 1
    except Raised:
        tick.raised()


def _orders(scope: Scope, pick: Callable[[int], int]) -> tuple[bool, int, bool]:
    """Which orders come: any together where all commands do, else at most one."""
    if scope.all_commands:
        return pick(2) == 1, pick(3), pick(2) == 1
    one = pick(4)
    return one == 1, int(one == 2), one == 3


def _reveal(core: Core, before: int) -> None:
    """Counters that do not matter until disarmed may have come any way by then."""
    safety = core.safety
    core.may_be("_idle_ms", limits.IDLE_MS)
    core.may_be("_neutral_ms", limits.NEUTRAL_PROVEN_MS)
    if safety._closed_ms and before == codes.ARMED and safety._relay_fitted:
        safety._closed_ms = (1, limits.RELAY_HOLD_MS)[core.choices.pick(2)]
        more_ms = limits.RELAY_RELEASE_MS if safety._closed_ms == 1 else limits.RELAY_STUCK_MS
        core.may_be("_closed_ms", more_ms)


def _all_well(read: dict[str, Any]) -> bool:
    for name in ("clearance_blocked", "clearance_unseen"):
        if name in read and any(read[name].known.values()):
            return False
    return (
        not read.get("tilted", False)
        and not read.get("service_faults", 0)
        and read.get("calibrated", True)
        and not read.get("heading_faults", 0)
        and read.get("clearance_source", codes.REAL) == codes.REAL
    )


def first_state(scope: Scope) -> tuple[Core, LazyInputs, Choices, State]:
    """The objects as they are built at boot, and the abstraction of that."""
    from gazeboard.core.motion import Motion
    from gazeboard.io.settings import Settings

    settings: Any = Settings()
    settings.step_forward_ms = abstract.STEP_MS
    settings.step_turn_limit_ms = abstract.TURN_LIMIT_MS
    choices = Choices()
    settings.auto_limit_s = abstract.AUTO_LIMIT_S
    settings.supervision_ms = abstract.SUPERVISION_MS
    safety = abstract.Named(scope.simulated, scope.relay_fitted, scope.boot_faults)
    safety.auto.configure(settings)
    core = Core(
        safety,
        Motion(settings, AnyTurn(choices)),
        Around(),
        "relay" not in scope.causes and scope.relay_fitted,
        choices,
    )
    return core, LazyInputs(scope, choices), choices, core.read()
