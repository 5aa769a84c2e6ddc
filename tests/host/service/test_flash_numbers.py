"""Numbers of the tables in the flashed texts: each is what the module says, and nothing else."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path
from types import ModuleType

from gazechair.service.flash import numbers, tree

TEXTS = {
    "gazelink/codes.py": "STOP = 0\nDIR_LEFT = 2  # bit\nVERBS = ('stop',)\n",
    "gazeboard/core/limits.py": "WAIT_MS = const(300)  # P3\nTWICE = 2 * WAIT_MS\n",
}


def put_in(text: str) -> str:
    return numbers.put_in({**TEXTS, "gazeboard/other.py": text})["gazeboard/other.py"]


def test_numbers_take_the_place_of_their_names() -> None:
    assert put_in("a = codes.DIR_LEFT + limits.WAIT_MS") == "a = 2 + 300"


def test_what_is_no_plain_number_stays() -> None:
    for text in (
        "codes.VERBS",
        "limits.TWICE",
        "codes.reason_name(3)",
        "my.codes.STOP",
        "xcodes.STOP",
    ):
        assert put_in(text) == text


def test_numbers_worked_out_from_others_take_it_in_machine_code() -> None:
    """Where they are assigned once; in a native function, because viper's numbers are others."""
    text = """
from gazeboard.core.limits import TWICE
from gazeboard.core import limits
_MOST = TWICE + limits.WAIT_MS
_LEAST = ~(1 << 4)
_MANY = 1
_MANY += 1
_HUGE = 1 << 30
@micropython.native
def f(a):
    return a + _MOST + _LEAST + TWICE + limits.TWICE + _MANY + _HUGE
@micropython.viper
def g(a: int) -> int:
    return a + int(_MOST)
"""
    short = put_in(text)
    assert "return a + 900 + (-17) + 600 + 600 + _MANY + _HUGE\n" in short
    assert "return a + int(_MOST)\n" in short


def test_the_whole_firmware_means_the_same() -> None:
    """Each number in a text is what its name is worth where the module is imported."""
    sources = tree.find_sources()
    put = 0

    class Value(ast.NodeTransformer):
        """Each NAME and module.NAME of a number becomes the number."""

        def __init__(self, module: ModuleType) -> None:
            self._module = module

        def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
            if isinstance(node.value, ast.Name):
                owner = getattr(self._module, node.value.id, None)
                if isinstance(owner, ModuleType):
                    return self._number(node, getattr(owner, node.attr, None))
            return self.generic_visit(node)

        def visit_Name(self, node: ast.Name) -> ast.AST:
            return self._number(node, getattr(self._module, node.id, None))

        def _number(self, node: ast.Name | ast.Attribute, value: object) -> ast.AST:
            nonlocal put
            if type(value) is not int or not isinstance(node.ctx, ast.Load):
                return node
            put += 1
            number = ast.Constant(abs(value))
            return number if value >= 0 else ast.UnaryOp(ast.USub(), number)

    texts = numbers.put_in({path: file.read_text() for path, file in sources.files.items()})
    for path, text in texts.items():
        if "teensy40" in path or "board" in Path(path).stem:
            assert text.count("codes.") == 0
            continue
        module = importlib.import_module(path.removesuffix(".py").replace("/", "."))
        before = Value(module).visit(ast.parse(sources.files[path].read_text()))
        names = put
        after = Value(module).visit(ast.parse(text))
        put = names  # what the text still names is not counted
        assert ast.dump(before) == ast.dump(after), path
    assert put > 400
