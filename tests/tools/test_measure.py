"""Each benchmark that `gazechair measure` names can be run."""

from __future__ import annotations

import importlib
import inspect

import pytest

from gazemeasure.benchmarks import BENCHMARKS


@pytest.mark.parametrize("name", BENCHMARKS)
def test_every_benchmark_has_its_measure(name: str) -> None:
    module = importlib.import_module(f"gazemeasure.{BENCHMARKS[name][0]}")
    assert list(inspect.signature(module.measure).parameters) == ["quick"]
