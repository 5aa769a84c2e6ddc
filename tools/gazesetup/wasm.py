"""Finds MicroPython's WebAssembly build, which Node.js runs: 32-bit integers, a newer release."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

from gazesetup.paths import LOCAL
from gazesetup.progress import NotAvailable, run_quietly, say
from gazesetup.venv import locked

PACKAGE = "@micropython/micropython-webassembly-pyscript"
VERSION = "1.29.0-6"


def ensure_wasm(*, local: Path = LOCAL) -> Path:
    """Path of its micropython.mjs, fetched with npm once. Raises NotAvailable with the reason."""
    for program in ("node", "npm"):
        if shutil.which(program) is None:
            raise NotAvailable(f"no {program} on PATH: install Node.js 18 or newer")
    folder = local / "wasm"
    module = folder / "node_modules" / PACKAGE / "micropython.mjs"
    with locked(local):
        if not _is_there(module):
            with say(f"fetching MicroPython {VERSION} for WebAssembly"):
                shutil.rmtree(folder, ignore_errors=True)
                folder.mkdir(parents=True)
                words = ("npm", "install", "--prefix", folder, "--no-audit", "--no-fund")
                run_quietly([*words, f"{PACKAGE}@{VERSION}"])
            if not _is_there(module):
                raise NotAvailable(f"npm installed {PACKAGE}, yet {module.name} is not there")
    return module


def _is_there(module: Path) -> bool:
    try:
        found = json.loads((module.parent / "package.json").read_text())
    except (OSError, ValueError):
        return False
    return module.is_file() and found.get("version") == VERSION
