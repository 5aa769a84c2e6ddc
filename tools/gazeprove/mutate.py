"""Makes mutants of a module: one small change each to its syntax tree."""

from __future__ import annotations

import ast
import copy
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from types import CodeType
from typing import TypeVar

_COMPARED: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Eq: (ast.NotEq, ast.LtE, ast.GtE),
    ast.NotEq: (ast.Eq, ast.Lt, ast.Gt),
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
}
_COMPUTED: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.FloorDiv,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
}
_SWAPPED = {"min": "max", "max": "min"}
_NAMED_NUMBERS = ("codes", "limits")  # modules whose attributes are numbers

_Node = TypeVar("_Node", bound=ast.AST)


@dataclass(frozen=True)
class Mutant:
    """One changed module. `where` is its function, `change` the line before and after."""

    where: str
    number: int  # among those of `where`
    line: int
    change: str
    path: tuple[str, ...]  # to the function that `code` is for; (): the whole module's
    code: CodeType

    @property
    def key(self) -> tuple[str, str]:
        """What a list of equivalent mutants knows it by: independent of line numbers."""
        return (self.where, self.change)


def mutants(source: str, every: int = 1, first: int = 0) -> Iterator[Mutant]:
    """One in `every` mutants of a module's source from number `first` on, compiled."""
    of: Counter[str] = Counter()
    for number, change in enumerate(changes(source)):
        where = change.where
        if number % every == first:
            code = _code_of(change.tree, change.path)
            yield Mutant(where, of[where], change.line, change.text, change.path, code)
        of[where] += 1


def unchanged(source: str) -> Mutant:
    """The module as it is: what no test may kill."""
    return Mutant("module", -1, 0, "nothing", (), compile(source, "unchanged", "exec"))


def keys(source: str) -> set[tuple[str, str]]:
    """The keys of all mutants of a module's source."""
    return {(change.where, change.text) for change in changes(source)}


@dataclass(frozen=True)
class Change:
    """One change: `tree` is the changed module's until the next change is asked for."""

    where: str
    line: int
    text: str
    path: tuple[str, ...]
    tree: ast.Module


def changes(source: str) -> Iterator[Change]:
    """Every change to a module. Of those that read the same only the first."""
    tree = ast.parse(source)
    places = _places(tree)
    functions = _functions(tree)
    seen: set[tuple[int, str]] = set()
    alike: dict[tuple[str, str], int] = {}  # where a function has the same line twice
    for node in list(ast.walk(tree)):
        if not isinstance(node, (ast.expr, ast.stmt)):
            continue
        statement = _statement_of(node, places)
        before = _line(statement)
        for variant in _variants(node):
            ast.fix_missing_locations(ast.copy_location(variant, node))
            places[node].put(variant)
            after = _line(variant if node is statement else statement)
            line = statement.lineno
            if after != before and (line, after) not in seen:
                seen.add((line, after))
                where = functions.get(line, "module")
                text = f"{before}  ->  {after}"
                count = alike[where, text] = alike.get((where, text), 0) + 1
                text += f"  ({count})" if count > 1 else ""
                yield Change(where, line, text, _path(statement, places), tree)
            places[node].put(node)


def _path(statement: ast.stmt, places: dict[ast.AST, _Place]) -> tuple[str, ...]:
    """Names of the class, if any, and the outermost function in whose body the statement is.

    (): it is in none, or it is a function's own head, which runs when the module is loaded.
    """
    names: list[str] = []
    node: ast.AST = statement
    while not isinstance(node, ast.Module):
        parent = places[node].parent
        if isinstance(parent, ast.FunctionDef) and places[node].field == "body":
            names = [parent.name]
        elif isinstance(parent, ast.ClassDef) and names:
            names = [parent.name, *names]
        node = parent
    return tuple(names)


def _code_of(tree: ast.Module, path: tuple[str, ...]) -> CodeType:
    """The code of the function at `path`, compiled without the rest of the module."""
    if not path:
        return compile(tree, "mutant", "exec")
    scope: ast.AST = tree
    for name in path:
        assert isinstance(scope, (ast.Module, ast.ClassDef))
        kinds = (ast.ClassDef, ast.FunctionDef)
        scope = next(node for node in scope.body if isinstance(node, kinds) and node.name == name)
    assert isinstance(scope, ast.FunctionDef)
    code = compile(ast.Module([_with(scope, decorator_list=[])], []), "mutant", "exec")
    return next(part for part in code.co_consts if isinstance(part, CodeType))


@dataclass(frozen=True)
class _Place:
    """Where a node hangs in the tree."""

    parent: ast.AST
    field: str
    index: int | None

    def put(self, node: ast.AST) -> None:
        if self.index is None:
            setattr(self.parent, self.field, node)
        else:
            getattr(self.parent, self.field)[self.index] = node


def _places(tree: ast.Module) -> dict[ast.AST, _Place]:
    places: dict[ast.AST, _Place] = {}
    for parent in ast.walk(tree):
        for field, value in ast.iter_fields(parent):
            if isinstance(value, ast.AST):
                places[value] = _Place(parent, field, None)
            elif isinstance(value, list):
                for index, item in enumerate(value):
                    if isinstance(item, ast.AST):
                        places[item] = _Place(parent, field, index)
    return places


def _statement_of(node: ast.AST, places: dict[ast.AST, _Place]) -> ast.stmt:
    """The innermost statement that holds `node`."""
    while not isinstance(node, ast.stmt):
        node = places[node].parent
    return node


def _variants(node: ast.AST) -> list[ast.AST]:
    """What `node` may become."""
    made: list[ast.AST] = []
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        for operator in _COMPARED.get(type(node.ops[0]), ())[: 1 if _has_no_order(node) else None]:
            made.append(_with(node, ops=[operator()]))
    elif isinstance(node, ast.BoolOp):
        made.append(_with(node, op=ast.Or() if isinstance(node.op, ast.And) else ast.And()))
        made += map(copy.copy, node.values)
    elif isinstance(node, ast.UnaryOp):
        made.append(copy.copy(node.operand))
    elif isinstance(node, ast.BinOp):
        if type(node.op) in _COMPUTED:
            made.append(_with(node, op=_COMPUTED[type(node.op)]()))
        made += [copy.copy(node.left), copy.copy(node.right)]
    elif isinstance(node, ast.IfExp):
        made += [copy.copy(node.body), copy.copy(node.orelse)]
    elif isinstance(node, ast.Constant) and type(node.value) is bool:
        made.append(ast.Constant(not node.value))
    elif isinstance(node, ast.Constant) and type(node.value) is int:
        made += [ast.Constant(node.value + 1), ast.Constant(node.value - 1)]
    elif isinstance(node, ast.Attribute) and _is_number(node):
        one = ast.Constant(1)
        made += [ast.BinOp(node, ast.Add(), one), ast.BinOp(node, ast.Sub(), one)]
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        if node.func.id in _SWAPPED:
            made.append(_with(node, func=ast.Name(_SWAPPED[node.func.id], ast.Load())))
    elif isinstance(node, ast.If):
        made += [_with(node, test=ast.Constant(value)) for value in (True, False)]
    elif isinstance(node, (ast.Assign, ast.AugAssign, ast.Expr)) or (
        isinstance(node, ast.Return) and node.value is None
    ):
        made.append(ast.Pass())
    elif isinstance(node, ast.Return):
        made.append(ast.Return(ast.Constant(None)))
    return made


def _has_no_order(node: ast.Compare) -> bool:
    """Compared for being the same with a code, or with the 0 below which nothing here goes."""
    right = node.comparators[0]
    if not isinstance(node.ops[0], (ast.Eq, ast.NotEq)):
        return False
    code = isinstance(right, ast.Attribute) and ast.unparse(right).startswith("codes.")
    return code or (isinstance(right, ast.Constant) and right.value == 0)


def _is_number(node: ast.Attribute) -> bool:
    return (
        isinstance(node.value, ast.Name)
        and node.value.id in _NAMED_NUMBERS
        and node.attr.isupper()
        and node.attr not in ("FAULTS",)
    )


def _with(node: _Node, **fields: object) -> _Node:
    made = copy.copy(node)
    for name, value in fields.items():
        setattr(made, name, value)
    return made


def _line(node: ast.AST) -> str:
    """A statement's own line: of a compound one, its head."""
    return ast.unparse(node).splitlines()[0].strip()


def _functions(tree: ast.Module) -> dict[int, str]:
    """Name of the function each line belongs to."""
    places: dict[int, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            for line in range(node.lineno, (node.end_lineno or node.lineno) + 1):
                places[line] = node.name
    return places
