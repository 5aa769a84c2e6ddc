"""Errors of tuning."""

from __future__ import annotations

from gazechair.base.told import ToldError


class TuneError(ToldError):
    """Raised when tuning cannot continue or its data is poor; the text says what to do."""


class StoppedError(TuneError):
    """Raised when a person has stopped it."""

    def __init__(self) -> None:
        super().__init__("stopped; nothing was changed")
