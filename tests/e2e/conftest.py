"""Shared by the end-to-end tests: a chair in lockstep, ready or on its way."""

from __future__ import annotations

import pytest

from gazesim.lockstep_chair import Lockstep


@pytest.fixture
def chair() -> Lockstep:
    """Just switched on, in a hall with nothing near."""
    return Lockstep()


@pytest.fixture
def driving() -> Lockstep:
    """Armed by the page, "forward" held, moving."""
    chair = Lockstep()
    chair.drive("forward")
    return chair


@pytest.fixture
def turning() -> Lockstep:
    """Armed by the page, "left" held, turning."""
    chair = Lockstep()
    chair.drive("left")
    return chair


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The document's test comes after all whose figures it compares."""
    items.sort(key=lambda item: item.path.name == "test_safety_table.py")
