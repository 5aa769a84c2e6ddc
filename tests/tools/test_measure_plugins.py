"""The plug-ins benchmark: what counts as a sample of a press."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from gazedemo.check import NEUTRAL
from gazemeasure.plugins import _Bench


def samples(entries: list[list[Any]], stalled: bool) -> tuple[list[float], list[float]]:
    bench: Any = _Bench.__new__(_Bench)
    bench._sim = SimpleNamespace(do=lambda *_, **__: {"entries": entries})
    bench._probe = SimpleNamespace(stalled=lambda *_: stalled)
    moved: list[float] = []
    rested: list[float] = []
    bench._note(0, 5.0, 5.3, moved, rested)
    return moved, rested


def test_a_press_that_never_reaches_the_wipers_is_a_sample() -> None:
    moved, rested = samples([[1, 5.01, 200, 170], [2, 5.32, *NEUTRAL]], False)
    assert moved == pytest.approx([10.0])
    assert rested == pytest.approx([20.0])
    assert samples([[1, 5.32, *NEUTRAL]], False) == ([math.inf], [])
    assert samples([[1, 5.32, *NEUTRAL]], True) == ([], [])
