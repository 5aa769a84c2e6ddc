"""Which statements and branches of a module a test runs: marks are put into its syntax tree."""

from __future__ import annotations

import ast
import importlib.abc
import importlib.machinery
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import CodeType, ModuleType

from gazeprove.modules import MODULES, file_of, source_of

_MARKS = "__marks__"  # what the marked module calls the bytes in which it marks what ran


@dataclass(frozen=True)
class Mark:
    """A place that either runs or does not: a statement, or one of the ways on from it."""

    module: str
    line: int
    way: str  # "" for the statement itself, else what its condition says: "true" or "false"


class Marked:
    """The modules with a mark at each place; once imported, `ran` says which of them were."""

    def __init__(self, modules: Sequence[str]) -> None:
        self.places: list[Mark] = []
        self._codes: dict[str, CodeType] = {}
        for module in modules:
            tree = ast.parse(source_of(module))
            for node in list(ast.walk(tree)):
                self._mark(module, node)
            ast.fix_missing_locations(tree)
            self._codes[module] = compile(tree, str(file_of(module)), "exec")
        self._marks = bytearray(len(self.places))

    def install(self) -> None:
        """Whoever imports one of the modules from now on gets the marked one."""
        serve(self._codes, {_MARKS: self._marks})

    def ran(self) -> set[Mark]:
        """What ran since this was asked before."""
        found = {self.places[at] for at, mark in enumerate(self._marks) if mark}
        self._marks[:] = bytes(len(self._marks))
        return found

    def _mark(self, module: str, node: ast.AST) -> None:
        """Put marks into the lists of statements that hang at this node."""
        for name in ("body", "orelse", "finalbody"):
            statements = getattr(node, name, None)
            if isinstance(statements, list):
                marked = [
                    part
                    for statement in statements
                    for part in (self._new(Mark(module, statement.lineno, "")), statement)
                ]
                setattr(node, name, marked)
        if isinstance(node, (ast.If, ast.While, ast.For)):
            node.body.insert(0, self._new(Mark(module, node.lineno, "true")))
            node.orelse.insert(0, self._new(Mark(module, node.lineno, "false")))

    def _new(self, place: Mark) -> ast.stmt:
        self.places.append(place)
        return ast.parse(f"{_MARKS}[{len(self.places) - 1}] = 1").body[0]


class _Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds modules whose code is at hand."""

    def __init__(self, codes: dict[str, CodeType], names: dict[str, object]) -> None:
        self._codes = {MODULES[module]: code for module, code in codes.items()}
        self._names = names

    def find_spec(
        self, fullname: str, path: object, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if fullname not in self._codes:
            return None
        return importlib.machinery.ModuleSpec(fullname, self)

    def exec_module(self, module: ModuleType) -> None:
        vars(module).update(self._names)
        exec(self._codes[module.__name__], vars(module))


def serve(codes: dict[str, CodeType], names: dict[str, object]) -> None:
    """Import these codes instead of the modules' files; `names` are in their namespace.

    Forgets what was imported of the firmware: called in a forked process only, before its tests.
    """
    for name in [name for name in sys.modules if name.partition(".")[0] == "gazeboard"]:
        del sys.modules[name]
    sys.meta_path.insert(0, _Finder(codes, names))


def statements(module: str) -> Iterator[int]:
    """The first lines of the module's statements."""
    for node in ast.walk(ast.parse(source_of(module))):
        if isinstance(node, ast.stmt):
            yield node.lineno
