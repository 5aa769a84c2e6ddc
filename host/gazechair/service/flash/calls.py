"""Optimises method calls in the firmware's source, as a compiler would.

On the board a method is looked up by name at each call: first among the attributes of the object,
then in its class. That takes longer than the call. So this resolves what it can in advance:

- `self._method(...)`, where no other class inherits it, becomes a call of the plain function;
- functions of one expression, `min`, `max` and `abs` become that expression.

Lines keep their numbers. Nothing is changed where it could alter the meaning of the code.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping

from gazechair.service.flash.spans import Span, compiled, is_native, place, replaced

_BUILTINS = {
    "min": "def min(a, b):\n return a if a < b else b",
    "max": "def max(a, b):\n return a if a > b else b",
    "abs": "def abs(a):\n return a if a >= 0 else -a",
}
_ROUNDS = 20  # calls within calls: far more than there are


def shorten(texts: Mapping[str, str]) -> dict[str, str]:
    """The same texts {path: text}, their calls made short.

    Only functions compiled to machine code (`native`, `viper`) are touched: those that count.
    """
    modules = {path: ast.parse(text) for path, text in texts.items()}
    parents = {
        base.id if isinstance(base, ast.Name) else getattr(base, "attr", "")
        for module in modules.values()
        for node in ast.walk(module)
        if isinstance(node, ast.ClassDef)
        for base in node.bases
    }
    expressions = {
        path.removesuffix(".py").replace("/", "."): _expressions(module)
        for path, module in modules.items()
    }
    return {path: _shortened(text, parents, expressions) for path, text in texts.items()}


def _shortened(
    text: str, parents: set[str], expressions: Mapping[str, Mapping[str, ast.FunctionDef]]
) -> str:
    aliases: dict[str, str] = {}
    for _ in range(_ROUNDS):
        module = ast.parse(text)
        inline = _builtins_of(module) | _expressions(module)
        for node in module.body:
            if isinstance(node, ast.ImportFrom) and (node.module or "") in expressions:
                known = expressions[node.module or ""]
                for name in node.names:
                    if name.name in known:
                        inline[name.asname or name.name] = known[name.name]
        spans = [*_methods(module, text, parents, aliases), *_inlined(module, text, inline)]
        if not spans:
            break
        text = replaced(text, spans)
    if not aliases:
        return text
    # Names that a module has first are found first: the comment in line 1 makes room for these.
    first, *others = text.rstrip("\n").split("\n")
    if first.startswith("#"):
        first = " = ".join([*aliases, "None"])
    lines = [f"{name} = {method}" for name, method in aliases.items()]
    return "\n".join([first, *others, *lines, ""])


# -- methods -----------------------------------------------------------------------------------


def _methods(
    module: ast.Module, text: str, parents: set[str], aliases: dict[str, str]
) -> Iterator[Span]:
    """`self._method(` -> `_Class_method(self, `; what each such name stands for into `aliases`."""
    set_somewhere = {
        node.attr
        for node in ast.walk(module)
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
    }
    for made in module.body:
        if not isinstance(made, ast.ClassDef) or made.bases or made.name in parents:
            continue
        plain = {
            node.name
            for node in made.body
            if isinstance(node, ast.FunctionDef)
            and node.name.startswith("_")
            and not node.name.startswith("__")
            and node.name not in set_somewhere
            and compiled(node, also_plain=True)
        }
        for function in made.body:
            if not isinstance(function, ast.FunctionDef) or not compiled(function):
                continue
            me = function.args.args[0].arg if function.args.args else ""
            if me in _assigned(function):
                continue
            for call in ast.walk(function):
                if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Attribute):
                    continue
                of = call.func.value
                if not isinstance(of, ast.Name) or of.id != me or call.func.attr not in plain:
                    continue
                name = f"_{made.name}{call.func.attr}"
                aliases[name] = f"{made.name}.{call.func.attr}"
                start = place(text, call.func.lineno, call.func.col_offset)
                end = place(text, call.func.end_lineno, call.func.end_col_offset)
                opened = text.encode().index(b"(", end) + 1
                yield Span(start, opened, f"{name}({me}" + (", " if call.args else ""))


def _assigned(function: ast.FunctionDef) -> set[str]:
    return {
        node.id
        for node in ast.walk(function)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    }


# -- functions of one expression ---------------------------------------------------------------


def _expressions(module: ast.Module) -> dict[str, ast.FunctionDef]:
    """The module's native functions that only return an expression of their words and numbers."""
    found = {}
    for node in module.body:
        if not isinstance(node, ast.FunctionDef) or not is_native(node) or len(node.body) != 1:
            continue
        words = {word.arg for word in node.args.args}
        last = node.body[0]
        if not isinstance(last, ast.Return) or last.value is None or node.args.defaults:
            continue
        if all(_is_arithmetic(part, words) for part in ast.walk(last.value)):
            found[node.name] = node
    return found


def _is_arithmetic(part: ast.AST, words: set[str]) -> bool:
    if isinstance(part, ast.Name):
        return part.id in words
    kinds = (ast.Constant, ast.BinOp, ast.UnaryOp, ast.Compare, ast.IfExp, ast.operator)
    return isinstance(part, (*kinds, ast.unaryop, ast.cmpop, ast.expr_context))


def _builtins_of(module: ast.Module) -> dict[str, ast.FunctionDef]:
    """min, max and abs, unless the module gives these names another meaning."""
    taken = {
        getattr(node, "id", getattr(node, "name", ""))
        for node in ast.walk(module)
        if isinstance(node, (ast.FunctionDef, ast.ClassDef))
        or (isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store))
    }
    found = {}
    for name, text in _BUILTINS.items():
        function = ast.parse(text).body[0]
        assert isinstance(function, ast.FunctionDef)
        if name not in taken:
            found[name] = function
    return found


def _inlined(
    module: ast.Module, text: str, inline: Mapping[str, ast.FunctionDef]
) -> Iterator[Span]:
    for function in ast.walk(module):
        if not isinstance(function, ast.FunctionDef) or not is_native(function):
            continue
        if any(isinstance(node, (ast.FunctionDef, ast.Lambda)) for node in function.body):
            continue
        for call in ast.walk(function):
            if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Name):
                continue
            target = inline.get(call.func.id)
            if target is None or call.keywords or call.lineno != call.end_lineno:
                continue
            by = _expression(target, call.args)
            if by is not None:
                start = place(text, call.lineno, call.col_offset)
                yield Span(start, place(text, call.end_lineno, call.end_col_offset), f"({by})")


def _expression(target: ast.FunctionDef, args: list[ast.expr]) -> str | None:
    """The target's expression with these words, or None where one would be worked out twice, not
    at all, or in another order."""
    words = [word.arg for word in target.args.args]
    if len(words) != len(args) or any(isinstance(arg, ast.Starred) for arg in args):
        return None
    last = target.body[0]
    assert isinstance(last, ast.Return)
    assert last.value is not None
    uses = [node.id for node in ast.walk(last.value) if isinstance(node, ast.Name)]
    branches = any(isinstance(node, ast.IfExp) for node in ast.walk(last.value))
    for word, arg in zip(words, args, strict=True):
        if not _is_simple(arg) and (branches or uses.count(word) != 1 or len(args) > 1):
            return None
    given = dict(zip(words, args, strict=True))

    class Put(ast.NodeTransformer):
        def visit_Name(self, node: ast.Name) -> ast.AST:
            return given[node.id]

    return ast.unparse(Put().visit(ast.parse(ast.unparse(last.value), mode="eval")))


def _is_simple(arg: ast.expr) -> bool:
    """A number, a local name, or an attribute of one: reading it twice reads the same, because
    nothing interrupts the tick."""
    if isinstance(arg, ast.UnaryOp) and isinstance(arg.op, ast.USub):
        return _is_simple(arg.operand)
    if isinstance(arg, ast.Attribute):
        return isinstance(arg.value, ast.Name)
    return isinstance(arg, (ast.Constant, ast.Name))
