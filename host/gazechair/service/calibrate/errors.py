"""Errors of a calibration."""

from __future__ import annotations


class CalibrateError(Exception):
    """The calibration cannot continue; the text is one line: what, where, what to do."""
