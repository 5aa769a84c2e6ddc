"""Why a chair is not tuned."""

from __future__ import annotations

from gazechair.base.told import ToldError


class TuneError(ToldError):
    """Tuning cannot continue or its data is poor; the text says what, and what to do."""


class StoppedError(TuneError):
    """A person has stopped it."""

    def __init__(self) -> None:
        super().__init__("stopped; nothing was changed")
