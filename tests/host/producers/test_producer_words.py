"""All reasons of producers are in the string tables, in every language."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import web
from gazechair.following.person import State
from gazechair.producers import person


@pytest.mark.parametrize("language", ["nl", "en"])
def test_every_reason_of_following_has_its_sentence(language: str) -> None:
    path = Path(web.__file__).parent / "strings" / f"{language}-going.json"
    messages = json.loads(path.read_text(encoding="utf-8"))["messages"]
    assert set(person._REASONS) == set(State)
    for reason in (*person._REASONS.values(), person.SIGHT_LOST, person.UNSEEN):
        assert messages[reason]["text"]
        assert "{name}" not in messages[reason]["text"]
