"""The file of the record, docs/proof.json, as it is read."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from gazesetup import ROOT

FILE = ROOT / "docs" / "proof.json"


def read(file: Path = FILE) -> dict[str, Any]:
    """The record; an empty one when there is none."""
    if not file.exists():
        return {"parts": {}, "files": {}}
    found: dict[str, Any] = json.loads(file.read_text())
    return found


def figures(part: str) -> dict[str, Any]:
    """What the part's last full run found; nothing when it never ran."""
    found: dict[str, Any] = read()["parts"].get(part, {}).get("figures", {})
    return found
