"""The result of a replay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gazelink import codes


class NoTrace(ValueError):
    """Raised for a log that cannot be replayed; the text is the reason, in one line."""


@dataclass(frozen=True)
class Difference:
    """The first tick with a different decision."""

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
    """The result of a replay."""

    ticks: int = 0
    lives: int = 0
    decisions: int = 0
    """How many differed from the tick before."""
    armed: int = 0
    """Ticks in which driving was on."""
    compared: int = 0
    """Ticks whose decisions were recorded."""
    gaps: int = 0
    unchecked: int = 0
    """Ticks in those: the trace lacks their inputs."""
    difference: Difference | None = None
    ending: str = ""
    """Up to where the log is readable that has no end; "" for a finished one."""
    unnamed: bool = False
    """The log does not name the version of its board's firmware; this one's was assumed."""


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
