"""What a replay found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gazelink import codes


class NoTrace(ValueError):
    """A log that cannot be replayed; one line why."""


@dataclass(frozen=True)
class Difference:
    """The first tick that decided otherwise."""

    life: int
    """Which start of the board in this file, from 1."""
    tick: int
    at_ns: int
    """Wall time."""
    recorded: dict[str, int]
    now: dict[str, int]

    def __str__(self) -> str:
        changed = [name for name in self.recorded if self.recorded[name] != self.now[name]]
        words = [
            f"{name} {_word(name, self.recorded[name])} -> {_word(name, self.now[name])}"
            for name in changed
        ]
        return f"tick {self.tick} of start {self.life}: " + ", ".join(words)


@dataclass
class Result:
    """What a replay found."""

    ticks: int = 0
    lives: int = 0
    decisions: int = 0
    """How many differed from the tick before: what was there to compare."""
    armed: int = 0
    """Ticks in which driving was on."""
    compared: int = 0
    """Ticks whose decisions were recorded."""
    gaps: int = 0
    unchecked: int = 0
    """Ticks in those: the trace does not say what they took."""
    difference: Difference | None = None


def _word(name: str, value: int) -> Any:
    if name in ("override", "arm_reason", "first_fault"):
        return codes.reason_name(value)
    if name == "state":
        return codes.STATES[value]
    if name == "motion":
        return codes.MOTIONS[value]
    if name == "faults":
        return [row[1] for row in codes.FAULTS if value >> row[0] & 1]
    return value
