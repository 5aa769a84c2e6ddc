"""Finds PyPy, which runs long pure-Python code several times as fast."""

from __future__ import annotations

from pathlib import Path

from gazesetup import private
from gazesetup.paths import LOCAL
from gazesetup.progress import NotAvailable

_PYPY = private.Private(
    name="pypy3",
    what="PyPy",
    program="bin/pypy3.11",
    packages=(
        "pypy3",
        "pypy3-lib",
        "libc6",
        "libbz2-1.0",
        "libexpat1",
        "libffi8",
        "libgcc-s1",
        "libncursesw6",
        "libstdc++6",
        "libtinfo6",
        "zlib1g",
    ),
)
_CHECK = "import multiprocessing, sys; print(sys.implementation.name, sys.version_info >= (3, 10))"


def ensure_pypy(*, local: Path = LOCAL) -> Path:
    """PyPy as Debian builds it, unpacked in .local/pypy3.

    Raises NotAvailable with the reason.
    """
    return private.ensure(_PYPY, _checked, local)


def _checked(path: Path) -> Path:
    result = private.ask(path, _CHECK)
    if result.stdout.split() != ["pypy", "True"]:
        raise NotAvailable(f"{path} is no PyPy 3.10 ({private.last_words(result)})")
    return path
