"""Where things are, in a checkout and once installed."""

from __future__ import annotations

import os
from pathlib import Path

_PACKAGES = Path(__file__).resolve().parent.parent
ROOT = _PACKAGES.parent
SOURCE_ROOTS = ("protocol", "firmware", "host", "tools")
_INSTALLED = not (ROOT / "pyproject.toml").is_file()
_CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
# Everything fetched or built; ignored by git, may be deleted at any time.
LOCAL = _CACHE / "gazechair" if _INSTALLED else ROOT / ".local"


def source_environment() -> dict[str, str]:
    """This process's environment, with gazechair's packages on PYTHONPATH and MICROPYPATH.

    MICROPYPATH has MicroPython's own frozen modules, too. Numpy's helper threads, which wait by
    spinning, are off.
    """
    folders = [_PACKAGES] if _INSTALLED else [ROOT / name for name in SOURCE_ROOTS]
    env = dict(os.environ)
    env["PYTHONPATH"] = os.pathsep.join(map(str, folders))
    env["MICROPYPATH"] = f":.frozen:{env['PYTHONPATH']}"
    env.setdefault("OPENBLAS_NUM_THREADS", "1")
    return env
