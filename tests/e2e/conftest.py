"""Shared by the end-to-end tests: a chair in lockstep, ready or on its way."""

from __future__ import annotations

import pytest

from e2e import states
from gazesim.lockstep_chair import Lockstep


@pytest.fixture
def chair() -> Lockstep:
    """Just switched on, in a hall with nothing near."""
    return Lockstep()


@pytest.fixture
def driving() -> Lockstep:
    """Armed by the page, "forward" held, moving."""
    return states.driving("forward")


@pytest.fixture
def turning() -> Lockstep:
    """Armed by the page, "left" held, turning."""
    return states.driving("left")


@pytest.hookimpl(tryfirst=True)  # before pytest-xdist reads the groups
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The document's test comes after all whose figures it compares.

    A file's chairs in lockstep run in one process, which keeps those that several tests begin with.
    """
    items.sort(key=lambda item: item.path.name == "test_safety_table.py")
    for item in items:
        if item.path.name.startswith("test_lockstep_"):
            item.add_marker(pytest.mark.xdist_group(item.path.stem))
