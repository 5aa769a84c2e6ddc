"""What the parts of the proof share: their form, and the processes they use."""

from __future__ import annotations

import multiprocessing
import multiprocessing.pool
from collections.abc import Callable
from typing import Any

NOTE_EVERY_S = 5.0

Note = Callable[[str], None]
Part = tuple[dict[str, Any], list[str]]  # figures, and what fell short


def pool(quick: bool, *setup: Any) -> multiprocessing.pool.Pool:
    """A process for each core; in the quick form one, because the tests have those cores."""
    return multiprocessing.get_context("fork").Pool(1 if quick else None, *setup)
