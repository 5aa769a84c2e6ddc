"""The fields of a profile: one table with limits, and the check of every value.

The limits and defaults are those of other gaze-driving projects (Eyedrivomatic, Microsoft's gaze
library, Tobii), for scanning those of Saltillo's and Tobii Dynavox's switch settings and of
docs/scanning.md: starting points, to be adjusted with the person.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from gazechair.base.refused import Refused
from gazechair.config.settings import (
    DRIVING_MODES,
    DWELL_MS,
    LEAVE_GRACE_MS,
    POINTER_STALE_MS,
    DriverConfig,
)

Profile = dict[str, Any]

MOST_NAME = 40
_JOINER = "\u200d"  # of several signs to one emoji, as a person in a wheelchair
# Signals of a switch interface: a key, or a pointer button ("click": also a touch).
_SWITCHES = ("space", "enter", "tab", "f8", "click", "right_click")


class ProfileRefused(Refused):
    """Raised for a refused change."""


@dataclass(frozen=True)
class Field:
    """One field of a profile."""

    default: Any
    low: int = 0
    high: int = 0
    step: int = 0
    """Of a whole number: low..high, and the step of one press on + or -. 0: not a number."""
    choices: tuple[str, ...] = ()
    longest: int = MOST_NAME
    """Of a text, in characters; it may be empty if its default is."""
    care: bool = False
    """Only the caretaker may change it."""

    def accept(self, name: str, value: Any) -> Any:
        """The value, if this field accepts it. Raises ProfileRefused."""
        if self.choices:
            if isinstance(value, str) and value in self.choices:
                return value
            wanted = f"one of {', '.join(self.choices)}"
        elif self.step:
            if type(value) is int and self.low <= value <= self.high:
                return value
            wanted = f"a whole number {self.low}..{self.high}"
        elif isinstance(self.default, bool):
            if isinstance(value, bool):
                return value
            wanted = "true or false"
        else:
            least = 1 if self.default else 0
            fits = isinstance(value, str) and least <= len(value) <= self.longest
            if fits and value.replace(_JOINER, "").isprintable():
                return value
            wanted = f"a text of {least}..{self.longest} characters"
        raise ProfileRefused("profile_value", f"{name} must be {wanted}")

    def as_json(self) -> dict[str, Any]:
        """What a page needs to offer this field."""
        if self.choices:
            return {"choices": list(self.choices)}
        if self.step:
            return {"low": self.low, "high": self.high, "step": self.step}
        return {} if self.longest == MOST_NAME else {"longest": self.longest}


def fields(languages: Sequence[str], house: Mapping[str, Any]) -> dict[str, Field]:
    """Every field; `languages`: those available, `house`: defaults that replace these."""
    driver = DriverConfig()
    table = {
        "name": Field("driver"),
        "help_sentence": Field("", longest=120),
        "mode": Field(driver.mode, choices=DRIVING_MODES),
        "dwell_ms": Field(driver.dwell_ms, *DWELL_MS, 100),
        "steer_dwell_ms": Field(200, 100, 800, 50),
        "button_dwell_ms": Field(1000, 500, 3000, 100),
        "leave_grace_ms": Field(driver.leave_grace_ms, *LEAVE_GRACE_MS, 50),
        "pointer_stale_ms": Field(driver.pointer_stale_ms, *POINTER_STALE_MS, 100),
        "growth_percent": Field(20, 0, 20, 5),
        "auto_off_s": Field(15, 10, 20, 1),
        "auto": Field(False, care=True),
        "assist": Field(driver.assist, care=True),
        "scan": Field("off", choices=("off", "rows", "single")),
        "scan_switch": Field("space", choices=_SWITCHES),
        "scan_ms": Field(1500, 500, 4000, 100),
        "scan_accept_ms": Field(50, 0, 1000, 50),
        "scan_debounce_ms": Field(40, 0, 100, 10),
        "scan_lockout_ms": Field(300, 0, 2000, 100),
        "scan_gaze": Field(True),
        "contrast": Field("normal", choices=("normal", "high", "night")),
        "mirrored": Field(False),
        "tones": Field(True),
        "language": Field("nl", choices=tuple(languages)),
    }
    for name, value in house.items():
        field = table[name]
        default = field.accept(name, value)
        table[name] = replace(field, default=default)
    return table


def check_whole(profile: Profile) -> None:
    """Checks between fields. Raises ProfileRefused."""
    if profile["steer_dwell_ms"] > profile["dwell_ms"]:
        detail = "steer_dwell_ms must not be above dwell_ms: starting is never the easier one"
        raise ProfileRefused("profile_value", detail)
