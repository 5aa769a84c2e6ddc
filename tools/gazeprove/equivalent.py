"""Mutants that no test can kill, because they change nothing: by the reason why."""

from __future__ import annotations

# module -> reason -> (function, change) of each mutant
EQUIVALENT: dict[str, dict[str, tuple[tuple[str, str], ...]]] = {"motion": {}, "safety": {}}


def reasons(module: str) -> dict[tuple[str, str], str]:
    """Why each listed mutant is equivalent. Raises ValueError when one is listed twice."""
    found: dict[tuple[str, str], str] = {}
    for reason, mutants in EQUIVALENT[module].items():
        for key in mutants:
            if key in found:
                raise ValueError(f"{module} {key} is listed twice")
            found[key] = reason
    return found
