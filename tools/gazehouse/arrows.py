"""The import graph of the rooms, read from the sources: arrows and cycles. Runs nothing.

An arrow is any import, also one inside a function or only for type checkers.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from gazesetup.paths import ROOT, SOURCE_ROOTS

# Every room above those that it may import from, one line per storey: top to bottom.
STOREYS: tuple[tuple[str, ...], ...] = (
    ("gazehouse",),
    ("gazemeasure",),
    ("gazeprove",),
    ("gazedemo", "gazetwin", "gazecontract", "gazereplay", "gazedeb"),
    ("gazesim",),
    ("gazechair.cli", "gazeboard.main"),
    ("gazechair.daemon",),
    ("gazechair.first_drive", "gazechair.service", "gazechair.producers"),
    (
        "gazechair.web",
        "gazechair.commissioning",
        "gazechair.plugins",
        "gazechair.blackbox",
        "gazechair.following",
        "gazeboard.app",
    ),
    ("gazechair.driving", "gazechair.assist", "gazechair.going", "gazeboard.boards"),
    (
        "gazechair.people",
        "gazechair.sensing",
        "gazechair.picture",
        "gazechair.alerts",
        "gazeboard.io",
    ),
    ("gazechair.board", "gazechair.config", "gazeboard.turning"),
    ("gazechair.base", "gazeboard.core"),
    ("gazelink", "gazesetup"),
)

Imports = Mapping[str, frozenset[str]]


@dataclass(frozen=True)
class Arrow:
    """One room imports from another: the modules that do so, `from -> to`."""

    start: str
    end: str
    imports: tuple[tuple[str, str], ...]

    def __str__(self) -> str:
        shown = ", ".join(f"{a} -> {b}" for a, b in self.imports[:3])
        return f"{self.start} -> {self.end} ({shown})"


def modules(root: Path = ROOT) -> dict[str, Path]:
    """Every module of the source roots: dotted name -> file."""
    found = {}
    for source in SOURCE_ROOTS:
        for file in sorted((root / source).rglob("*.py")):
            name = file.relative_to(root / source).with_suffix("").as_posix().replace("/", ".")
            found[name.removesuffix(".__init__")] = file
    return found


def imports(known: Mapping[str, Path]) -> dict[str, frozenset[str]]:
    """Which of the known modules each of them imports, at any place where it runs."""
    return {
        name: frozenset(imported(ast.parse(file.read_text()), known)) - {name}
        for name, file in known.items()
    }


def imported(tree: ast.AST, known: Mapping[str, Path]) -> Iterator[str]:
    """The known modules that a file imports, at any place."""
    for node in _statements(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                inside = f"{node.module}.{alias.name}"
                yield from {inside if inside in known else node.module} & known.keys()
        elif isinstance(node, ast.Import):
            yield from {alias.name for alias in node.names} & known.keys()


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """All nodes with statements."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.expr):
            continue
        yield node
        yield from _statements(node)


def room(module: str) -> str:
    """The room a module belongs to: the longest name of STOREYS that it begins with."""
    names = [name for storey in STOREYS for name in storey]
    fitting = [name for name in names if module == name or module.startswith(name + ".")]
    return max(fitting, key=len, default="")


def arrows(graph: Imports) -> list[Arrow]:
    """Between rooms, in the order of their names. Modules outside all rooms have none."""
    between: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for start, ends in graph.items():
        for end in sorted(ends):
            pair = (room(start), room(end))
            if all(pair) and pair[0] != pair[1]:
                between.setdefault(pair, []).append((start, end))
    return [Arrow(*pair, tuple(made)) for pair, made in sorted(between.items())]


def upward(found: Iterable[Arrow]) -> list[Arrow]:
    """Arrows to a room of the same storey or a higher one."""
    storey = {name: at for at, names in enumerate(STOREYS) for name in names}
    return [arrow for arrow in found if storey[arrow.end] <= storey[arrow.start]]


def circles(graph: Imports) -> list[list[str]]:
    """Groups of modules that import each other in a circle (Tarjan's algorithm)."""
    number: dict[str, int] = {}
    lowest: dict[str, int] = {}
    path: list[str] = []
    found: list[list[str]] = []

    def visit(name: str) -> None:
        number[name] = lowest[name] = len(number)
        path.append(name)
        for other in graph[name]:
            if other not in number:
                visit(other)
                lowest[name] = min(lowest[name], lowest[other])
            elif other in path:
                lowest[name] = min(lowest[name], number[other])
        if lowest[name] == number[name]:
            at = path.index(name)
            if len(path) > at + 1:
                found.append(sorted(path[at:]))
            del path[at:]

    for name in graph:
        if name not in number:
            visit(name)
    return found
