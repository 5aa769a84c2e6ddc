"""Why a chair is not tuned."""

from __future__ import annotations


class TuneError(Exception):
    """Tuning cannot go on or its data is no good; the text says what, and what to do."""
