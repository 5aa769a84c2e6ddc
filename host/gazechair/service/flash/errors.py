"""Errors of flashing."""

from __future__ import annotations


class FlashError(Exception):
    """Flashing cannot continue; the text is one line: what, where, what to do."""
