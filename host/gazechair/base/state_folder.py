"""The folder for data that survives a restart: paired devices, certificate, speed cap."""

from __future__ import annotations

import os
from pathlib import Path


def state_folder(configured: str) -> Path:
    """The configured folder; else systemd's STATE_DIRECTORY, else $XDG_STATE_HOME/gazechair."""
    if configured:
        return Path(configured).expanduser()
    if os.environ.get("STATE_DIRECTORY"):
        return Path(os.environ["STATE_DIRECTORY"].split(":")[0])
    base = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(base) / "gazechair"
