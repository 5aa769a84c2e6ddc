"""Replaces table numbers by their values in the firmware's source, as a compiler would.

The board needs longer to look a number up in its module than for most operations with it: without
the look-ups the tick runs a tenth fewer instructions.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Iterator, Mapping

from gazechair.service.flash.spans import Span, is_native, place, replaced

# Name in the code -> path of the module: plain numbers only, written as NAME = 1 or const(1).
_TABLES = {"codes": "gazelink/codes.py", "limits": "gazeboard/core/limits.py"}
_ROW = re.compile(r"^([A-Z][A-Z0-9_]*) = (?:const\((\d+)\)|(\d+))(?:\s*#.*)?$", re.MULTILINE)
_NAME = re.compile(r"_?[A-Z][A-Z0-9_]*")
_OPERATORS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.FloorDiv: operator.floordiv,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitOr: operator.or_,
    ast.BitAnd: operator.and_,
}
_SMALL = 1 << 30  # integers of the board beyond this need memory


def put_in(texts: Mapping[str, str]) -> dict[str, str]:
    """The same texts {path: text}, `codes.NAME` and `limits.NAME` replaced by their numbers."""
    numbers = {
        f"{name}.{row[1]}": row[2] or row[3]
        for name, path in _TABLES.items()
        for row in _ROW.finditer(texts.get(path, ""))
    }
    used = re.compile(rf"(?<![\w.])(?:{'|'.join(_TABLES)})\.[A-Z][A-Z0-9_]*\b")
    plain = {
        path: used.sub(lambda match: numbers.get(match[0], match[0]), text)
        for path, text in texts.items()
    }
    return _with_values(plain)


# -- numbers that modules work out from others -------------------------------------------------


def _with_values(texts: Mapping[str, str]) -> dict[str, str]:
    """The same texts, in their native functions each NAME of a number replaced by it."""
    modules = {
        path.removesuffix(".py").replace("/", "."): ast.parse(text) for path, text in texts.items()
    }
    values: dict[str, dict[str, int]] = {name: {} for name in modules}
    found = -1
    while found < (found := sum(map(len, values.values()))):  # one builds on the other
        for name, module in modules.items():
            values[name] |= _values(module, values)
    return {
        path: replaced(text, list(_uses(module, text, values[name])))
        for (path, text), (name, module) in zip(texts.items(), modules.items(), strict=True)
    }


def _values(module: ast.Module, values: Mapping[str, Mapping[str, int]]) -> dict[str, int]:
    """{NAME, or module.NAME} that the module assigns, or imports, once and for all."""
    stored = [
        node.id
        for node in ast.walk(module)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    ]
    known: dict[str, int] = {}
    for node in module.body:
        if isinstance(node, ast.ImportFrom):
            for name in node.names:
                there = name.asname or name.name
                value = values.get(node.module or "", {}).get(name.name)
                if value is not None and there not in stored and _NAME.fullmatch(there):
                    known[there] = value
                of_module = values.get(f"{node.module}.{name.name}", {})
                known |= {f"{there}.{each}": of_module[each] for each in of_module}
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            target = node.targets[0].id
            number = _number(node.value, known)
            if number is not None and stored.count(target) == 1 and _NAME.fullmatch(target):
                known[target] = number
    return known


def _number(node: ast.expr, known: Mapping[str, int]) -> int | None:
    """Its value, None if the value is not a number known in advance."""
    if isinstance(node, ast.Constant) and type(node.value) is int:
        return node.value
    if isinstance(node, (ast.Name, ast.Attribute)):
        return known.get(ast.unparse(node))
    if isinstance(node, ast.Call) and ast.unparse(node.func) == "const":
        return _number(node.args[0], known)
    if isinstance(node, ast.UnaryOp):
        operand = _number(node.operand, known)
        if operand is not None and isinstance(node.op, (ast.USub, ast.Invert)):
            return -operand if isinstance(node.op, ast.USub) else ~operand
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        left, right = _number(node.left, known), _number(node.right, known)
        if left is not None and right is not None:
            return int(_OPERATORS[type(node.op)](left, right))
    return None


def _uses(module: ast.Module, text: str, known: Mapping[str, int]) -> Iterator[Span]:
    for function in ast.walk(module):
        if not isinstance(function, ast.FunctionDef) or not is_native(function):
            continue
        for node in ast.walk(function):
            if not isinstance(node, (ast.Name, ast.Attribute)):
                continue
            number = known.get(ast.unparse(node))
            if number is not None and -_SMALL <= number < _SMALL:
                by = f"({number})" if number < 0 else str(number)
                start = place(text, node.lineno, node.col_offset)
                yield Span(start, place(text, node.end_lineno, node.end_col_offset), by)
