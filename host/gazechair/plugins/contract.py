"""The contract with the author of a plug-in: an input, a mode, intents, and the sensed world.

A plug-in is a class, found by an entry point of the group `gazechair.inputs` or `gazechair.modes`,
and runs in its own child process. docs/extending.md builds one of each.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from gazelink.codes import DIRECTIONS

OUTPUT_MAX = 1000


class Unusable(Exception):
    """Raised by a plug-in that cannot work now: one plain line with the cause and what to do."""


@dataclass(frozen=True)
class Intent:
    """What a person wants now. Created by hold(), step(), drive(), choose()."""

    do: str
    """ "nothing", "stop", "hold", "step", "drive" or "choose"."""
    what: str = ""
    """The direction of a hold or a step; the mode that is chosen."""
    linear_permille: int = 0
    turn_permille: int = 0

    @property
    def moves(self) -> bool:
        """True for a press: neither nothing nor stop."""
        return self.do not in ("nothing", "stop")


NOTHING = Intent("nothing")
"""The person lets go: what this input pressed ends. After its start, and after anyone's stop,
nothing moves until this was sensed for 0.3 s without a break."""
STOP = Intent("stop")
"""Nobody drives while this is sensed."""


def hold(direction: str) -> Intent:
    """Drive in that direction for as long as this is sensed."""
    return _known(Intent("hold", direction))


def step(direction: str) -> Intent:
    """One step in that direction; it ends by itself. The next one needs NOTHING in between."""
    return _known(Intent("step", direction))


def drive(linear_permille: int, turn_permille: int) -> Intent:
    """Proportional, -1000..1000 each: forward and left are positive."""
    for value in (linear_permille, turn_permille):
        if type(value) is not int or abs(value) > OUTPUT_MAX:
            raise ValueError(f"a whole number -{OUTPUT_MAX}..{OUTPUT_MAX}, not {value!r}")
    return Intent("drive", "", linear_permille, turn_permille)


def choose(mode: str) -> Intent:
    """Press the mode of that name, for as long as this is sensed."""
    return Intent("choose", mode)


def _known(intent: Intent) -> Intent:
    if intent.what not in DIRECTIONS:
        raise ValueError(f"one of {', '.join(DIRECTIONS)}, not {intent.what!r}")
    return intent


@dataclass(frozen=True)
class World:
    """What is sensed while somebody presses a mode; a mode is never given one older than 150 ms.

    Distances are in metres forward and backward, in degrees left and right.
    """

    heading_deg: float | None
    """Counter-clockwise; None: not known."""
    clearance: Mapping[str, float | None]
    """By direction, until the chair's outline touches something; None: nothing in range."""
    view: Mapping[str, str]
    """By direction: "seen", "blind" (not at this moment) or "unseen" (never)."""
    born_s: float
    """When the board reported it, monotonic s."""
    pressed_s: float
    """Age of this press in s; 0 at the first call."""


@dataclass(frozen=True)
class NoSettings:
    """No settings."""


class _Plugin:
    Settings: ClassVar[type[Any]] = NoSettings
    """A frozen dataclass of setting()s: the plug-in's table in the configuration."""
    icon: ClassVar[str] = "●"
    nl: ClassVar[str] = ""
    en: ClassVar[str] = ""
    """Its name on the page, in Dutch and in English."""
    rate_hz: ClassVar[float] = 50.0
    """Calls per second, 4..100."""
    rehearsal: ClassVar[Mapping[str, Any]] = {}
    """Settings with which it moves the chair without its device, for `gazechair plugin check`."""

    def __init__(self, settings: Any) -> None:
        """`settings`: an instance of Settings. May raise Unusable."""
        self.settings = settings

    def trouble(self) -> str:
        """What is wrong now, one plain line for page and log; "" for nothing."""
        return ""

    def close(self) -> None:
        """Release resources: called once at the end, unless the process is killed."""


class Input(_Plugin, ABC):
    """A person's device: returns what they want. Its docstring's first line describes it."""

    @abstractmethod
    def sense(self, now_s: float) -> Intent:
        """What the person wants at monotonic `now_s`. Must not block."""

    def fileno(self) -> int:
        """A file descriptor: sense() is called at once when it is readable. -1: there is none."""
        return -1


class Mode(_Plugin, ABC):
    """A driving mode: decides how to drive while it is pressed. Its docstring describes it."""

    auto: ClassVar[bool] = False
    """It drives while nobody holds it: one press starts it, under supervision; any other press ends
    it (promises P17 to P20). Each world must be answered anew: an answer lives for 150 ms."""

    @abstractmethod
    def drive(self, world: World) -> tuple[int, int] | None:
        """(linear, turn) in permille, as in drive(); None: this press is finished."""
