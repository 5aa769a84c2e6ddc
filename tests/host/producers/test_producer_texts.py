"""All reasons of producers are in the string tables, in every language."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import web
from gazechair.following.person import State
from gazechair.producers import person, ride, service
from gazechair.producers.kinds import KINDS


def messages_of(language: str) -> dict[str, dict[str, str]]:
    path = Path(web.__file__).parent / "strings" / f"{language}-going.json"
    messages: dict[str, dict[str, str]] = json.loads(path.read_text("utf-8"))["messages"]
    return messages


@pytest.mark.parametrize("language", ["nl", "en"])
@pytest.mark.parametrize("kind", sorted(set(KINDS) - {"place"}))
@pytest.mark.parametrize("key", ["going_thinks", service.STOPPED, service.CHANGED, service.FAILED])
def test_what_is_said_of_every_kind_names_places_only(language: str, kind: str, key: str) -> None:
    """A name that people did not give is in one language, and is no place to go to."""
    messages = messages_of(language)
    sent = messages.get(f"{key}_{kind}", messages[key])
    assert "{name}" not in sent["text"] + sent["do"]


@pytest.mark.parametrize("language", ["nl", "en"])
def test_a_doubted_pose_has_its_sentence_for_places_and_spots(language: str) -> None:
    sent = messages_of(language)[ride.POSE_DOUBTED]
    assert sent["text"]
    assert "{name}" not in sent["text"] + sent["do"]


@pytest.mark.parametrize("language", ["nl", "en"])
def test_every_reason_of_following_has_its_sentence(language: str) -> None:
    messages = messages_of(language)
    assert set(person._REASONS) == set(State)
    for reason in (*person._REASONS.values(), person.SIGHT_LOST, person.UNSEEN):
        assert messages[reason]["text"]
        assert "{name}" not in messages[reason]["text"]
