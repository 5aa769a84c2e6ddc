"""Records of measurements in docs/, with one digest of the files that each depends on."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from gazeprove.sources import digest_of, digests
from gazesetup import ROOT

_DOCS = ROOT / "docs"


def file_of(name: str) -> Path | None:
    """The record's file. None outside of a checkout: nothing is stored there."""
    return _DOCS / name if _DOCS.is_dir() else None


def digest(begins: Iterable[Path]) -> str:
    """One digest of these files and of everything that they import."""
    return digest_of(digests(begins))


def write(file: Path, record: Mapping[str, Any]) -> None:
    """Replace the file whole: who reads it at any time finds the old record or the new one."""
    fresh = file.with_suffix(".new")
    fresh.write_text(json.dumps(record, indent=1) + "\n")
    os.replace(fresh, file)
