"""Errors of a calibration."""

from __future__ import annotations

from gazechair.base.user_error import UserError


class CalibrateError(UserError):
    """The calibration cannot continue; the text is one line: what, where, what to do."""
