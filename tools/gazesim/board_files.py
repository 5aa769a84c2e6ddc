"""The emulated board's flash, filled without its cable: the firmware's files and their places."""

from __future__ import annotations

import binascii
import zlib
from collections.abc import Mapping
from itertools import groupby
from pathlib import PurePosixPath

from gazechair.service.flash import tree

LIB = f"{tree.BASE}/lib"

# The program's place in the memory map is small, so files travel compressed, a folder together.
_PUT = """
import os, io, deflate, binascii
def put(sizes, packed):
 texts = deflate.DeflateIO(io.BytesIO(binascii.a2b_base64(packed)), deflate.ZLIB)
 for path, size in sizes:
  with open(path, 'wb') as f: f.write(texts.read(size))
"""


def firmware_files() -> dict[str, str]:
    """The files of `gazechair flash`, as source: {path on the board: text}, main.py last.

    They are in /flash/lib, where MicroPython looks by default, so main.py is as it is in the
    checkout. Raises gazechair's FlashError when the firmware is missing.
    """
    sources = tree.find_sources()
    files = {f"{LIB}/{path}": text for path, text in sources.texts().items()}
    return {**files, tree.MAIN: sources.main.read_text()}


def install_script(files: Mapping[str, str], then: str) -> bytes:
    """A MicroPython program that writes `files` to the board's flash and continues with `then`."""
    folders = {str(parent) for path in files for parent in PurePosixPath(path).parents}
    below = sorted(folder for folder in folders if folder.startswith(f"{tree.BASE}/"))
    lines = [_PUT, f"for folder in {below!r}:"]
    lines += [" try: os.mkdir(folder)", " except OSError: pass"]
    ordered = sorted(files.items(), key=lambda file: PurePosixPath(file[0]).parent)
    for _, together in groupby(ordered, lambda file: PurePosixPath(file[0]).parent):
        octets = {path: text.encode() for path, text in together}
        sizes = [(path, len(text)) for path, text in octets.items()]
        lines.append(f"put({sizes!r}, {_packed(b''.join(octets.values()))!r})")
    return "\n".join([*lines, then, ""]).encode()


def _packed(octets: bytes) -> str:
    return binascii.b2a_base64(zlib.compress(octets, 9), newline=False).decode()
