"""Writes docs/numbers.md: every limit, setting and timing, who uses it and which tests name it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from gazelink.settings_table import PROFILE_ROWS, PROFILES, TABLE
from gazesetup import ROOT

DOCUMENT = ROOT / "docs" / "numbers.md"
_LIMITS = ROOT / "firmware" / "gazeboard" / "core" / "limits.py"
_SETTINGS = ROOT / "protocol" / "gazelink" / "settings_table.py"
_TIMED = re.compile(r"_?[A-Z][A-Z0-9_]*_(?:S|MS|US|HZ|M|MM|DEG|BYTES)")
_SCRIPT = re.compile(
    r"^(?:export )?const ([A-Z][A-Z0-9_]*_(?:MS|S|PX)) = ([\d_.]+|\[[\d_., ]+\]);(?: // (.*))?$"
)
_GENERAL = len(TABLE) - len(PROFILES) * len(PROFILE_ROWS)

_HEAD = """# Numbers

Every limit, setting and timing of the product: its meaning, who uses it, which tests name it.
Generated from the code by `tools/docs`; a test compares. A number has one home: the numbers behind
the promises are compiled into the board (`limits`), those that an installation may choose are
settings of the board, and the others are in the code that uses them."""


@dataclass(frozen=True)
class Number:
    """One named number: its value as written, its comment, and the file it lives in."""

    name: str
    value: str
    meaning: str
    file: Path


def limits() -> list[Number]:
    """The limits compiled into the board."""
    return list(_named(_LIMITS, re.compile(r"[A-Z][A-Z0-9_]*")))


def host_timings() -> list[Number]:
    """Numbers with a unit in their name in the host's modules."""
    files = sorted((ROOT / "host" / "gazechair").rglob("*.py"))
    return [number for file in files for number in _named(file, _TIMED)]


def page_timings() -> list[Number]:
    """The same in the pages' scripts."""
    found = []
    for file in sorted((ROOT / "web").glob("*.js")):
        for line in file.read_text().splitlines():
            if match := _SCRIPT.match(line):
                found.append(Number(match[1], match[2], match[3] or "", file))
    return found


def _named(file: Path, pattern: re.Pattern[str]) -> Iterator[Number]:
    lines = file.read_text().splitlines()
    for node in ast.parse("\n".join(lines)).body:
        if not isinstance(node, ast.Assign) or not isinstance(node.targets[0], ast.Name):
            continue
        name, value = node.targets[0].id, _value(node.value)
        if value and pattern.fullmatch(name):
            yield Number(name, value, _comment(lines, node.lineno - 1), file)


def _value(node: ast.expr) -> str:
    """The number or numbers as written, without `const`; "" for anything else."""
    if isinstance(node, ast.Call) and ast.unparse(node.func) == "const":
        node = node.args[0]
    number = (ast.Constant, ast.UnaryOp, ast.BinOp, ast.operator, ast.unaryop)
    inside = (*number, ast.Tuple, ast.expr_context)
    return ast.unparse(node) if all(isinstance(part, inside) for part in ast.walk(node)) else ""


def _comment(lines: list[str], at: int) -> str:
    """The comment on a line, or the comment block directly above it."""
    if " # " in lines[at] or "  #" in lines[at]:
        return lines[at].partition("#")[2].strip()
    block: list[str] = []
    while at > 0 and lines[at - 1].startswith("#"):
        at -= 1
        block.insert(0, lines[at].lstrip("# "))
    return " ".join(block)


class Mentions:
    """Which files name a word."""

    def __init__(self, *patterns: str) -> None:
        files = [file for pattern in patterns for file in sorted(ROOT.glob(pattern))]
        self._words = {file: set(re.findall(r"\w+", file.read_text())) for file in files}

    def of(self, word: str, without: Iterable[Path] = ()) -> list[Path]:
        """The files that name it, except those."""
        skipped = set(without)
        return [f for f, words in self._words.items() if word in words and f not in skipped]


def render() -> str:
    """The whole page."""
    code = Mentions("firmware/**/*.py", "host/**/*.py")
    tests = Mentions("tests/**/*.py")
    parts = [
        _HEAD,
        "## Limits compiled into the board",
        f"`{_short(_LIMITS)}`. No setting loosens them.",
    ]
    rows: list[tuple[str, ...]] = [
        (
            f"`{n.name}`",
            n.value,
            n.meaning,
            _links(code.of(n.name, [_LIMITS])),
            _links(tests.of(n.name)),
        )
        for n in limits()
    ]
    parts.append(table(("Limit", "Value", "Meaning", "Enforced in", "Named by tests"), rows))
    parts += [
        "## Settings of the board",
        f"`{_short(_SETTINGS)}`; `gazechair settings` reads and changes them.",
    ]
    lines = _SETTINGS.read_text().splitlines()
    general = [_setting(row, lines, code, tests) for row in TABLE[:_GENERAL]]
    parts.append(
        table(("Setting", "Default", "Range", "Meaning", "Used in", "Named by tests"), general)
    )
    parts.append("Per speed profile (`p1_2_...` to `p5_1_...`):")
    first = {
        name.partition("_")[2].partition("_")[2]: default
        for name, default, _, _ in TABLE[_GENERAL:][: len(PROFILE_ROWS)]
    }
    of_profiles = [
        _setting((name, first[name], low, high), lines, code, tests)
        for name, low, high in PROFILE_ROWS
    ]
    parts.append(
        table(
            (
                "Setting",
                f"Default of {PROFILES[0]}",
                "Range",
                "Meaning",
                "Used in",
                "Named by tests",
            ),
            of_profiles,
        )
    )
    parts += ["## Timings and sizes of the host", _of_files(host_timings(), tests)]
    parts += ["## Timings of the pages", _of_files(page_timings(), Mentions("tests/web/*.py"))]
    return "\n\n".join(parts) + "\n"


def _setting(
    row: tuple[str, int, int, int], lines: list[str], code: Mentions, tests: Mentions
) -> tuple[str, ...]:
    name, default, low, high = row
    at = next(k for k, line in enumerate(lines) if f'("{name}"' in line)
    meaning = lines[at].partition("#")[2].strip() if "#" in lines[at] else ""
    return (
        f"`{name}`",
        str(default),
        f"{low}..{high}",
        meaning,
        _links(code.of(name)),
        _links(tests.of(name)),
    )


def _of_files(numbers: list[Number], tests: Mentions) -> str:
    rows = [
        (f"`{n.name}`", n.value, n.meaning, f"`{_short(n.file)}`", _links(tests.of(n.name)))
        for n in numbers
    ]
    return table(("Name", "Value", "Meaning", "Used in", "Named by tests"), rows)


def _short(file: Path) -> str:
    return str(file.relative_to(ROOT))


def _links(files: list[Path]) -> str:
    return ", ".join(f"`{file.name}`" for file in files) or "-"


def table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    """A table in Markdown."""
    lines = [head, tuple("---" for _ in head), *rows]
    return "\n".join(
        "| " + " | ".join(cell.replace("|", "/") for cell in cells) + " |" for cells in lines
    )
