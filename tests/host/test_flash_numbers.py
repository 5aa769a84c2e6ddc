"""Numbers of the tables in the flashed texts: each is what the module says, and nothing else."""

from __future__ import annotations

import ast
from types import ModuleType

from gazeboard import limits
from gazechair.flash import numbers, tree
from gazelink import codes

TEXTS = {
    "gazelink/codes.py": "STOP = 0\nDIR_LEFT = 2  # bit\nVERBS = ('stop',)\n",
    "gazeboard/limits.py": "WAIT_MS = const(300)  # P3\nTWICE = 2 * WAIT_MS\n",
}


def put_in(text: str) -> str:
    return numbers.put_in({**TEXTS, "gazeboard/other.py": text})["gazeboard/other.py"]


def test_numbers_take_the_place_of_their_names() -> None:
    assert put_in("if a == codes.DIR_LEFT + limits.WAIT_MS:") == "if a == 2 + 300:"


def test_what_is_no_plain_number_stays() -> None:
    for text in (
        "codes.VERBS",
        "limits.TWICE",
        "codes.reason_name(3)",
        "my.codes.STOP",
        "xcodes.STOP",
    ):
        assert put_in(text) == text


def test_the_whole_firmware_means_the_same() -> None:
    modules: dict[str, ModuleType] = {"codes": codes, "limits": limits}
    sources = tree.find_sources()
    put = 0

    class Put(ast.NodeTransformer):
        """Puts the numbers in by the syntax tree, wherever the text has none of the name left."""

        def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
            nonlocal put
            name = ast.unparse(node)
            if name.split(".")[0] not in modules or name in text:
                return self.generic_visit(node)
            put += 1
            return ast.Constant(getattr(modules[name.split(".")[0]], node.attr))

    texts = numbers.put_in({path: file.read_text() for path, file in sources.files.items()})
    for path, text in texts.items():
        tree_before = Put().visit(ast.parse(sources.files[path].read_text()))
        assert ast.dump(tree_before) == ast.dump(ast.parse(text)), path
    assert put > 200
