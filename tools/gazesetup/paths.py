"""Paths in a checkout."""

from __future__ import annotations

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
LOCAL = ROOT / ".local"  # everything fetched or built; ignored by git, may be deleted at any time
SOURCE_ROOTS = ("protocol", "firmware", "host", "tools")


def source_environment() -> dict[str, str]:
    """This process's environment, with the checkout's source roots on PYTHONPATH and MICROPYPATH.

    MICROPYPATH has MicroPython's own frozen modules, too.
    """
    env = dict(os.environ)
    env["PYTHONPATH"] = os.pathsep.join(str(ROOT / name) for name in SOURCE_ROOTS)
    env["MICROPYPATH"] = f":.frozen:{env['PYTHONPATH']}"
    return env
