"""What a comment or a docstring tells its reader to see is there."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
# At the beginning of a sentence or after a semicolon or a bracket: an order to the reader.
SEE = re.compile(r"(?:^|[.;:(]\s*|but )[Ss]ee (?:also )?`?([\w./-]+)")
ENGLISH = {"the"}


@cache
def sources() -> tuple[Path, ...]:
    folders = ("firmware", "protocol", "host", "tools", "tests", "web")
    return tuple(path for one in folders for path in sorted((ROOT / one).rglob("*.py")))


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


@cache
def defined() -> dict[str, set[str]]:
    """Names by the module or the class that defines them; a package holds its modules."""
    found: dict[str, set[str]] = defaultdict(set)
    for path in sources():
        stem = path.parent.name if path.name == "__init__.py" else path.stem
        found[path.parent.parent.name if path.name == "__init__.py" else path.parent.name].add(stem)
        _define(tree(path).body, (stem,), found)
    return found


def _define(body: list[ast.stmt], owners: tuple[str, ...], found: dict[str, set[str]]) -> None:
    for statement in body:
        if isinstance(statement, ast.ClassDef):
            names = {statement.name}
            _define(statement.body, (owners[0], statement.name), found)
        else:
            names = {name for one in ast.walk(statement) for name in _set(one)}
        for owner in owners:
            found[owner] |= names


def _set(node: ast.AST) -> Iterator[str]:
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        yield node.name
    elif isinstance(node, ast.arg):
        yield node.arg
    elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
        yield node.id if isinstance(node, ast.Name) else node.attr


def texts(path: Path) -> Iterator[str]:
    """Its docstrings and other strings that are statements, and its blocks of comments."""
    source = path.read_text()
    if not re.search(r"\b[Ss]ee\b", source):
        return
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            yield " ".join(str(node.value.value).split())
    block, row = "", -2
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            if token.start[0] != row + 1:
                yield block
                block = ""
            block, row = f"{block} {token.string.lstrip('# ')}".strip(), token.start[0]
    yield block


def is_there(name: str, beside: Path) -> bool:
    name = name.strip(".")
    if "/" in name or name.endswith((".py", ".js", ".md")):
        return any((one / name).exists() for one in (beside, ROOT)) or any(
            path.as_posix().endswith(f"/{name}") for path in sources()
        )
    *owners, last = name.split(".")
    if not owners:
        return last in defined() or any(last in names for names in defined().values())
    return last in defined().get(owners[-1], set())


def test_what_a_reader_is_told_to_see_is_there() -> None:
    told = {
        (path.relative_to(ROOT).as_posix(), name)
        for path in sources()
        for text in texts(path)
        for name in SEE.findall(text)
        if name not in ENGLISH
    }
    assert len(told) > 80
    assert [one for one in sorted(told) if not is_there(one[1], (ROOT / one[0]).parent)] == []


def test_a_name_that_has_moved_is_not_there() -> None:
    here = ROOT / "host" / "gazechair"
    for name in ("seen.Seen", "Seen.heading_off_deg", "orders", "candidate.py", "_Side.holding"):
        assert is_there(name, here), name
    for name in ("doubts.Seen", "link_orders", "Seen.no_such", "docs/nothing.md", "nothing.py"):
        assert not is_there(name, here), name
