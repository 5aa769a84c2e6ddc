"""The tables [input.NAME] and [mode.NAME]: each enables a plug-in and has its settings."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date, time
from typing import Any

from gazechair.config.rules import choice, word
from gazechair.config.tables import BadSetting, read, setting

KINDS = ("input", "mode")
WHO = ("driver", "caretaker")
_PERSON = "person"
# Reserved: gazechair's own modes and parts, whose values would mix with a plug-in's.
_TAKEN = re.compile(r"(?:to|place)-.*|places|(?:go-look|follow-line)(?:-\d+)?|follow-person")


@dataclass(frozen=True)
class PluginConfig:
    """One enabled plug-in. Its own rules check `settings` when it starts."""

    kind: str
    """One of KINDS."""
    name: str
    person: str = "driver"
    """Whose input it is; a mode belongs to the person who chooses it."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    lines: Mapping[str, str] = field(default_factory=dict)
    """Place of each setting, as "file:line"; under "" that of the table."""

    @property
    def title(self) -> str:
        """As in the file: "input.gamepad"."""
        return f"{self.kind}.{self.name}"

    def refusal(self, key: str, reason: str) -> str:
        """One line about a refused setting: where, which and why."""
        return f"{self.lines.get(key, self.lines.get('', ''))}: {self.title}.{key} {reason}"


@dataclass(frozen=True)
class _Name:
    name: str = setting("", word(), "")


@dataclass(frozen=True)
class _Ours:
    person: str = setting("driver", choice(*WHO), "whose device it is")


def parse(kind: str, values: object, content: str, file: str) -> tuple[PluginConfig, ...]:
    """All tables of `kind` in a file's `content`. Raises BadSetting; its key is "" or a name."""
    if not isinstance(values, dict) or not all(isinstance(v, dict) for v in values.values()):
        raise BadSetting("", f"has a table for each plug-in: write it as [{kind}.NAME]")
    found = []
    for name, table in values.items():
        try:
            read(_Name, {"name": name}, "")
        except BadSetting as refused:
            raise BadSetting("", refused.reason) from None
        if kind == "mode" and _TAKEN.fullmatch(name):
            raise BadSetting("", f"{name} is gazechair's own: give the plug-in another name")
        lines = _lines(content, file, kind, name)
        own = {key: value for key, value in table.items() if key != _PERSON or kind != "input"}
        ours = {key: value for key, value in table.items() if key not in own}
        one = PluginConfig(kind, name, settings=own, lines=lines)
        try:
            person = read(_Ours, ours, one.title).person
        except BadSetting as refused:
            raise BadSetting(name, one.refusal(refused.key, refused.reason)) from None
        for key, value in own.items():
            if _has_date(value):
                reason = "must have no date or time; write it as a text, in quotes"
                raise BadSetting(name, one.refusal(key, reason))
        found.append(PluginConfig(kind, name, person, own, lines))
    return tuple(found)


def _has_date(value: object) -> bool:
    # A plug-in gets its settings as JSON, which has none.
    if isinstance(value, dict):
        return any(map(_has_date, value.values()))
    if isinstance(value, list):
        return any(map(_has_date, value))
    return isinstance(value, date | time)


def _lines(content: str, file: str, kind: str, name: str) -> dict[str, str]:
    found: dict[str, str] = {"": f"{file}:1"}
    inside = False
    header = re.compile(rf"\s*\[\s*[\"']?{kind}[\"']?\s*\.\s*[\"']?{re.escape(name)}[\"']?\s*\]")
    for number, line in enumerate(content.splitlines(), 1):
        if line.lstrip().startswith("["):
            inside = header.match(line) is not None
            if inside:
                found[""] = f"{file}:{number}"
        elif inside and (key := re.match(r"\s*[\"']?([\w-]+)[\"']?\s*[=.]", line)):
            found[key.group(1)] = f"{file}:{number}"
    return found
