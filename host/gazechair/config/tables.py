"""Tables of settings: one frozen dataclass each, whose fields carry their rule and meaning."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import Field, field, fields
from typing import Any, TypeVar, cast

from gazechair.config import rules
from gazechair.config.rules import Kind, Refused

T = TypeVar("T")


class BadSetting(ValueError):
    """Raised for a key that a table does not have, or a value that it does not accept."""

    def __init__(self, key: str, reason: str) -> None:
        super().__init__(f"{key} {reason}")
        self.key = key
        self.reason = reason


def setting(default: T, kind: Kind, meaning: str) -> T:
    """A field of a table: its default, its rule, and its meaning in one line."""
    return field(default=default, metadata={"kind": kind, "meaning": meaning})


def read(table: type[T], values: Mapping[str, Any], title: str) -> T:
    """An instance of `table` with `values`, called `title` in refusals. Raises BadSetting."""
    known = {f.name: f for f in fields(cast(Any, table))}
    checked = {}
    for key, value in values.items():
        if key not in known:
            raise BadSetting(key, f"is no setting; {title} has {', '.join(known) or 'none'}")
        try:
            checked[key] = _kind(known[key]).check(value)
        except Refused as refusal:
            raise BadSetting(key, str(refusal)) from None
    return table(**checked)


def described(table: type[Any], title: str) -> Iterator[str]:
    """The table as lines of TOML: every setting at its default, with its range and meaning."""
    yield from (f"# {line.strip()}".rstrip() for line in (table.__doc__ or "").strip().splitlines())
    yield f"[{title}]"
    for one in fields(table):
        yield f"# {one.metadata['meaning']} ({_kind(one).describe})"
        yield f"{one.name} = {rules.to_toml(one.default)}"


def _kind(of: Field[Any]) -> Kind:
    return cast(Kind, of.metadata["kind"])
