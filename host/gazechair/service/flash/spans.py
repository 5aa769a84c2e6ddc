"""Spans of source text to be replaced, and the functions that the board compiles."""

from __future__ import annotations

import ast
from dataclasses import dataclass

_DECORATORS = ("native", "viper")


@dataclass(frozen=True)
class Span:
    """Bytes to replace."""

    start: int
    end: int
    by: str


def compiled(function: ast.FunctionDef, also_plain: bool = False) -> bool:
    """Whether it is native or viper; `also_plain`: or has no decorator."""
    names = [node.attr for node in function.decorator_list if isinstance(node, ast.Attribute)]
    if not function.decorator_list:
        return also_plain
    return len(names) == len(function.decorator_list) == 1 and names[0] in _DECORATORS


def is_native(node: ast.FunctionDef) -> bool:
    """Machine code that works on objects: viper's numbers are others."""
    return compiled(node) and not any(
        isinstance(name, ast.Attribute) and name.attr == "viper" for name in node.decorator_list
    )


def place(text: str, line: int | None, column: int | None) -> int:
    """Byte offset of a place that ast names."""
    assert line is not None
    assert column is not None
    lines = text.encode().split(b"\n")
    return sum(len(each) + 1 for each in lines[: line - 1]) + column


def replaced(text: str, spans: list[Span]) -> str:
    """Innermost spans first; the enclosing ones follow in the next round."""
    data = text.encode()
    inner = [
        span
        for span in spans
        if not any(
            other is not span and span.start <= other.start and other.end <= span.end
            for other in spans
        )
    ]
    for span in sorted(inner, key=lambda span: span.start, reverse=True):
        data = data[: span.start] + span.by.encode() + data[span.end :]
    return data.decode()
