"""Mutants that no test can kill, because they change nothing: listed in equivalent/MODULE.txt.

A line that begins with "# " is the reason for those below it: "function: line  ->  changed line".
A changed line of "*" stands for all changes of that line.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from gazeprove import mutate
from gazeprove.modules import source_of

_FOLDER = Path(__file__).parent / "equivalent"
_REASON = "# "


def files() -> list[Path]:
    """The lists."""
    return sorted(_FOLDER.glob("*.txt"))


def reasons(module: str) -> dict[tuple[str, str], str]:
    """Why each listed mutant is equivalent. Raises ValueError when one is listed twice."""
    file = _FOLDER / f"{module}.txt"
    found: dict[tuple[str, str], str] = {}
    for key, reason in _read(file, mutate.keys(source_of(module))) if file.exists() else ():
        if key in found:
            raise ValueError(f"{module} {key} is listed twice")
        found[key] = reason
    return found


def _read(file: Path, known: set[tuple[str, str]]) -> Iterator[tuple[tuple[str, str], str]]:
    reason = ""
    for line in file.read_text().splitlines():
        if line.startswith(_REASON):
            reason = line.removeprefix(_REASON)
        elif line:
            if not reason:
                raise ValueError(f"{file.name}: no reason for {line}")
            function, _, change = line.partition(": ")
            for key in _meant(function, change, known):
                yield key, reason


def _meant(function: str, change: str, known: set[tuple[str, str]]) -> list[tuple[str, str]]:
    """The mutants that a line of the list means; what it says when there is none."""
    start = change.removesuffix("*")
    meant = [key for key in known if key[0] == function and key[1].startswith(start)]
    return (meant if change.endswith("  ->  *") else []) or [(function, change)]
