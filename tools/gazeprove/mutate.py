"""Makes mutants of a module: one small change each to its syntax tree."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator
from dataclasses import dataclass

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


@dataclass(frozen=True)
class Mutant:
    """One changed module. `where` is its function, `change` the line before and after."""

    where: str
    line: int
    change: str
    tree: ast.Module

    @property
    def key(self) -> tuple[str, str]:
        """What a list of equivalent mutants knows it by: independent of line numbers."""
        return (self.where, self.change)


def mutants(source: str) -> Iterator[Mutant]:
    """Every mutant of a module's source, in the order of its text. Equal ones come once."""
    tree = ast.parse(source)
    places = _functions(tree)
    seen = {ast.dump(tree)}
    for index, node in enumerate(ast.walk(tree)):
        for variant in range(len(_variants(node))):
            changed = copy.deepcopy(tree)
            target = _nth(changed, index)
            parent = _statement_of(changed, target)
            before = _line(parent)
            replacement = _variants(target)[variant]
            _replace(changed, target, replacement)
            ast.fix_missing_locations(changed)
            dump = ast.dump(changed)
            if dump in seen:
                continue
            seen.add(dump)
            after = _line(replacement) if target is parent else _line(parent)
            line = getattr(parent, "lineno", 0)
            yield Mutant(places.get(line, "module"), line, f"{before}  ->  {after}", changed)


def _variants(node: ast.AST) -> list[ast.AST]:
    """What `node` may become."""
    made: list[ast.AST] = []
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        for operator in _COMPARED.get(type(node.ops[0]), ())[: 1 if _has_no_order(node) else None]:
            made.append(_with(node, ops=[operator()]))
    elif isinstance(node, ast.BoolOp):
        made.append(_with(node, op=ast.Or() if isinstance(node.op, ast.And) else ast.And()))
        made += node.values
    elif isinstance(node, ast.UnaryOp):
        made.append(node.operand)
    elif isinstance(node, ast.BinOp):
        if type(node.op) in _COMPUTED:
            made.append(_with(node, op=_COMPUTED[type(node.op)]()))
        made += [node.left, node.right]
    elif isinstance(node, ast.IfExp):
        made += [node.body, node.orelse]
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


def _with(node: ast.AST, **fields: object) -> ast.AST:
    made = copy.copy(node)
    for name, value in fields.items():
        setattr(made, name, value)
    return made


def _nth(tree: ast.AST, index: int) -> ast.AST:
    for k, node in enumerate(ast.walk(tree)):
        if k == index:
            return node
    raise IndexError(index)


def _replace(tree: ast.AST, target: ast.AST, replacement: ast.AST) -> None:
    for node in ast.walk(tree):
        for name, value in ast.iter_fields(node):
            if value is target:
                setattr(node, name, replacement)
                return
            if isinstance(value, list):
                for k, item in enumerate(value):
                    if item is target:
                        value[k] = replacement
                        return
    raise ValueError("the node is not in the tree")


def _statement_of(tree: ast.AST, target: ast.AST) -> ast.stmt:
    """The innermost statement that holds `target`."""
    found: ast.stmt | None = None
    for node in ast.walk(tree):
        if isinstance(node, ast.stmt) and any(inner is target for inner in ast.walk(node)):
            found = node  # ast.walk goes outside in: the last one is the innermost
    assert found is not None
    return found


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
