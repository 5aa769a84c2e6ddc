"""States of safety and motion as tuples, every counter abstracted to the class it lies in.

A class is a range of values that the core must treat alike until time passes: before, at or after a
deadline. A class is represented by its lowest value; "time passed" is its highest.
"""

from __future__ import annotations

from itertools import pairwise
from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING, Any

from gazeboard.core import ages, limits
from gazeboard.core.safety import Safety
from gazelink import codes

STEP_MS = 2000  # of the settings explored
TURN_LIMIT_MS = 6000
AUTO_LIMIT_S = 10
SUPERVISION_MS = 3000
_TOP = limits.AGE_MAX_MS

# Where each counter lies among the words of Ages.
WORDS = {
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


for _name, _at in WORDS.items():
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
PLAIN = (
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
WORDS_TOO = (*COUNTERS, "_session_count", "_contact")
FIELDS = (*PLAIN, *WORDS_TOO)
WORDS_AT = tuple(WORDS[name] for name in WORDS_TOO)
COMPARED = tuple(at for name, at in WORDS.items() if name.endswith("_count"))
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
AT = {name: k for k, name in enumerate(FIELDS)}
AUTO_AT = len(FIELDS) + len(MOTION_FIELDS)
_plain_values = attrgetter(*PLAIN)
_word_values = itemgetter(*WORDS_AT)
motion_values = attrgetter(*MOTION_FIELDS)
auto_values = attrgetter(*AUTO_FIELDS)


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
ELAPSED = {
    codes.FORWARD: _classes((STEP_MS, STEP_MS + 1), _TOP),
    codes.LEFT: _classes((TURN_LIMIT_MS, TURN_LIMIT_MS + 1), _TOP),
}
ELAPSED[codes.BACKWARD] = ELAPSED[codes.FORWARD]
ELAPSED[codes.RIGHT] = ELAPSED[codes.LEFT]
# Of an auto motion: what is left of its time, and how long it has been overruled.
AUTO = {
    "left_ms": _classes((1,), 1000 * AUTO_LIMIT_S),
    "overruled_ms": _classes((1, limits.AUTO_OVERRULED_MS), _TOP),
}
_OFF, _OPEN = AT["_off_ms"], AT["_open_ms"]
_TABLES = tuple((AT[name], _LOWEST[name]) for name in COUNTERS)

# Press numbers, in the order in which they were pressed: older than all known, the spent one, the
# running one, a newer one. 0 is none.
OLD, SPENT, RUNNING, FRESH = 255, 1, 2, 3
_SOME_REASON = codes.NOT_ARMED


def abstracted(seen: tuple[Any, ...], relay_follows: bool, relay_fitted: bool) -> State:
    """The abstraction of a state whose counters are as they are."""
    values, motion = list(seen[: len(FIELDS)]), list(seen[len(FIELDS) :])
    for k, table in _TABLES:
        values[k] = table[values[k]]
    if relay_follows:
        # Then a relay fault never comes, and how long the contact has been open is no matter.
        values[_OFF] = 0
        values[_OPEN] = min(1, values[_OPEN])
    if relay_fitted and values[AT["state"]] == codes.ARMED:
        values[AT["_closed_ms"]] = min(1, values[AT["_closed_ms"]])
    return _renamed(values, motion)


def _renamed(values: list[Any], motion: list[Any]) -> State:
    running, spent = values[AT["edge"]], values[AT["spent_edge"]]
    values[AT["spent_edge"]] = SPENT if spent else 0
    if running:
        values[AT["edge"]] = SPENT if running == spent else RUNNING
    else:
        # Of a press that has ended nothing is kept but its number.
        values[AT["_verb"]] = codes.STOP
        values[AT["_mode"]] = codes.STEP
    if not running or values[AT["_verb"]] != codes.DRIVE:
        values[AT["_straight"]] = False  # only a drive that goes on reads it
        motion[3] = False  # nor this
    for at, name in enumerate(AUTO_FIELDS, len(MOTION_FIELDS)):
        # Only an auto motion that goes on reads them.
        on = running and values[AT["_mode"]] == codes.AUTO
        motion[at] = AUTO[name][0][motion[at]] if on else 0
    if motion[0] and motion[0] == running:
        motion[0] = values[AT["edge"]]
    elif motion[0]:
        motion[0] = SPENT if motion[0] == spent else FRESH
    verb, mode = values[AT["_verb"]], values[AT["_mode"]]
    stepping = motion[0] and mode == codes.STEP and verb in ELAPSED
    motion[1] = ELAPSED[verb][0][motion[1]] if stepping else 0
    # While not disarmed nobody reads these: unknown until then (see events.tick).
    if values[AT["state"]] != codes.DISARMED:
        values[AT["_idle_ms"]] = values[AT["_neutral_ms"]] = 0
    if values[AT["state"]] != codes.ARMING:
        values[AT["_arming_ms"]] = 0
    values[AT["_session_count"]] = min(1, values[AT["_session_count"]])
    for name in ("override", "first_fault"):
        if values[AT[name]]:
            values[AT[name]] = _SOME_REASON
    return (*values, *motion)


def get(state: State, name: str) -> Any:
    """A field of safety in an abstract state."""
    return state[AT[name]]


def can_pass(state: State, name: str) -> bool:
    """Whether a counter is not at the end of its class yet."""
    low = state[AT[name]]
    return HIGHEST[name][low] not in (low, _TOP)


def auto_passable(state: State) -> tuple[str, ...]:
    """The numbers of an auto motion that are not at the end of their class yet."""
    values = zip(AUTO_FIELDS, state[AUTO_AT:], strict=True)
    return tuple(name for name, low in values if AUTO[name][1][low] not in (low, _TOP))


def step_can_pass(state: State) -> bool:
    """The same of the time a step has taken."""
    table = ELAPSED.get(state[AT["_verb"]])
    if table is None or not state[len(FIELDS)] or state[AT["_mode"]] != codes.STEP:
        return False
    low = state[len(FIELDS) + 1]
    return table[1][low] not in (low, _TOP)
