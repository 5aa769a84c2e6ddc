"""Errors of a calibration."""

from __future__ import annotations


class CalibrateError(Exception):
    """The calibration cannot go on; the text is one plain line: what, where, what to do."""
