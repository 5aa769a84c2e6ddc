"""What a page may say, as types: checks one decoded JSON object completely before anything acts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gazelink import codes

MAX_EDGE = 1 << 31
MAX_TOKEN = 1 << 53  # what JavaScript counts exactly

_VERBS = {name: codes.VERBS.index(name) for name in ("forward", "backward", "left", "right")}


class BadMessage(ValueError):
    """A message that is not of the page protocol; the text is one plain line."""


@dataclass(frozen=True)
class Drive:
    """A drive command: one press, repeated while held."""

    verb: int
    mode: int
    edge: int
    """The page's press counter, 1 or more."""
    token: int


@dataclass(frozen=True)
class Arm:
    """Begin to drive."""

    token: int


@dataclass(frozen=True)
class Beat:
    """The page lives. Never an intent to move."""

    token: int | None
    """None before the page has heard a token."""


@dataclass(frozen=True)
class Plain:
    """A message without content: STOP, DISARM, EMERGENCY or RESET."""

    kind: str


STOP = Plain("stop")
DISARM = Plain("disarm")
EMERGENCY = Plain("emergency")
RESET = Plain("reset")
_PLAIN = {plain.kind: plain for plain in (STOP, DISARM, EMERGENCY, RESET)}

PageMessage = Drive | Arm | Beat | Plain


def parse(message: dict[str, Any]) -> PageMessage:
    """The meaning of one decoded message. Raises BadMessage, but never for a stop of any kind."""
    kind = message.get("k")
    if isinstance(kind, str) and kind in _PLAIN:
        return _PLAIN[kind]
    if kind == "hb":
        token = message.get("token")
        return Beat(None if token is None else _integer(message, "token", 0, MAX_TOKEN))
    if kind == "arm":
        return Arm(_integer(message, "token", 0, MAX_TOKEN))
    if kind == "cmd":
        return Drive(
            _VERBS[_choice(message, "verb", tuple(_VERBS))],
            codes.MODES.index(_choice(message, "mode", codes.MODES)),
            _integer(message, "edge", 1, MAX_EDGE),
            _integer(message, "token", 0, MAX_TOKEN),
        )
    known = "cmd, arm, hb, " + ", ".join(_PLAIN)
    raise BadMessage(f'"k" must be one of {known}')


def _integer(message: dict[str, Any], key: str, low: int, high: int) -> int:
    value = message.get(key)
    if type(value) is not int or not low <= value <= high:
        raise BadMessage(f'{message["k"]}: "{key}" must be a whole number {low}..{high}')
    return value


def _choice(message: dict[str, Any], key: str, names: tuple[str, ...]) -> str:
    value = message.get(key)
    if not isinstance(value, str) or value not in names:
        raise BadMessage(f'{message["k"]}: "{key}" must be one of {", ".join(names)}')
    return value
