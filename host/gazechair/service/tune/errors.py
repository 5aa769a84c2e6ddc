"""Why a chair is not tuned."""

from __future__ import annotations


class TuneError(Exception):
    """Tuning cannot continue or its data is poor; the text says what, and what to do."""
