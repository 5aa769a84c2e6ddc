"""Rules for single settings: which values each accepts, its meaning and its place in the file."""

from __future__ import annotations

import contextlib
import ipaddress
import json
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from gazechair.base.languages import languages

Arc = tuple[float, float]

_MOST = sys.float_info.max  # TOML's whole numbers have no limit
WORD = re.compile(r"[\w-]{1,20}")
"""A short name, such as a mode's; see word."""
_UNREPEATED = "the value is not repeated here"


class Secret(str):
    """A text that no log or error shows."""

    def __repr__(self) -> str:
        return "(secret)"


class Refused(ValueError):
    """Raised for a value that a setting does not accept; the text names what it accepts."""


@dataclass(frozen=True)
class Kind:
    """The values that a setting accepts."""

    describe: str
    """As text: "a whole number 0..3000"."""
    check: Callable[[Any], Any]
    """Returns the value as the program uses it; raises Refused."""


def _kind(describe: str, accept: Callable[[Any], Any]) -> Kind:
    def check(value: Any) -> Any:
        try:
            return accept(value)
        except (TypeError, ValueError):
            raise Refused(f"must be {describe}, not {to_toml(value)}") from None

    return Kind(describe, check)


def text() -> Kind:
    """Any text without control characters."""

    def accept(value: Any) -> str:
        if not isinstance(value, str) or not value.isprintable():
            raise ValueError
        return value

    return _kind("a text", accept)


def address() -> Kind:
    """An address as scheme://...; it may contain a password, so a refusal does not repeat it."""
    describe = "an address as service://..."

    def check(value: Any) -> Secret:
        whole = r"(\w+://\S+)?"
        if not isinstance(value, str) or not value.isprintable() or not re.fullmatch(whole, value):
            raise Refused(f"must be {describe}; {_UNREPEATED}")
        return Secret(value)

    return Kind(describe, check)


def broker() -> Kind:
    """The address of an MQTT broker, "" for none; secret, as `address`."""
    describe = "an address as mqtt://user:password@host:port"
    hint = "with [ ] / ? # in user and password percent-encoded (# is %23)"
    name = r"\[[^\s\[\]]*\]|[^\s/?#\[\]@:]*"
    whole = rf"mqtts?://(?:[^\s/?#\[\]]*@)?({name})(?::([0-9]{{0,9}}))?/?"

    def check(value: Any) -> Secret:
        if value == "":
            return Secret(value)
        found = re.fullmatch(whole, value) if isinstance(value, str) else None
        if found is None or not _splits(value):
            raise Refused(f"must be {describe}, {hint}; {_UNREPEATED}")
        written, port = found.groups()
        bare = written.strip("[]")
        if not is_host(bare) or (written != bare) != (":" in bare):
            raise Refused(f"must name a host or an address after mqtt://; {_UNREPEATED}")
        if port is not None and not 1 <= int(port or 0) <= 65535:
            raise Refused(f"must have a port 1..65535, or none; {_UNREPEATED}")
        return Secret(value)

    return Kind(describe, check)


def _splits(value: str) -> bool:
    # Python refuses signs that normalize to one of : / ? # @, and its error repeats the password.
    try:
        urlsplit(value)
    except ValueError:
        return False
    return value.isprintable()


def is_host(name: str) -> bool:
    """True for an IP address without a zone, or a host name of at most 253 characters."""
    with contextlib.suppress(ValueError):
        return bool(ipaddress.ip_address(name)) and "%" not in name
    if len(name) > 253 or re.fullmatch(r"[\d.]*", name):
        return False
    return re.fullmatch(r"([A-Za-z0-9_-]{1,63}\.)*[A-Za-z0-9_-]{1,63}\.?", name) is not None


def host() -> Kind:
    """An address or a name of a host."""

    def accept(value: Any) -> str:
        if not isinstance(value, str) or not is_host(value):
            raise ValueError
        return value

    return _kind("an address as 192.168.1.5, or a host name", accept)


def word() -> Kind:
    """A name: 1 to 20 letters, digits, - and _."""

    def accept(value: Any) -> str:
        if not isinstance(value, str) or not WORD.fullmatch(value):
            raise ValueError
        return value

    return _kind("a name of 1 to 20 letters, digits, - and _", accept)


def choice(*names: str) -> Kind:
    """One of `names`."""

    def accept(value: Any) -> str:
        if not isinstance(value, str) or value not in names:
            raise ValueError
        return value

    return _kind(" or ".join(f'"{name}"' for name in names), accept)


def choices(*names: str) -> Kind:
    """Some of `names`, in a list; at least one."""

    def accept(value: Any) -> tuple[str, ...]:
        if not isinstance(value, list) or not value or not all(name in names for name in value):
            raise ValueError
        return tuple(value)

    return _kind(f"a list of {', '.join(names)}", accept)


def language() -> Kind:
    """A language: the name of a file of texts for the pages."""

    def accept(value: Any) -> str:
        if value not in languages():
            raise ValueError
        return str(value)

    return _kind('the name of a file in web/strings, as "nl" or "en"', accept)


def flag() -> Kind:
    """true or false."""

    def accept(value: Any) -> bool:
        if not isinstance(value, bool):
            raise TypeError
        return value

    return _kind("true or false", accept)


def integer(low: int, high: int) -> Kind:
    """A whole number in low..high, both included."""

    def accept(value: Any) -> int:
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            raise ValueError
        return value

    return _kind(f"a whole number {low}..{high}", accept)


def number(low: float, high: float) -> Kind:
    """A number in low..high, both included; NaN is refused."""

    def accept(value: Any) -> float:
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise TypeError
        if not low <= value <= high:
            raise ValueError
        return float(value)

    return _kind(f"a number {low}..{high}", accept)


def arc() -> Kind:
    """Two angles in degrees, counter-clockwise from first to second."""

    def accept(value: Any) -> Arc:
        if not isinstance(value, list):
            raise TypeError
        start, end = (_angle(item) for item in value)
        if (end - start) % 360.0 == 0.0:
            raise ValueError
        return start, end

    return _kind("two different angles [from, to] in -180..180", accept)


def arcs(most_deg: float) -> Kind:
    """A list of arcs (see `arc`); all together at most `most_deg` degrees."""
    one = arc()

    def accept(value: Any) -> tuple[Arc, ...]:
        if not isinstance(value, list):
            raise TypeError
        read = tuple(one.check(item) for item in value)
        if sum((end - start) % 360.0 for start, end in read) > most_deg:
            raise ValueError
        return read

    return _kind(f"a list of arcs [from, to] in -180..180, {most_deg:g} degrees in all", accept)


def corners() -> Kind:
    """A list of corners [x, y] in metres."""

    def accept(value: Any) -> tuple[tuple[float, float], ...]:
        if not isinstance(value, list):
            raise TypeError
        return tuple((_finite(x), _finite(y)) for x, y in value)

    return _kind("a list of corners [x, y] in metres", accept)


def _finite(value: Any) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise TypeError
    if not abs(value) <= _MOST:
        raise ValueError
    return float(value)


def _angle(value: Any) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise TypeError
    if not -180 <= value <= 180:
        raise ValueError
    return float(value)


def to_toml(value: Any) -> str:
    """A value in TOML syntax (text, number, true/false, list; None is the empty list)."""
    if value is None:
        return "[]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(to_toml(item) for item in value) + "]"
    return str(value)


def line_of(content: str, section: str, key: str | None, at: int = 0) -> int:
    """The line (from 1) of `key` in `section`; of the section when key is None or not found.

    `at`: which of the tables of that name, from 0.
    """
    here = ""
    section_line = 1
    tables = -1
    for number_here, line in enumerate(content.splitlines(), 1):
        header = re.match(r"\s*(\[+)\s*[\"']?([^\]\"'.\s]+)([^\]]*)", line)
        if header and "=" not in line.split("]")[0]:
            # Repeated tables inside a section are counted separately from it.
            here = "".join(header.groups()[1:]).rstrip() if header[1] == "[[" else header[2]
            tables += here == section
            if here == section and tables == at:
                section_line = number_here
            continue
        if here == section and tables != at:
            continue
        name = re.match(r"\s*[\"']?([\w-]+)[\"']?(?:\s*\.\s*[\"']?([\w-]+)[\"']?)?\s*[=.]", line)
        if not name:
            continue
        path = [here, *filter(None, name.groups())] if here else [*filter(None, name.groups())]
        if path[0] == section and (key is None or key in path[1:]):
            return number_here if key is not None or not here else section_line
    return section_line
