"""States of safety and motion as tuples, every counter abstracted to the class it lies in.

A class is a range of values that the core must treat alike until time passes: before, at or after a
deadline. A class is represented by its lowest value; "time passed" is its highest.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise, product
from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING, Any

from gazeboard.core import ages, limits
from gazeboard.core.motion import Motion
from gazeboard.core.safety import Safety
from gazeboard.core.tick import Tick
from gazelink import codes
from gazeprove.around import Around
from gazeprove.either import Coin, Either
from gazeprove.inputs import Choices

STEP_MS = 2000  # of the settings explored
TURN_LIMIT_MS = 6000
AUTO_LIMIT_S = 10
SUPERVISION_MS = 3000
_TOP = limits.AGE_MAX_MS

# Where each counter lies among the words of Ages.
_WORDS = {
    "_host_age_ms": ages.HOST,
    "_service_age_ms": ages.SERVICE,
    "_clearance_age_ms": ages.CLEARANCE,
    "_heading_age_ms": ages.HEADING,
    "_neutral_ms": ages.NEUTRAL,
    "_idle_ms": ages.IDLE,
    "_arming_ms": ages.ARMING,
    "_closed_ms": ages.CLOSED,
    "_open_ms": ages.OPEN,
    "_off_ms": ages.OFF,
    "_steady_ms": ages.STEADY,
    "_button_ms": ages.BUTTON,
    "ttl_ms": ages.TTL,
    "_supervised_ms": ages.SUPERVISED,
    "_host_count": ages.HOST_COUNT,
    "_service_count": ages.SERVICE_COUNT,
    "_clearance_count": ages.CLEARANCE_COUNT,
    "_heading_count": ages.HEADING_COUNT,
    "_command_count": ages.COMMAND_COUNT,
    "_session_count": ages.SESSION_COUNT,
    "_disarm_count": ages.DISARM_COUNT,
    "_arm_count": ages.ARM_COUNT,
    "_reset_count": ages.RESET_COUNT,
    "_stop_count": ages.STOP_COUNT,
    "_emergency_count": ages.EMERGENCY_COUNT,
    "_press_count": ages.PRESS_COUNT,
    "_supervision_count": ages.SUPERVISION_COUNT,
    "_contact": ages.CONTACT,
    "_relay_fitted": ages.RELAY_FITTED,
    "_standing": ages.STANDING,
}


class Named(Safety):
    """The safety core, the words of its Ages as attributes, too."""

    def __init__(self, simulated: bool, relay_fitted: bool, boot_faults: int) -> None:
        super().__init__(simulated, relay_fitted, boot_faults)  # type: ignore[no-untyped-call]

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...
        def __setattr__(self, name: str, value: Any) -> None: ...

    def fields(self) -> dict[str, Any]:
        """What a state consists of, as it is now."""
        return dict(zip(FIELDS, self.values(), strict=True))

    def values(self) -> tuple[Any, ...]:
        """The same without the names."""
        return (*_plain_values(self), *_word_values(self._words))


def _word(at: int) -> property:
    return property(
        lambda safety: safety._words[at],
        lambda safety, value: safety._words.__setitem__(at, value),
    )


for _name, _at in _WORDS.items():
    setattr(Named, _name, _word(_at))

# First value of each class after the one at 0. A deadline is judged MARGIN_MS early.
_BOUNDS: dict[str, tuple[int, ...]] = {
    "_host_age_ms": (98, 498),
    "_service_age_ms": (48, 498),
    "_clearance_age_ms": (248, 298),
    "_heading_age_ms": (48,),
    "_neutral_ms": (500,),
    "_idle_ms": (300,),
    "_arming_ms": (50, 150),
    "_closed_ms": (1, 25, 50, 100),
    "_open_ms": (1, 25, 500),
    "_off_ms": (100, 500),
    "_steady_ms": (500,),
    "_button_ms": (3000, 3001),
    "ttl_ms": (1,),
    "_supervised_ms": (1,),
}
# Counters of which every value matters.
_EXACT = ("_wiper_bad",)
_PLAIN = (
    "state",
    "faults",
    "first_fault",
    "owner",
    "enable",
    "override",
    "edge",
    "spent_edge",
    "_verb",
    "_mode",
    "_quiet",
    "_straight",
    *_EXACT,
)
COUNTERS = tuple(_BOUNDS)
# The same, in the order in which it is chosen whether their time passes.
PASSING = (
    "_host_age_ms",
    "_service_age_ms",
    "_clearance_age_ms",
    "_heading_age_ms",
    "_arming_ms",
    "_closed_ms",
    "_open_ms",
    "_off_ms",
    "_steady_ms",
    "_button_ms",
    "ttl_ms",
    "_idle_ms",
    "_neutral_ms",
    "_supervised_ms",
)
_WORDS_TOO = (*COUNTERS, "_session_count", "_contact")
FIELDS = (*_PLAIN, *_WORDS_TOO)
_WORDS_AT = tuple(_WORDS[name] for name in _WORDS_TOO)
_COMPARED = tuple(at for name, at in _WORDS.items() if name.endswith("_count"))
MOTION_FIELDS = ("_edge", "_elapsed_ms", "state", "_drives_straight")
AUTO_FIELDS = ("left_ms", "overruled_ms")
# What the core overwrites in every tick before it reads it; with the counters of the inputs, which
# it only compares.
FORGOTTEN: dict[str, Any] = {
    "permitted": False,
    "arm_reason": codes.NO_REASON,
    "blocked": 15,
    "missed_ms": 0,
}

State = tuple[Any, ...]
_AT = {name: k for k, name in enumerate(FIELDS)}
_AUTO_AT = len(FIELDS) + len(MOTION_FIELDS)
_plain_values = attrgetter(*_PLAIN)
_word_values = itemgetter(*_WORDS_AT)
_motion_values = attrgetter(*MOTION_FIELDS)
_auto_values = attrgetter(*AUTO_FIELDS)


def _classes(bounds: tuple[int, ...], top: int) -> tuple[list[int], dict[int, int]]:
    """Lowest value of the class of each value; highest value of the class with a lowest value."""
    starts = (0, *bounds, top + 1)
    lowest: list[int] = []
    highest: dict[int, int] = {}
    for low, following in pairwise(starts):
        lowest += [low] * (following - low)
        highest[low] = following - 1
    return lowest, highest


_TOPS = {"ttl_ms": limits.COMMAND_TTL_MS, "_supervised_ms": SUPERVISION_MS}
_LOWEST = {}
HIGHEST = {}
for _name, _limits in _BOUNDS.items():
    _LOWEST[_name], HIGHEST[_name] = _classes(_limits, _TOPS.get(_name, _TOP))
_ELAPSED = {
    codes.FORWARD: _classes((STEP_MS, STEP_MS + 1), _TOP),
    codes.LEFT: _classes((TURN_LIMIT_MS, TURN_LIMIT_MS + 1), _TOP),
}
_ELAPSED[codes.BACKWARD] = _ELAPSED[codes.FORWARD]
_ELAPSED[codes.RIGHT] = _ELAPSED[codes.LEFT]
# Of an auto motion: what is left of its time, and how long it has been overruled.
_AUTO = {
    "left_ms": _classes((1,), 1000 * AUTO_LIMIT_S),
    "overruled_ms": _classes((1, limits.AUTO_OVERRULED_MS), _TOP),
}
_OFF, _OPEN = _AT["_off_ms"], _AT["_open_ms"]
_TABLES = tuple((_AT[name], _LOWEST[name]) for name in COUNTERS)

# Press numbers, in the order in which they were pressed: older than all known, the spent one, the
# running one, a newer one. 0 is none.
OLD, SPENT, RUNNING, FRESH = 255, 1, 2, 3
_SOME_REASON = codes.NOT_ARMED


@dataclass
class Loaded:
    """What is the same in every tick from a state; some counters may pass, see Core.load()."""

    attributes: dict[str, Any]
    words: list[Any]
    motion: tuple[Any, ...]
    auto: tuple[Any, ...]
    was: dict[str, Any]  # fields of safety
    coins: tuple[Coin, ...]
    places: tuple[int, ...]  # of the counters in a state


@dataclass
class Core:
    """The real safety and motion objects, loaded with one state after another."""

    safety: Named
    motion: Motion
    around: Around
    relay_follows: bool  # the contact always does what the enable line says
    choices: Choices
    tick: Tick = field(init=False)
    state: State = ()  # from which it ticks
    passable: tuple[tuple[int, str], ...] = ()  # counters, with their places in PASSING
    auto_passable: tuple[str, ...] = ()
    step_can_pass: bool = False
    _known: dict[tuple[Any, ...], State] = field(default_factory=dict)  # what was abstracted
    _loaded: dict[tuple[str, ...], Loaded] = field(default_factory=dict)  # from one state
    _coins: list[Coin] = field(default_factory=list)  # of this tick
    _places: list[int] = field(default_factory=list)  # of the counters that they decide in a state

    def __post_init__(self) -> None:
        self.tick = self.around.tick(self.safety, self.motion)

    def begin(self, state: State) -> None:
        """All ticks from now on are from `state`."""
        safety = self.safety
        if type(safety._words) is not list:  # but machine words: none of them can be Either
            safety._words = safety.ages.words = safety.auto._words = [*safety._words]
        self.state = state
        self.passable = tuple((at, name) for at, name in enumerate(PASSING) if can_pass(state, name))
        self.auto_passable = auto_passable(state)
        self.step_can_pass = step_can_pass(state)
        self._loaded.clear()

    def load(self, passing: tuple[str, ...], elapsed: bool) -> dict[str, Any]:
        """Become the state, each counter of `passing` at either end of its class.

        `elapsed`: a step has taken all the time of its class. Returns safety's fields.
        """
        now = self._loaded.get(passing)
        if now is None:
            now = self._loaded[passing] = self._prepared(passing)
        self._coins = [*now.coins]
        self._places = [*now.places]
        for coin in now.coins:
            coin.side = -1
        safety, motion = self.safety, self.motion
        safety.__dict__.update(now.attributes)
        safety._words[:] = now.words
        motion.stop()
        motion._edge, motion._elapsed_ms, motion.state, motion._drives_straight = now.motion
        safety.auto.left_ms, safety.auto.overruled_ms = now.auto
        if elapsed:
            motion._elapsed_ms = _ELAPSED[safety._verb][1][motion._elapsed_ms]
        return now.was

    def _prepared(self, passing: tuple[str, ...]) -> Loaded:
        state = self.state
        words = self.safety._words[:]
        for at in _COMPARED:
            words[at] = 0
        for at, value in zip(_WORDS_AT, state[len(_PLAIN) :], strict=False):
            words[at] = value
        if get(state, "state") != codes.DISARMED:
            # Not known: if this tick does not set them back to 0, they may be anything.
            words[ages.IDLE] = words[ages.NEUTRAL] = 1
        auto = dict(zip(AUTO_FIELDS, state[_AUTO_AT:], strict=True))
        coins = [Coin(self.choices) for _ in passing]
        places = []
        for name, coin in zip(passing, coins, strict=True):
            if name in _AUTO:
                auto[name] = Either(coin, auto[name], _AUTO[name][1][auto[name]])
                places.append(_AUTO_AT + AUTO_FIELDS.index(name))
            else:
                at = _WORDS[name]
                words[at] = Either(coin, words[at], HIGHEST[name][state[_AT[name]]])
                places.append(_AT[name])
        plain = dict(zip(_PLAIN, state, strict=False))
        was = {**plain, **{name: words[_WORDS[name]] for name in _WORDS_TOO}}
        return Loaded(
            {**plain, **FORGOTTEN},
            words,
            state[len(FIELDS) : _AUTO_AT],
            tuple(auto.values()),
            was,
            tuple(coins),
            tuple(places),
        )

    def may_be(self, name: str, number: int) -> None:
        """If a counter is not 0, it may as well be this."""
        safety = self.safety
        now = getattr(safety, name)
        if type(now) is Either:
            if now and self.choices.pick(2):
                setattr(safety, name, number)
        elif now:
            coin = Coin(self.choices)
            self._coins.append(coin)
            self._places.append(_AT[name])
            setattr(safety, name, Either(coin, now, number))

    def together(self) -> int:
        """How many ticks the last one was: one for each side of each coin that nobody tossed."""
        return 1 << sum([coin.side < 0 for coin in self._coins])

    def toss(self) -> None:
        """Choose what is not chosen yet."""
        for coin in self._coins:
            coin.toss()

    def seen(self) -> tuple[Any, ...]:
        """What the objects are now: a number, or the two between which nobody has chosen."""
        safety = self.safety
        found = [
            *_plain_values(safety),
            *_word_values(safety._words),
            *_motion_values(self.motion),
            *_auto_values(safety.auto),
        ]
        for at in self._places:
            if type(found[at]) is Either:
                found[at] = found[at].seen()
        return tuple(found)

    def read(self) -> State:
        """The abstraction of what the objects are now, when all is chosen."""
        (state,) = self.states(self.seen())
        return state

    def states(self, seen: tuple[Any, ...]) -> list[State]:
        """The abstractions of all that what was seen may be."""
        numbers = (value if type(value) is tuple else (value,) for value in seen)
        return [self._abstracted(*values) for values in product(*numbers)]

    def _abstracted(self, *seen: Any) -> State:
        found = self._known.get(seen)
        if found is not None:
            return found
        values, motion = list(seen[: len(FIELDS)]), list(seen[len(FIELDS) :])
        for k, table in _TABLES:
            values[k] = table[values[k]]
        if self.relay_follows:
            # Then a relay fault never comes, and how long the contact has been open is no matter.
            values[_OFF] = 0
            values[_OPEN] = min(1, values[_OPEN])
        if self.safety._relay_fitted and values[_AT["state"]] == codes.ARMED:
            values[_AT["_closed_ms"]] = min(1, values[_AT["_closed_ms"]])
        found = self._known[seen] = _renamed(values, motion)
        return found


def _renamed(values: list[Any], motion: list[Any]) -> State:
    running, spent = values[_AT["edge"]], values[_AT["spent_edge"]]
    values[_AT["spent_edge"]] = SPENT if spent else 0
    if running:
        values[_AT["edge"]] = SPENT if running == spent else RUNNING
    else:
        # Of a press that has ended nothing is kept but its number.
        values[_AT["_verb"]] = codes.STOP
        values[_AT["_mode"]] = codes.STEP
    if not running or values[_AT["_verb"]] != codes.DRIVE:
        values[_AT["_straight"]] = False  # only a drive that goes on reads it
        motion[3] = False  # nor this
    for at, name in enumerate(AUTO_FIELDS, len(MOTION_FIELDS)):
        # Only an auto motion that goes on reads them.
        on = running and values[_AT["_mode"]] == codes.AUTO
        motion[at] = _AUTO[name][0][motion[at]] if on else 0
    if motion[0] and motion[0] == running:
        motion[0] = values[_AT["edge"]]
    elif motion[0]:
        motion[0] = SPENT if motion[0] == spent else FRESH
    verb, mode = values[_AT["_verb"]], values[_AT["_mode"]]
    stepping = motion[0] and mode == codes.STEP and verb in _ELAPSED
    motion[1] = _ELAPSED[verb][0][motion[1]] if stepping else 0
    # While not disarmed nobody reads these: unknown until then (see events.tick).
    if values[_AT["state"]] != codes.DISARMED:
        values[_AT["_idle_ms"]] = values[_AT["_neutral_ms"]] = 0
    if values[_AT["state"]] != codes.ARMING:
        values[_AT["_arming_ms"]] = 0
    values[_AT["_session_count"]] = min(1, values[_AT["_session_count"]])
    for name in ("override", "first_fault"):
        if values[_AT[name]]:
            values[_AT[name]] = _SOME_REASON
    return (*values, *motion)


def get(state: State, name: str) -> Any:
    """A field of safety in an abstract state."""
    return state[_AT[name]]


def can_pass(state: State, name: str) -> bool:
    """Whether a counter is not at the end of its class yet."""
    low = state[_AT[name]]
    return HIGHEST[name][low] not in (low, _TOP)


def auto_passable(state: State) -> tuple[str, ...]:
    """The numbers of an auto motion that are not at the end of their class yet."""
    values = zip(AUTO_FIELDS, state[_AUTO_AT:], strict=True)
    return tuple(name for name, low in values if _AUTO[name][1][low] not in (low, _TOP))


def step_can_pass(state: State) -> bool:
    """The same of the time a step has taken."""
    table = _ELAPSED.get(state[_AT["_verb"]])
    if table is None or not state[len(FIELDS)] or state[_AT["_mode"]] != codes.STEP:
        return False
    low = state[len(FIELDS) + 1]
    return table[1][low] not in (low, _TOP)
