"""Errors of the bench."""

from __future__ import annotations


class BenchError(Exception):
    """The bench cannot go on; the text is one plain line: what, where, what to do."""
