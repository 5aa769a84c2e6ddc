"""Finds the emulated Teensy and the QEMU that runs it."""

from __future__ import annotations

import os
from pathlib import Path

from gazesetup.paths import ROOT
from gazesetup.progress import NotAvailable


def find_m7() -> Path:
    """Its folder: $GAZECHAIR_M7, or the one shared next to the checkout.

    Raises NotAvailable when neither exists.
    """
    folder = Path(os.environ.get("GAZECHAIR_M7") or ROOT.parent / "shared" / "m7").absolute()
    if not (folder / "firmware.elf").is_file():
        raise NotAvailable(f"no emulated board at {folder}: set GAZECHAIR_M7 to its folder")
    return folder
