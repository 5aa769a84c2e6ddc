"""Writes docs/numbers.md: limits, settings, numbers with a unit; who uses them, which tests do."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from gazechair.service.flash.tree import find_sources
from gazehouse import arrows
from gazelink.settings_table import PROFILE_ROWS, PROFILES, TABLE
from gazesetup import ROOT

DOCUMENT = ROOT / "docs" / "numbers.md"
_LIMITS = ROOT / "firmware" / "gazeboard" / "core" / "limits.py"
_SETTINGS = ROOT / "protocol" / "gazelink" / "settings_table.py"
_UNITS = "S|MS|US|HZ|M|MM|DEG|RAD|DPS|M_S2|M2|PERMILLE|BYTES"
_TIMED = re.compile(rf"_?[A-Z][A-Z0-9_]*_(?:{_UNITS})")
_SCALED = re.compile(rf"_?[A-Z][A-Z0-9_]*_(?:{_UNITS}|Q4|Q8|Q10)")
_SCRIPT = re.compile(
    r"^(?:export )?const ([A-Z][A-Z0-9_]*_(?:MS|S|PX)) = ([\d_.]+|\[[\d_., ]+\]);(?: // (.*))?$"
)
_GENERAL = len(TABLE) - len(PROFILES) * len(PROFILE_ROWS)

HIGHEST = {
    "STEP_FORWARD_MAX_MS": "step_forward_ms",
    "STEP_TURN_MAX_MS": "step_turn_limit_ms",
    "SUPERVISION_MAX_MS": "supervision_ms",
    "AUTO_MM_S": "auto_mm_s",
    "AUTO_LIMIT_MAX_S": "auto_limit_s",
}
"""Limits that are the highest value of a setting of the board."""
REPEATED = {"AUTO_OVERRULED_MS": ("firmware/gazeboard/core/auto.py", "_OVERRULED_MS")}
"""Limits that the firmware uses by another name only: the file and that name."""
_UNWRAPPED = {"const": "", "math.radians": " degrees", "np.radians": " degrees"}

_HEAD = """# Numbers

Every limit and setting, and every number whose name ends in a unit: its meaning, who uses it, which
tests name it. Generated from the code by `tools/docs`; a test compares. A number has one home: the
numbers behind the promises are compiled into the board (`limits`), those that an installation may
choose are settings of the board, and the others are in the code that uses them."""


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


def board_timings() -> list[Number]:
    """Numbers with a unit or a scale in their name in the firmware that is flashed."""
    firmware = ROOT / "firmware"
    flashed = [firmware / path for path in find_sources().files if path.startswith("gazeboard/")]
    found: list[Number] = []
    for file in flashed:
        if file != _LIMITS:
            no_quantity = _no_quantities(ast.parse(file.read_text()))
            found += [one for one in _named(file, _SCALED) if one.name not in no_quantity]
    return found


def _no_quantities(tree: ast.AST) -> set[str]:
    """Names of places in an array, `w[_REST_MS]` or `w[side + _HOLD_MS]`, and private names that
    their file does not use: of places that are reached from a neighbour."""
    names = [node for node in ast.walk(tree) if isinstance(node, ast.Name)]
    read = {name.id for name in names if isinstance(name.ctx, ast.Load)}
    unread = {name.id for name in names if name.id[0] == "_"} - read
    places = [node.slice for node in ast.walk(tree) if isinstance(node, ast.Subscript)]
    sums = [place for place in places if isinstance(place, ast.BinOp)]
    terms = [*places, *(term for place in sums for term in (place.left, place.right))]
    return unread | {term.id for term in terms if isinstance(term, ast.Name)}


def host_timings() -> list[Number]:
    """Numbers with a unit in their name in the host's modules."""
    files = sorted((ROOT / "host" / "gazechair").rglob("*.py"))
    return [number for file in files for number in _named(file, _TIMED)]


def page_timings() -> list[Number]:
    """The same in the pages' scripts."""
    found = []
    for file in sorted((ROOT / "web").glob("*.js")):
        lines = file.read_text().splitlines()
        for at, line in enumerate(lines):
            if match := _SCRIPT.match(line):
                found.append(Number(match[1], match[2], match[3] or _jsdoc(lines, at), file))
    return found


def _named(file: Path, pattern: re.Pattern[str]) -> Iterator[Number]:
    lines = file.read_text().splitlines()
    body = ast.parse("\n".join(lines)).body
    for node, below in zip(body, [*body, None][1:], strict=True):
        if not isinstance(node, ast.Assign):
            continue
        for name, number in _assigned(node):
            if (value := _value(number)) and pattern.fullmatch(name):
                meaning = _comment(lines, node.lineno - 1, name, _text(below))
                yield Number(name, value, meaning, file)


def _assigned(node: ast.Assign) -> Iterator[tuple[str, ast.expr]]:
    """Names with what each gets, also of `A, B = 1, 2`."""
    target, value = node.targets[0], node.value
    if isinstance(target, ast.Name):
        yield target.id, value
    elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        for one, part in zip(target.elts, value.elts, strict=False):  # `A, B = *both,`
            if isinstance(one, ast.Name):
                yield one.id, part


def _text(node: ast.stmt | None) -> str:
    """The string that stands alone as a statement; "" for anything else."""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return " ".join(str(node.value.value).split())
    return ""


def _value(node: ast.expr) -> str:
    """The number or numbers as written, without `const`; "" for anything else."""
    text = ast.unparse(node)
    if isinstance(node, ast.Call) and ast.unparse(node.func) in _UNWRAPPED:
        text = ast.unparse(node.args[0]) + _UNWRAPPED[ast.unparse(node.func)]
        node = node.args[0]
    number = (ast.Constant, ast.UnaryOp, ast.BinOp, ast.operator, ast.unaryop)
    inside = (*number, ast.Tuple, ast.expr_context)
    return text if all(isinstance(part, inside) for part in ast.walk(node)) else ""


def _comment(lines: list[str], at: int, name: str, below: str) -> str:
    """The comment on a line, the string below it, or the comment block directly above it.

    In a block about several the part of one begins with its name: `MARGIN: ...`.
    """
    if " # " in lines[at] or "  #" in lines[at]:
        return lines[at].partition("#")[2].strip()
    if below:
        return below
    block: list[str] = []
    while at > 0 and lines[at - 1].startswith("#"):
        at -= 1
        block.insert(0, lines[at].lstrip("# "))
    text = " ".join(block)
    prefix = name.lstrip("_").partition("_")[0]
    return text.partition(f"{prefix}: ")[2] or text


def _jsdoc(lines: list[str], at: int) -> str:
    """The comment `/** ... */` directly above a line; "" for none."""
    end = at
    while at > 0 and lines[end - 1].endswith("*/"):
        at -= 1
        if lines[at].startswith("/**"):
            return " ".join(" ".join(line.strip("/* ") for line in lines[at:end]).split())
    return ""


def _texts(patterns: Iterable[str]) -> dict[Path, str]:
    files = [file for pattern in patterns for file in sorted(ROOT.glob(pattern))]
    return {file: file.read_text() for file in files}


class Mentions:
    """Which files name a word."""

    def __init__(self, *patterns: str) -> None:
        texts = _texts(patterns)
        self._words = {file: set(re.findall(r"\w+", text)) for file, text in texts.items()}

    def of(self, word: str, without: Iterable[Path] = ()) -> list[Path]:
        """The files that name it, except those."""
        skipped = set(without)
        return [f for f, words in self._words.items() if word in words and f not in skipped]


class SettingMentions:
    """Which files name a setting as one: some are called as other things are, too."""

    def __init__(self, *patterns: str) -> None:
        texts = _texts(patterns)
        self._texts = {file: text for file, text in texts.items() if "settings" in text}

    def of(self, name: str) -> list[Path]:
        """The files that read it from the settings, or give its name in quotes or a value."""
        as_setting = re.compile(rf'(?:settings|\bs)\.{name}\b|"{name}"|\b{name}=\d')
        return [file for file, text in self._texts.items() if as_setting.search(text)]


class Tests(Mentions):
    """Which tests name a number: in its sense only if they load its file, too."""

    def __init__(self, *patterns: str) -> None:
        super().__init__(*patterns)
        known = arrows.modules()
        self._module = {file: name for name, file in known.items()}
        self._loads = {file: _loaded(file.read_text(), known) for file in self._words}

    def of_number(self, number: Number) -> list[Path]:
        """The tests that name it and load its module, its package or its script."""
        module = self._module.get(number.file, number.file.name)
        either = {module, module.rpartition(".")[0]}
        return [f for f in self.of(number.name) if self._loads[f] & either]


def _loaded(text: str, known: Mapping[str, Path]) -> set[str]:
    """The modules that a test imports or patches by name, and the scripts that it names."""
    tree = ast.parse(text)
    strings = {
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }
    patched = {string.rpartition(".")[0] for string in strings} & known.keys()
    return {*arrows.imported(tree, known), *patched, *re.findall(r"\w+\.js\b", text)}


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
            _enforced(n.name, code),
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
    used = SettingMentions("firmware/**/*.py", "host/**/*.py")
    tested = SettingMentions("tests/**/*.py")
    general = [_setting(row, lines, used, tested) for row in TABLE[:_GENERAL]]
    parts.append(
        table(("Setting", "Default", "Range", "Meaning", "Used in", "Named by tests"), general)
    )
    parts.append("Per speed profile (`p1_2_...` to `p5_1_...`):")
    first = {
        name.partition("_")[2].partition("_")[2]: default
        for name, default, _, _ in TABLE[_GENERAL:][: len(PROFILE_ROWS)]
    }
    of_profiles = [
        _setting((name, first[name], low, high), lines, used, tested)
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
    parts += _sections()
    return "\n\n".join(parts) + "\n"


def _sections() -> Iterator[str]:
    """The numbers of the board, of the host and of the pages."""
    tests = Tests("tests/**/*.py")
    yield "## Timings and thresholds of the board"
    yield "In the code that uses them. `_Q4`: 1/16 of a unit; `_Q8`: 1/256; `_Q10`: 1/1024."
    yield _of_files(board_timings(), tests)
    host = host_timings()
    yield "## Timings and sizes of the host"
    yield _of_files([number for number in host if number.name[0] != "_"], tests)
    yield "Private to their modules:"
    yield _of_files([number for number in host if number.name[0] == "_"], tests)
    yield "## Timings of the pages"
    yield _of_files(page_timings(), Tests("tests/web/*.py"))


def _enforced(limit: str, code: Mentions) -> str:
    """Where the firmware or the settings table uses a limit."""
    if limit in HIGHEST:
        return f"`{_SETTINGS.name}` (highest `{HIGHEST[limit]}`)"
    if limit in REPEATED:
        path, name = REPEATED[limit]
        return f"`{Path(path).name}` (`{name}`)"
    return _links(code.of(limit, [_LIMITS]))


def _setting(
    row: tuple[str, int, int, int],
    lines: list[str],
    used: SettingMentions,
    tested: SettingMentions,
) -> tuple[str, ...]:
    name, default, low, high = row
    at = next(k for k, line in enumerate(lines) if f'("{name}"' in line)
    meaning = lines[at].partition("#")[2].strip() if "#" in lines[at] else ""
    return (
        f"`{name}`",
        str(default),
        f"{low}..{high}",
        meaning,
        _links(used.of(name)),
        _links(tested.of(name)),
    )


def _of_files(numbers: list[Number], tests: Tests) -> str:
    rows = [
        (f"`{n.name}`", n.value, n.meaning, f"`{_short(n.file)}`", _links(tests.of_number(n)))
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
