"""Runs a part's program, pytest as a rule, to its end."""

from __future__ import annotations

import signal
import subprocess
from pathlib import Path

from gazesetup.family import dies_with_me

_LIMIT_S = 1800


def finish(words: list[str], folder: Path, env: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """Run it in `folder`; its output, errors included, is one text.

    Raises subprocess.TimeoutExpired after half an hour.
    """
    return subprocess.run(
        words,
        cwd=folder,
        env=env,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=_LIMIT_S,
        preexec_fn=dies_with_me(signal.SIGTERM),
    )
