"""The error of flashing, raised by any of its parts."""

from __future__ import annotations

from gazechair.base.told import ToldError


class FlashError(ToldError):
    """Flashing cannot continue; the text is one line: what, where, what to do."""
