"""Finds the installed plug-ins by their entry points, without importing any."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import entry_points

GROUPS = {"input": "gazechair.inputs", "mode": "gazechair.modes"}


@dataclass(frozen=True)
class Found:
    """One plug-in offered by an installed package."""

    kind: str
    name: str
    entry: str
    """ "module:Class"."""
    package: str


def installed() -> list[Found]:
    """All plug-ins, inputs first, by name."""
    return [
        Found(kind, one.name, one.value, one.dist.name if one.dist else "?")
        for kind, group in GROUPS.items()
        for one in sorted(entry_points(group=group), key=lambda entry: entry.name)
    ]


def find(kind: str, name: str) -> Found:
    """The plug-in of that name. Raises LookupError, one plain line."""
    of_kind = [one for one in installed() if one.kind == kind]
    fitting = {one.entry: one for one in of_kind if one.name == name}
    if not fitting:
        known = ", ".join(one.name for one in of_kind) or "none"
        raise LookupError(f"no {kind} called {name} is installed; there are: {known}")
    if len(fitting) > 1:
        packages = " and ".join(one.package for one in fitting.values())
        raise LookupError(f"{packages} both offer the {kind} {name}; uninstall one of them")
    return next(iter(fitting.values()))
