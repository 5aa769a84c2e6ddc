"""The processes that share a benchmark's cases."""

from __future__ import annotations

from multiprocessing import get_context
from multiprocessing.pool import Pool

PROCESSES = 2  # the machines that measure have two cores


def forked() -> Pool:
    """A pool of them, each with everything that this process has loaded."""
    return get_context("fork").Pool(PROCESSES)
