"""Errors of flashing."""

from __future__ import annotations


class FlashError(Exception):
    """Flashing cannot go on; the text is one plain line: what, where, what to do."""
