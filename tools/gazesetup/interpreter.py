"""Which Python the virtual environment is made of: a build that was optimised, where there is one.

A Python compiled without --enable-optimizations, as pyenv does, takes about an eighth more of the
processor. The distribution's build of the same version is better.
"""

from __future__ import annotations

import json
import subprocess
import sys
import sysconfig
from dataclasses import dataclass
from pathlib import Path

DISTRIBUTION = Path("/usr")
_ASK_S = 20.0
_ASK = "import ensurepip, json, sys; print(json.dumps([sys.version, sys.base_prefix]))"


@dataclass(frozen=True)
class Interpreter:
    """A Python outside of any virtual environment."""

    path: str
    version: str
    """Its sys.version."""
    prefix: str
    """Its sys.base_prefix."""


def best(distribution: Path = DISTRIBUTION) -> Interpreter:
    """The running one, or the distribution's of the same version where that is the faster build."""
    # Not sys.executable: that may be in a virtual environment that is about to be removed.
    base = getattr(sys, "_base_executable", sys.executable)
    running = Interpreter(base, sys.version, sys.base_prefix)
    if optimised() or Path(sys.base_prefix) == distribution:
        return running
    major, minor = sys.version_info[:2]
    return _inspected(distribution / f"bin/python{major}.{minor}") or running


def optimised() -> bool:
    """Whether the running one was compiled with profile guided optimisation, as far as it says."""
    return "--enable-optimizations" in (sysconfig.get_config_var("CONFIG_ARGS") or "")


def _inspected(path: Path) -> Interpreter | None:
    """None where it is not there, or can't make a virtual environment."""
    try:
        answer = subprocess.run(
            [path, "-I", "-c", _ASK], capture_output=True, text=True, timeout=_ASK_S, check=True
        )
        version, prefix = json.loads(answer.stdout)
        return Interpreter(str(path), version, prefix)
    except (OSError, ValueError, TypeError, subprocess.SubprocessError):
        return None
