"""The trace of a board in a log: all inputs of its ticks, and their decisions.

A message is written when something in it differs from the tick before; `tick` counts the ticks of
one run of the board, from 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gazeboard.core.shared import Inputs
from gazechair.blackbox import ros
from gazelink import arcs
from gazereplay.result import NoTrace

START = "/trace/start"
SETTINGS = "/trace/settings"
INPUTS = "/trace/inputs"
DECISION = "/trace/decision"
ENDED = "/trace/ended"

# Of the tick itself: time since the tick before, contacts, and whether the wipers read back as
# written.
AROUND = ("elapsed_us", "relay_closed", "emergency_open", "button_pressed", "verified", "neutral")
# Inputs that were added to the core later, each with the value that changes no decision: older
# drives, which lack them, are replayed with it.
NEUTRAL: dict[str, int] = {}
# Changes in each tick while the service loop lives: stored as whether it changed.
ALIVE = "service_count"
TAKEN = tuple(name for name in Inputs.FIELDS if name != ALIVE)
DECIDED = (
    "state",
    "motion",
    "override",
    "arm_reason",
    "first_fault",
    "faults",
    "edge",
    "decisions",
    "linear_permille",
    "turn_permille",
    "toggled",
)

_NUMBERS = "\n".join(f"int32 {name}" for name in (*AROUND, *TAKEN))
DEFINITIONS: dict[str, tuple[str, str]] = {
    START: (
        "TraceStart",
        "string settings\nbool simulated\nuint32 boot_faults",
    ),
    SETTINGS: ("TraceSettings", "uint32 tick\nstring settings"),
    INPUTS: (
        "TraceInputs",
        f"uint32 tick\nbool service_alive\n{_NUMBERS}\nuint8[{arcs.SIZE}] arcs",
    ),
    DECISION: (
        "TraceDecision",
        "uint32 tick\n" + "\n".join(f"int32 {name}" for name in DECIDED),
    ),
    ENDED: ("TraceEnded", "uint32 tick\nstring reason"),
}


def type_name(topic: str) -> str:
    """The ROS name of the messages of a topic."""
    return ros.PACKAGE + DEFINITIONS[topic][0]


@dataclass(frozen=True)
class Taken:
    """The inputs of one tick."""

    around: tuple[int, ...]
    """In the order of AROUND."""
    inputs: tuple[int, ...]
    """In the order of TAKEN."""
    arcs: bytes
    service_alive: bool

    def fields(self, tick: int) -> dict[str, Any]:
        """As a message."""
        numbers = zip((*AROUND, *TAKEN), (*self.around, *self.inputs), strict=True)
        named = {name: _signed(number) for name, number in numbers}
        return {"tick": tick, "service_alive": self.service_alive, **named, "arcs": self.arcs}

    @classmethod
    def of(cls, message: Any) -> Taken:
        """From a message. Raises NoTrace: it lacks a field, which is not NEUTRAL either."""
        names = (*AROUND, *TAKEN)
        recorded = {name: getattr(message, name) for name in names if hasattr(message, name)}
        values = filled(recorded, names)
        return cls(
            tuple(values[name] for name in AROUND),
            tuple(values[name] for name in TAKEN),
            bytes(message.arcs),
            bool(message.service_alive),
        )


def filled(recorded: Mapping[str, int], names: Sequence[str]) -> Mapping[str, int]:
    """What was recorded, with NEUTRAL. Raises NoTrace if it then still lacks some of `names`."""
    values = {**NEUTRAL, **recorded}
    missing = dict.fromkeys(name.split()[0] for name in names if name not in values)
    if missing:
        raise NoTrace(f"its board had no such inputs, which this core needs: {', '.join(missing)}")
    return values


def decision(core: Any, toggled: bool) -> tuple[int, ...]:
    """A Tick's decisions, in the order of DECIDED; `toggled`: the enable line changed."""
    safety = core.safety
    obstacles = core._parts[1]
    return (
        safety.state,
        core.motion.state,
        safety.override,
        safety.arm_reason,
        safety.first_fault,
        _signed(safety.faults),
        safety.edge or safety.spent_edge,
        obstacles.decisions,
        core.linear_permille,
        core.turn_permille,
        int(toggled),
    )


def _signed(number: int) -> int:
    return (int(number) + (1 << 31)) % (1 << 32) - (1 << 31)
