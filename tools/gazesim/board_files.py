"""The emulated board's flash, filled without its cable: where files lie, and what writes them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePosixPath

from gazechair.flash import tree

LIB = f"{tree.BASE}/lib"


def firmware_files() -> dict[str, str]:
    """What `gazechair flash` puts on a board, as source: {path on the board: text}, main.py last.

    It lies in /flash/lib, where MicroPython looks by itself, so main.py is as it is in the
    checkout. Raises gazechair's FlashError when the firmware is not there.
    """
    sources = tree.find_sources()
    files = {f"{LIB}/{path}": file.read_text() for path, file in sources.files.items()}
    return {**files, tree.MAIN: sources.main.read_text()}


def install_script(files: Mapping[str, str], then: str) -> bytes:
    """A MicroPython program that writes `files` to the board's flash and goes on with `then`."""
    folders = {str(parent) for path in files for parent in PurePosixPath(path).parents}
    below = sorted(folder for folder in folders if folder.startswith(f"{tree.BASE}/"))
    lines = ["import os", f"for folder in {below!r}:"]
    lines += [" try: os.mkdir(folder)", " except OSError: pass"]
    lines += [f"with open({path!r}, 'w') as f: f.write({text!r})" for path, text in files.items()]
    return "\n".join([*lines, then, ""]).encode()
