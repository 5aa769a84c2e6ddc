"""Tuning: measures on the chair how it turns and drives straight in a speed profile."""

from gazechair.base.user_error import UserError


class TuneError(UserError):
    """Raised when tuning cannot continue or its data is poor."""


class StoppedError(TuneError):
    """Raised when a person has stopped it."""

    def __init__(self) -> None:
        super().__init__("stopped; nothing was changed")
