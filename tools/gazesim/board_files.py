"""What is flashed, and a program that writes it to an emulated board's flash."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

_ROOT = Path(__file__).resolve().parents[2]
# What only a PC needs: no use on a board, and half of its flash.
_PC_ONLY = ("virtual.py", "unix_cpython.py", "unix_micropython.py", "bank_devices.py")


def m7_folder() -> Path:
    """Where the emulated Teensy is: $GAZECHAIR_M7, or the folder shared beside the checkout."""
    return Path(os.environ.get("GAZECHAIR_M7") or _ROOT.parent / "shared" / "m7").absolute()


def firmware_files(root: Path = _ROOT) -> dict[str, str]:
    """The firmware of checkout `root`: {path on the board: text}, main.py last."""
    files = {}
    for part in ("protocol", "firmware"):
        for file in sorted((root / part).rglob("*.py")):
            if file.name not in (*_PC_ONLY, "main.py"):
                files[f"/flash/lib/{file.relative_to(root / part)}"] = file.read_text()
    files["/flash/main.py"] = (root / "firmware" / "main.py").read_text()
    return files


def install_script(files: Mapping[str, str], then: str) -> bytes:
    """A MicroPython program that writes `files` to the board's flash and goes on with `then`."""
    folders = sorted({str(parent) for path in files for parent in Path(path).parents})
    lines = ["import os", f"for folder in {[f for f in folders if f.startswith('/flash/')]!r}:"]
    lines += [" try: os.mkdir(folder)", " except OSError: pass"]
    lines += [f"with open({path!r}, 'w') as f: f.write({text!r})" for path, text in files.items()]
    return "\n".join([*lines, then, ""]).encode()
