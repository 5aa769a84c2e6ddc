"""A slow function remembers its answers, for tests that ask it the same again and again."""

import contextlib
from collections.abc import Callable, Hashable, Iterator
from typing import Any

import pytest


@contextlib.contextmanager
def remembered(owner: object, name: str, key: Callable[..., Hashable]) -> Iterator[None]:
    """Meanwhile `owner.name` computes once for each `key` of its arguments."""
    plain = getattr(owner, name)
    known: dict[Hashable, tuple[tuple[Any, ...], Any]] = {}

    def answer(*arguments: Any) -> Any:
        place = key(*arguments)
        if place not in known:  # arguments are kept: else the id of one may become another's
            known[place] = arguments, plain(*arguments)
        return known[place][1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(owner, name, answer)
        yield
