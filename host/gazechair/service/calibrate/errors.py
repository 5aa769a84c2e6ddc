"""Errors of a calibration."""

from __future__ import annotations

from gazechair.base.told import ToldError


class CalibrateError(ToldError):
    """The calibration cannot continue; the text is one line: what, where, what to do."""
