"""The installed firmware: its files in one folder named after their content, and main.py.

The board's main.py names its folder. So a new firmware is copied next to the running one, and only
the rename of main.py switches between them: if the plug is pulled at any moment, the board starts
one of the two.
"""

from __future__ import annotations

import hashlib
import importlib.util
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from gazechair.service.flash import calls, numbers
from gazechair.service.flash.errors import FlashError

BASE = "/flash"
MAIN = f"{BASE}/main.py"
_MAIN_SOURCE = "gazeboard/main.py"
PREFIX = "fw-"  # of the folders' names
_PACKAGES = ("gazelink", "gazeboard")
# What only a PC runs.
_PC_ONLY = (
    "gazelink/crc_host.py",
    "gazeboard/boards/bank_devices.py",
    "gazeboard/boards/bank_layout.py",
    "gazeboard/boards/unix_cpython.py",
    "gazeboard/boards/unix_micropython.py",
    "gazeboard/boards/virtual.py",
)
_FIRST_IMPORT = "\nfrom gazeboard"

Compile = Callable[[Path, str], bytes]


@dataclass(frozen=True)
class Tree:
    """One firmware as stored on the board."""

    name: str
    """Of its folder, after its content: equal names are equal firmware."""
    files: dict[str, bytes]
    """Path within the folder -> content."""
    main: bytes
    """The board's main.py, which names the folder."""

    @property
    def folder(self) -> str:
        """Its folder on the board."""
        return f"{BASE}/{self.name}"

    @property
    def size(self) -> int:
        """Bytes of all files."""
        return sum(map(len, self.files.values())) + len(self.main)


@dataclass(frozen=True)
class Sources:
    """The firmware's source files on this machine: path on the board -> file; and main.py."""

    files: dict[str, Path]
    main: Path

    def texts(self) -> dict[str, str]:
        """What goes onto the board: path -> text, with the tables' numbers put in."""
        texts = {path: file.read_text() for path, file in self.files.items()}
        return calls.shorten(numbers.put_in(texts))


def find_sources() -> Sources:
    """The firmware that belongs to this gazechair. Raises FlashError when it is not there."""
    files = {}
    root = None
    for package in _PACKAGES:
        spec = importlib.util.find_spec(package)
        if spec is None or spec.origin is None:
            raise FlashError(f"the firmware ({package}) is not installed; install gazechair again")
        root = Path(spec.origin).parent.parent
        for file in sorted((root / package).rglob("*.py")):
            path = file.relative_to(root).as_posix()
            if path not in (*_PC_ONLY, _MAIN_SOURCE):
                files[path] = file
    assert root is not None
    return Sources(files, root / _MAIN_SOURCE)


def build(sources: Sources, compile_file: Compile | None) -> Tree:
    """The tree of these sources, compiled to .mpy with `compile_file(source, path on the board)`,
    or None: as they are.

    Raises FlashError when main.py is not as expected, and what `compile_file` raises.
    """
    files = {}
    for path, content in sources.texts().items():
        if compile_file is None:
            files[path] = content.encode()
        else:
            with tempfile.TemporaryDirectory(prefix="gazechair-") as folder:
                source = Path(folder, "source.py")
                source.write_text(content)
                files[path[: -len(".py")] + ".mpy"] = compile_file(source, path)
    text = sources.main.read_text()
    digest = hashlib.sha256(text.encode())
    for path, compiled in sorted(files.items()):
        digest.update(path.encode() + b"\0" + hashlib.sha256(compiled).digest())
    name = PREFIX + digest.hexdigest()[:8]
    head, found, tail = text.partition(_FIRST_IMPORT)
    if not found:
        raise FlashError(f"{sources.main} has no line that begins with {_FIRST_IMPORT.strip()!r}")
    choice = f'\nimport sys\n\nsys.path.insert(0, "{BASE}/{name}")\n'
    return Tree(name, files, (head + choice + found + tail).encode())


def named_by(main: str) -> str:
    """The folder that a board's main.py names, "" for any other main.py."""
    _, found, rest = main.partition(f'sys.path.insert(0, "{BASE}/{PREFIX}')
    return PREFIX + rest.partition('"')[0] if found else ""
