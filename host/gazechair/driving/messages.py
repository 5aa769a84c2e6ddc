"""Messages from a page as types: validates each JSON object completely before anything acts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from gazechair.config.rules import WORD
from gazelink import codes

MAX_EDGE = 1 << 31
MAX_TOKEN = 1 << 53  # largest integer that is exact in JavaScript
MAX_SINCE_MS = 500  # the longest time that a page may count from a token
LOWEST_CAP_PERMILLE = 50

VERBS = {name: codes.VERBS.index(name) for name in codes.DIRECTIONS}
"""Verbs of the four directions, by their names."""


class BadMessage(ValueError):
    """Raised for a message outside the page protocol; the text is one plain line."""


@dataclass(frozen=True)
class Drive:
    """A drive command: one press, repeated while active."""

    verb: int
    mode: int
    edge: int
    """The page's press counter, 1 or more."""
    proof: int
    """When the page sent it, in token time (see tokens): never later than it really was."""
    linear_permille: int = 0
    """-1000..1000, forward positive; of codes.DRIVE."""
    turn_permille: int = 0
    """-1000..1000, left positive; of codes.DRIVE."""
    life_s: float = math.inf
    """Time to live from its proof on, set by its producer; never longer than the board's."""


@dataclass(frozen=True)
class UseMode:
    """A press on a mode, repeated while active: the mode decides how to drive meanwhile."""

    mode: str
    edge: int
    proof: int
    life_s: float = math.inf


@dataclass(frozen=True)
class Arm:
    """Begin to drive."""

    proof: int


@dataclass(frozen=True)
class Take:
    """Take over from the present owner."""

    proof: int


@dataclass(frozen=True)
class Reset:
    """Clear the latched faults."""

    proof: int


@dataclass(frozen=True)
class Beat:
    """A page's heartbeat. Never an intent to move."""

    proof: int | None
    """None before the page has received a token."""


@dataclass(frozen=True)
class Watch:
    """Somebody supervises the auto motion: looks at the page, or holds a button."""

    proof: int


@dataclass(frozen=True)
class Cap:
    """The highest permitted output."""

    permille: int


@dataclass(frozen=True)
class Call:
    """The driver asks for help, or no longer needs it; a caretaker comes, or is there."""

    on: bool
    there: bool = False
    """A caretaker who was coming has arrived."""


@dataclass(frozen=True)
class HoldBypass:
    """The caretaker presses the bypass button: one press, repeated while active."""

    edge: int
    proof: int


@dataclass(frozen=True)
class Plain:
    """A message without content."""

    kind: str


STOP = Plain("stop")
DISARM = Plain("disarm")
EMERGENCY = Plain("emergency")
RELEASE = Plain("release")
END_BYPASS = Plain("bypass")
_PLAIN = {plain.kind: plain for plain in (STOP, DISARM, EMERGENCY, RELEASE)}
# Only an input sends this: its person let go. A page sends stop.
LET_GO = Plain("let_go")
_OTHERS = ("cmd", "drive", "mode", "arm", "take", "reset", "hb", "cap", "call", "bypass", "watch")

PageMessage = Drive | UseMode | Arm | Take | Reset | Beat | Watch | Cap | Call | HoldBypass | Plain


def parse(message: dict[str, Any]) -> PageMessage:
    """The meaning of one decoded message. Raises BadMessage, but never for a stop of any kind."""
    kind = message.get("k")
    if isinstance(kind, str) and kind in _PLAIN:
        return _PLAIN[kind]
    if kind == "hb":
        return Beat(None if message.get("token") is None else _proof(message))
    if kind == "watch":
        return Watch(_proof(message))
    if kind == "arm":
        return Arm(_proof(message))
    if kind == "take":
        return Take(_proof(message))
    if kind == "reset":
        return Reset(_proof(message))
    if kind == "cmd":
        return Drive(
            VERBS[_choice(message, "verb", tuple(VERBS))],
            codes.MODES.index(_choice(message, "mode", codes.MODES[: codes.TUNE])),
            _integer(message, "edge", 1, MAX_EDGE),
            _proof(message),
        )
    if kind == "drive":
        return Drive(
            codes.DRIVE,
            codes.CONTINUOUS,
            _integer(message, "edge", 1, MAX_EDGE),
            _proof(message),
            _integer(message, "linear", -1000, 1000),
            _integer(message, "turn", -1000, 1000),
        )
    if kind == "mode":
        name = message.get("mode")
        if not isinstance(name, str) or not WORD.fullmatch(name):
            raise BadMessage('mode: "mode" must be the name of a mode')
        return UseMode(name, _integer(message, "edge", 1, MAX_EDGE), _proof(message))
    if kind == "cap":
        return Cap(_integer(message, "permille", LOWEST_CAP_PERMILLE, 1000))
    if kind == "call":
        there = "there" in message and _flag(message, "there")
        return Call(_flag(message, "on"), there)
    if kind == "bypass":
        if not _flag(message, "held"):
            return END_BYPASS
        return HoldBypass(_integer(message, "edge", 1, MAX_EDGE), _proof(message))
    raise BadMessage(f'"k" must be one of {", ".join((*_OTHERS, *_PLAIN))}')


def _proof(message: dict[str, Any]) -> int:
    token = _integer(message, "token", 0, MAX_TOKEN)
    if message.get("since") is None:
        return token
    return token + _integer(message, "since", 0, MAX_SINCE_MS)


def _integer(message: dict[str, Any], key: str, low: int, high: int) -> int:
    value = message.get(key)
    if type(value) is not int or not low <= value <= high:
        raise BadMessage(f'{message["k"]}: "{key}" must be a whole number {low}..{high}')
    return value


def _flag(message: dict[str, Any], key: str) -> bool:
    value = message.get(key)
    if not isinstance(value, bool):
        raise BadMessage(f'{message["k"]}: "{key}" must be true or false')
    return value


def _choice(message: dict[str, Any], key: str, names: tuple[str, ...]) -> str:
    value = message.get(key)
    if not isinstance(value, str) or value not in names:
        raise BadMessage(f'{message["k"]}: "{key}" must be one of {", ".join(names)}')
    return value
