"""Errors of the bench."""

from __future__ import annotations


class BenchError(Exception):
    """The bench cannot continue; the text is one line: what, where, what to do."""
