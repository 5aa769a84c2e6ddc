"""What a part of the proof depends on: the files that its modules import, and theirs."""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path

from gazesetup import ROOT

# Where imports are looked for; what is found nowhere here is no part of what is proven.
_ROOTS = tuple(
    ROOT / name for name in ("firmware", "protocol", "host", "tools", "tests", "tests/firmware")
)
_NOT_PROVEN = ("gazesetup",)  # sets the machine up


def digests(first: Iterable[Path]) -> dict[str, str]:
    """The digest of each of these files and of all they import, by its path below ROOT."""
    todo = list(first)
    found: dict[str, str] = {}
    while todo:
        file = todo.pop()
        name = str(file.relative_to(ROOT))
        if name not in found:
            text = file.read_bytes()
            found[name] = hashlib.sha256(text).hexdigest()[:16]
            if file.suffix == ".py":
                todo += _imported(text)
    return dict(sorted(found.items()))


def digest_of(files: dict[str, str]) -> str:
    """One digest of all of them."""
    text = "".join(f"{name} {digest}\n" for name, digest in sorted(files.items()))
    return hashlib.sha256(text.encode()).hexdigest()


@functools.cache
def _imported(text: bytes) -> tuple[Path, ...]:
    """The files of the modules that a module's text imports, and of their packages."""
    return tuple(
        path
        for name in _names(ast.parse(text))
        if name.partition(".")[0] not in _NOT_PROVEN
        for path in _files(name)
    )


def _names(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _files(name: str) -> Iterator[Path]:
    """The file of a module and the packages that it is in."""
    for root in _ROOTS:
        path = root
        for part in name.split("."):
            path = path / part
            for file in (path.with_suffix(".py"), path / "__init__.py"):
                if file.is_file():
                    yield file
