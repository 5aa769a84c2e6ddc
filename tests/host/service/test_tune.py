"""The operator says go at the terminal."""

from __future__ import annotations

import io
import os
import pty
import sys
from collections.abc import Iterator

import pytest

from gazechair.service.tune import confirmed


@pytest.fixture
def keys(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """The keyboard of a terminal that is this process's standard input."""
    keyboard, terminal = pty.openpty()
    with open(terminal) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        yield keyboard
    os.close(keyboard)


@pytest.mark.parametrize(
    ("before", "answer", "go"),
    [
        (b"", b"\n", True),
        (b"", b" \n", True),
        (b"", b"no\n", False),
        (b"\n", b"no\n", False),  # typed while the board and the lidars were awaited
        (b"no\n", b"\n", True),
        (b"", b"\x04", False),  # Ctrl-D
        (b"", b" \x04\x04", False),
    ],
)
def test_only_an_enter_after_the_question_is_a_go(
    keys: int, monkeypatch: pytest.MonkeyPatch, before: bytes, answer: bytes, go: bool
) -> None:
    class Screen(io.StringIO):
        def flush(self) -> None:
            assert "Enter: go" in self.getvalue()
            os.write(keys, answer)

    os.write(keys, before)
    monkeypatch.setattr(sys, "stdout", Screen())
    assert confirmed() == go
