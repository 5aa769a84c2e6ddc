"""Every event of one tick: chosen when the core looks, so that what it skips costs nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gazeboard import limits
from gazeboard.safety import Safety
from gazelink import codes
from gazeprove import abstract
from gazeprove.abstract import FRESH, Core, State

# What can go wrong, one by one. The others stay well in a scope that does not name them.
CAUSES = (
    "host",
    "service",
    "lidar",
    "source",
    "imu",
    "heading",
    "tilt",
    "calibration",
    "late",
    "emergency",
    "button",
    "relay",
    "wiper",
    "exception",
    "stop",
    "session",
)
_FEW_VERBS = (codes.STOP, codes.FORWARD, codes.LEFT)
_ALL_VERBS = (*range(len(codes.VERBS)), len(codes.VERBS))  # and one that does not exist


@dataclass(frozen=True)
class Scope:
    """One exploration: which causes may strike, in any combination, at any time."""

    name: str
    causes: frozenset[str] = frozenset()
    all_commands: bool = False
    relay_fitted: bool = True
    simulated: bool = False
    boot_faults: int = 0


class Choices:
    """Walks a tree of choices leaf by leaf: pick() answers, following() goes to the next leaf."""

    def __init__(self) -> None:
        self._path: list[int] = []
        self._sizes: list[int] = []
        self._at = 0

    def pick(self, size: int) -> int:
        """A number below `size`."""
        at = self._at
        self._at = at + 1
        if at < len(self._path):
            return self._path[at]
        self._path.append(0)
        self._sizes.append(size)
        return 0

    def following(self) -> bool:
        """Prepare the next leaf. False when all were visited; then it begins anew."""
        path, sizes = self._path, self._sizes
        while path and path[-1] + 1 == sizes[-1]:
            path.pop()
            sizes.pop()
        self._at = 0
        if not path:
            return False
        path[-1] += 1
        return True


class Blocked:
    """Blocked bits, each chosen when the core asks for it."""

    def __init__(self, choices: Choices) -> None:
        self._choices = choices
        self.known: dict[int, int] = {}

    def __and__(self, mask: int) -> Any:
        if mask == 15:
            return self
        if mask not in self.known:
            self.known[mask] = mask * self._choices.pick(2)
        return self.known[mask]


class LazyInputs:
    """An Inputs whose fields are chosen when they are read. `__dict__` holds what was read."""

    _scope: Scope
    _choices: Choices
    _presses: tuple[int, ...]

    def __getattr__(self, name: str) -> Any:
        values = self._values(name)
        value = values[self._choices.pick(len(values))] if len(values) > 1 else values[0]
        self.__dict__[name] = value
        return value

    def _values(self, name: str) -> tuple[Any, ...]:
        causes, full = self._scope.causes, self._scope.all_commands
        if name == "verb":
            return _ALL_VERBS if full else _FEW_VERBS
        if name == "mode":
            if not full:
                return (codes.CONTINUOUS if self.verb == codes.FORWARD else codes.STEP,)
            return (codes.STEP, codes.CONTINUOUS)
        if name == "edge":
            return self._presses
        if name == "owner":
            return (codes.NOBODY, codes.DRIVER, codes.CARETAKER) if full else (codes.DRIVER,)
        if name in ("linear_permille", "turn_permille"):
            return (-1000, 0, 1000)
        if name == "clearance_blocked":
            return (Blocked(self._choices),)
        if name == "clearance_source":
            return (codes.REAL, codes.SIMULATED) if "source" in causes else (codes.REAL,)
        if name == "clearance_age_ms":
            return (0, 247, 248, 297, 298) if "lidar" in causes else (0,)
        if name == "heading_faults":
            return (0, 1 << codes.HEADING_FROZEN) if "heading" in causes else (0,)
        if name == "tilted":
            return (False, True) if "tilt" in causes else (False,)
        if name == "calibrated":
            return (True, False) if "calibration" in causes else (True,)
        if name == "order_action":
            few = (codes.ARM, codes.DISARM, codes.RESET_FAULTS)
            return (*few, codes.EMERGENCY_STOP) if full else few
        if name == "order_owner":
            if not full:
                return (codes.DRIVER if self.order_action == codes.ARM else codes.CARETAKER,)
            return (codes.NOBODY, codes.DRIVER, codes.CARETAKER, 3)
        if name == "ttl_ms":
            return (0, 300)
        if name in ("heading_q4", "rate_q4"):
            return (0,)
        raise AttributeError(name)


class AnyTurn:
    """A turn controller that answers anything at all."""

    def __init__(self, choices: Choices) -> None:
        self._choices = choices
        self.arrived = False

    def start(self, setpoint_q4: int) -> None:
        """Where to does not matter here."""

    def update(self, heading_q4: int, rate_q4: int) -> int:
        """Arrived, or far too much either way, or nothing."""
        answer = self._choices.pick(4)
        self.arrived = answer == 3
        return (0, 9999, -9999, 0)[answer]


@dataclass
class Facts:
    """What happened in one tick besides the inputs, for the invariants."""

    contact: bool
    emergency_open: bool
    message: bool
    button: bool
    late: bool
    ordered: bool
    stopped: bool
    new_session: bool
    verified: bool = True
    raised: bool = False
    stepped: bool = True
    toggled: bool = False
    well: bool = True
    end_reason: int | None = None


def tick(
    core: Core,
    state: State,
    scope: Scope,
    inputs: LazyInputs,
    choices: Choices,
    was: dict[str, Any],
) -> Facts:
    """One tick of the real objects from `state`, in the order of App._tick, all events chosen.

    `was` is filled with safety's fields before the tick, after the time that was chosen to pass.
    """
    causes = scope.causes
    pick = choices.pick
    enable, before = abstract.get(state, "enable"), abstract.get(state, "state")

    def strikes(cause: str) -> bool:
        return cause in causes and pick(2) == 1

    mute = strikes("host")
    stalled = strikes("service")
    blind = strikes("lidar")
    lost = strikes("imu")
    facts = Facts(
        contact=enable != strikes("relay"),
        emergency_open=strikes("emergency"),
        message="emergency" in causes and pick(2) == 1,
        button=strikes("button"),
        late=strikes("late"),
        ordered=pick(2) == 1,
        stopped=strikes("stop"),
        new_session=strikes("session") or abstract.get(state, "_session_count") == 0,
    )
    commanded = pick(2) == 1
    passing = {
        "_host_age_ms": mute,
        "_service_age_ms": stalled,
        "_clearance_age_ms": blind,
        "_heading_age_ms": lost,
        "_arming_ms": before == codes.ARMING,
        "_closed_ms": facts.contact and before != codes.ARMED,
        "_open_ms": not facts.contact and not core.relay_follows,
        "_off_ms": not enable and not core.relay_follows,
        "_steady_ms": not facts.late,
        "_button_ms": facts.button,
        "ttl_ms": not commanded,
        "_idle_ms": before == codes.DISARMED or facts.new_session,
        "_neutral_ms": before == codes.DISARMED or facts.new_session,
    }
    passed = [n for n, may in passing.items() if may and abstract.can_pass(state, n) and pick(2)]
    if abstract.step_can_pass(state) and pick(2):
        passed.append("_elapsed_ms")
    core.load(state, tuple(passed))
    was.update(core.safety.__dict__)
    running, spent = core.safety.edge, core.safety.spent_edge
    read = inputs.__dict__
    read.clear()
    read.update(
        _scope=scope,
        _choices=choices,
        _presses=tuple({0: 0, running: running, spent: spent, FRESH: FRESH}),
        host_count=0 if mute else 1,
        service_count=0 if stalled else 1,
        clearance_count=0 if blind else 1,
        heading_count=0 if lost else 1,
        command_count=1 if commanded else 0,
        session_count=core.safety._session_count + (1 if facts.new_session else 0),
        stop_count=1 if facts.stopped else 0,
        emergency_count=1 if facts.message else 0,
        order_number=1 if facts.ordered else 0,
    )
    raised = pick(3) if "exception" in causes else 0
    facts.raised = raised > 0
    facts.stepped = raised < 2
    if facts.stepped:
        decide(core, inputs, facts)
    if facts.raised:
        core.safety.tick_raised()
        core.motion.stop()
    else:
        facts.verified = not strikes("wiper")
        neutral = core.motion.linear_permille == core.motion.turn_permille == 0
        facts.toggled = core.safety.wipers_written(facts.verified, neutral)
    if before != codes.DISARMED and core.safety.state == codes.DISARMED:
        _reveal(core.safety, before, choices)
    facts.well = not (
        mute or stalled or blind or lost or facts.raised or facts.late or facts.emergency_open
    ) and (facts.verified and not facts.message and facts.contact == enable and _all_well(read))
    return facts


def _reveal(safety: Safety, before: int, choices: Choices) -> None:
    """Counters that do not matter until disarmed may have come any way by then."""
    if safety._idle_ms and choices.pick(2):
        safety._idle_ms = limits.IDLE_MS
    if safety._neutral_ms and choices.pick(2):
        safety._neutral_ms = limits.NEUTRAL_PROVEN_MS
    if safety._closed_ms and before == codes.ARMED:
        safety._closed_ms = (1, limits.RELAY_HOLD_MS, limits.RELAY_STUCK_MS)[choices.pick(3)]


def decide(core: Core, inputs: Any, facts: Facts) -> None:
    """Safety, then motion, as App._tick calls them."""
    safety, motion = core.safety, core.motion
    safety.step(inputs, facts.contact, facts.emergency_open, facts.button, facts.late)
    if not safety.permitted:
        motion.stop()
        return
    motion.step(inputs, safety.blocked)
    if motion.ended:
        facts.end_reason = motion.end_reason
        safety.finished(motion.end_reason)


def _all_well(read: dict[str, Any]) -> bool:
    blocked = read.get("clearance_blocked")
    return (
        not read.get("tilted", False)
        and read.get("calibrated", True)
        and not read.get("heading_faults", 0)
        and read.get("clearance_source", codes.REAL) == codes.REAL
        and (blocked is None or not any(blocked.known.values()))
    )


def first_state(scope: Scope) -> tuple[Core, LazyInputs, Choices, State]:
    """The objects as they are built at boot, and the abstraction of that."""
    from gazeboard.motion import Motion
    from gazeboard.settings import Settings

    settings: Any = Settings()
    settings.step_forward_ms = abstract.STEP_MS
    settings.step_turn_limit_ms = abstract.TURN_LIMIT_MS
    choices = Choices()
    core = Core(
        Safety(scope.simulated, scope.relay_fitted, scope.boot_faults),
        Motion(settings, AnyTurn(choices)),
        "relay" not in scope.causes,
    )
    return core, LazyInputs(), choices, core.read()
