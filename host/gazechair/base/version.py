"""The version of this gazechair, with the commit it was built from."""

from __future__ import annotations

import subprocess
from pathlib import Path

from gazelink import VERSION

_HERE = Path(__file__).resolve().parent
COMMIT_FILE = "commit.txt"  # written into a wheel by setup.py
_GIT_S = 5.0


def version() -> str:
    """As "0.1.0 (commit 1a2b3c4d5e6f)"; marks a checkout with uncommitted changes."""
    return f"{'.'.join(map(str, VERSION))} (commit {_commit()})"


def _commit() -> str:
    try:
        return (_HERE / COMMIT_FILE).read_text().strip()
    except OSError:
        pass  # not from a wheel: a checkout, or files copied by hand
    git = ["git", "-C", str(_HERE), "describe", "--always", "--abbrev=12", "--dirty", "--match="]
    try:
        done = subprocess.run(git, capture_output=True, text=True, timeout=_GIT_S)
    except (OSError, subprocess.TimeoutExpired):
        return "unknown"
    return done.stdout.strip() if done.returncode == 0 else "unknown"
