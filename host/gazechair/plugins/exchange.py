"""Messages between a plug-in's process and the daemon: small JSON, values with their birth time.

Up, a value: the intent or output, when it was sensed, and its time to live. Down: the world.
Everything is checked on arrival, before anything acts on it.
"""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from typing import Any

from gazechair.base import json_text
from gazechair.plugins.contract import OUTPUT_MAX, Intent
from gazelink.codes import DIRECTIONS

LONGEST = 4096
"""Bytes of a record."""
LIFE_S = 0.25
"""How long a value may move the chair after it was sensed; below the 300 ms of promise P3."""
AUTO_LIFE_S = 0.15
"""The same for an auto mode: promise P17."""
WORLD_OLD_S = 0.15
"""A mode does not get an older world."""
RECORDS_PER_S = 400.0
"""More values count as a flood."""
_MAX_COUNT = 1 << 31
_DOES = ("nothing", "stop", "hold", "step", "drive", "choose")


class BadValue(ValueError):
    """Raised for a value that no correct plug-in sends; the text is one plain line."""


@dataclass(frozen=True)
class Value:
    """One message from a plug-in."""

    born_s: float
    """When it was sensed, monotonic."""
    press: int
    """Input: the number of its press. Mode: the press that it answers."""
    intent: Intent
    """Mode: drive, or nothing when it has ended."""
    stops: int = 0
    """Count of an input's stops, so that a newer value cannot hide one."""
    trouble: str = ""

    def pack(self) -> bytes:
        """As sent."""
        i = self.intent
        out = (i.linear_permille, i.turn_permille)
        fields = (self.born_s, self.press, i.do, i.what, *out, self.stops, self.trouble[:80])
        return json.dumps(fields).encode()


def unpack(payload: bytes) -> Value:
    """The value in a record. Raises BadValue."""
    try:
        fields = json_text.parse(payload)
        born_s, press, do, what, linear, turn, stops, trouble = fields
    except (ValueError, TypeError):
        raise BadValue("no value") from None
    if type(born_s) is not float or not math.isfinite(born_s):
        raise BadValue("a value without its time")
    for count in (press, stops):
        if type(count) is not int or not 0 <= count <= _MAX_COUNT:
            raise BadValue("a count that is no whole number")
    for output in (linear, turn):
        if type(output) is not int or abs(output) > OUTPUT_MAX:
            raise BadValue(f"an output that is not within -{OUTPUT_MAX}..{OUTPUT_MAX}")
    if do not in _DOES or not isinstance(what, str) or not isinstance(trouble, str):
        raise BadValue("an intent that there is not")
    if do in ("hold", "step") and what not in DIRECTIONS:
        raise BadValue("a direction that there is not")
    return Value(born_s, press, Intent(do, what, linear, turn), stops, plain(trouble, 200))


@dataclass(frozen=True)
class Facts:
    """A plug-in's description of itself, sent once."""

    about: str
    icon: str
    names: dict[str, str]
    auto: bool = False

    def pack(self) -> bytes:
        """As sent."""
        return json.dumps(asdict(self)).encode()


def unpack_facts(payload: bytes) -> Facts:
    """The facts in a record, truncated to fit on a tile. Raises BadValue."""
    try:
        fields = json_text.parse(payload)
        names = {plain(k, 2): plain(v, 20) for k, v in list(fields["names"].items())[:20]}
        auto = fields.get("auto") is True
        return Facts(plain(fields["about"], 200), plain(fields["icon"], 4), names, auto)
    except (ValueError, KeyError, TypeError, AttributeError):
        raise BadValue("no facts") from None


def plain(text: Any, longest: int) -> str:
    """`text` on one line, without unprintable characters."""
    if not isinstance(text, str):
        raise TypeError
    return "".join(c if c.isprintable() else " " for c in text[:longest])
