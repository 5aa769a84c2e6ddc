"""Profiles: always one, within limits, on disk at once, and nothing is lost by a damaged file."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.base.health import Health
from gazechair.config import configuration
from gazechair.people.profiles import ProfileRefused, Profiles, fields, house_fields
from gazechair.people.profiles.store import FILE_NAME, MOST_PROFILES

FIELDS = fields(["en", "nl"], {"mode": "continuous", "language": "en"})


@pytest.fixture
def profiles(tmp_path):
    return Profiles(tmp_path, FIELDS)


def reason(profiles, posted, caretaker=True):
    before = profiles.as_json()
    with pytest.raises(ProfileRefused) as refused:
        profiles.change(posted, caretaker)
    assert profiles.as_json() == before
    return refused.value.reason


def test_a_new_host_has_one_profile_of_the_house_s_defaults(profiles):
    mine = profiles.chosen()
    assert (mine["mode"], mine["language"], mine["dwell_ms"]) == ("continuous", "en", 600)
    assert mine["dwell_ms"] > mine["steer_dwell_ms"]


def test_what_is_saved_is_there_after_a_restart(profiles, tmp_path):
    profiles.change({"create": "Jan"}, True)
    profiles.change({"choose": "2"}, False)
    profiles.change({"save": {"id": "2", "dwell_ms": 900, "mirrored": True}}, False)
    again = Profiles(tmp_path, FIELDS)
    assert again.chosen() == profiles.chosen()
    assert again.chosen()["name"] == "Jan"
    assert again.chosen()["dwell_ms"] == 900


def test_every_change_has_a_new_revision(profiles):
    before = profiles.revision
    profiles.change({"save": {"id": "1", "tones": False}}, False)
    assert profiles.as_json()["revision"] == profiles.revision != before


@pytest.mark.parametrize("name", [name for name, field in FIELDS.items() if field.step])
def test_numbers_stay_within_their_limits(profiles, name):
    field = FIELDS[name]
    for value in (field.low - 1, field.high + 1, float(field.low), True, None, "600"):
        assert reason(profiles, {"save": {"id": "1", name: value}}) == "profile_value"


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("name", ""),
        ("name", "x" * 41),
        ("name", "a\nb"),
        ("mode", "fast"),
        ("language", "xx"),
        ("mirrored", 1),
        ("colour", "red"),
    ],
)
def test_other_values_are_refused_with_the_reason(profiles, name, value):
    assert reason(profiles, {"save": {"id": "1", name: value}}) == "profile_value"


def test_a_page_that_has_not_heard_of_a_deletion_changes_nobody_else(profiles, tmp_path):
    """Two caretakers at once: one deletes Jan and creates Piet, the other lets Jan drive."""
    profiles.change({"create": "Jan"}, True)
    again = Profiles(tmp_path, FIELDS)
    jan = again.as_json()["profiles"][-1]["id"]
    again.change({"delete": jan}, True)
    again.change({"create": "Piet"}, True)
    assert reason(again, {"save": {"id": jan, "auto": True}}) == "profile_unknown"
    assert reason(again, {"choose": jan}) == "profile_unknown"
    assert [one["name"] for one in again.as_json()["profiles"]] == ["driver", "Piet"]


def test_a_sentence_may_have_any_emoji(profiles):
    sent = "Ik zit vast \U0001f469\u200d\U0001f9bd\u200d\u27a1\ufe0f \u2764\ufe0f"
    profiles.change({"save": {"id": "1", "help_sentence": sent}}, False)
    assert profiles.chosen()["help_sentence"] == sent
    assert reason(profiles, {"save": {"id": "1", "help_sentence": "a\u202eb"}}) == "profile_value"


def test_steering_is_never_slower_than_starting(profiles):
    posted = {"save": {"id": "1", "dwell_ms": 300, "steer_dwell_ms": 400}}
    assert reason(profiles, posted) == "profile_value"


def test_only_the_caretaker_creates_and_deletes(profiles):
    assert reason(profiles, {"create": "Jan"}, caretaker=False) == "not_allowed"
    assert reason(profiles, {"delete": "1"}, caretaker=False) == "not_allowed"


def test_one_remains_and_there_is_an_end(profiles):
    assert reason(profiles, {"delete": "1"}) == "profile_last"
    for n in range(1, MOST_PROFILES):
        profiles.change({"create": f"person {n}"}, True)
    assert reason(profiles, {"create": "one more"}) == "profile_full"
    profiles.change({"delete": "1"}, True)
    assert profiles.as_json()["chosen"] == "2"


@given(posted=st.dictionaries(st.text(max_size=8), st.recursive(st.none() | st.text(), st.lists)))
@settings(max_examples=50, deadline=None)
def test_no_request_does_harm(tmp_path_factory, posted):
    profiles = Profiles(tmp_path_factory.mktemp("state"), FIELDS)
    with pytest.raises(ProfileRefused):
        profiles.change(posted, True)
    assert len(profiles.as_json()["profiles"]) == 1


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"profiles": {"1": 3}}', '{"profiles": []}', "\0"]
)
def test_a_damaged_file_is_kept_and_the_host_goes_on(tmp_path, text):
    (tmp_path / FILE_NAME).write_text(text)
    for _ in range(2):  # told at each start until a profile is stored
        health = Health("profiles")
        people = Profiles(tmp_path, FIELDS, health)
        assert people.chosen()["dwell_ms"] == 600
        assert health.reason == "file_damaged"
    people.change({"choose": "1"}, True)
    assert health.reason == "ok"
    assert (tmp_path / "profiles.damaged").read_text() == text
    people.change({"choose": "1"}, True)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["profiles.damaged", FILE_NAME]


def test_strange_values_of_another_version_become_defaults(tmp_path):
    found = {"chosen": "7", "profiles": {"7": {"name": "Jan", "dwell_ms": 99999, "colour": 1}}}
    (tmp_path / FILE_NAME).write_text(json.dumps(found))
    mine = Profiles(tmp_path, FIELDS).chosen()
    assert (mine["name"], mine["dwell_ms"]) == ("Jan", 600)
    assert set(mine) == set(FIELDS)


def test_a_full_disk_changes_nothing_and_says_so(profiles, tmp_path):
    (tmp_path / "profiles.json.new").mkdir()
    assert reason(profiles, {"choose": "1"}) == "profile_not_stored"


def test_a_new_language_is_one_file(tmp_path, monkeypatch):
    """One more file of texts: it can be configured, and every person can choose it."""
    (tmp_path / "strings").mkdir()
    for language in ("nl", "en", "xx"):
        words = {"labels": {"role_driver": f"driver in {language}"}, "messages": {}}
        (tmp_path / "strings" / f"{language}.json").write_text(json.dumps(words))
    monkeypatch.setattr("gazechair.base.languages.web_folder", lambda: tmp_path)
    config = configuration.parse('[web]\nlanguage = "xx"')
    table = house_fields(config)
    assert table["language"].choices == ("nl", "en", "xx")
    mine = Profiles(None, table).chosen()
    assert (mine["language"], mine["name"]) == ("xx", "driver in xx")
    with pytest.raises(configuration.ConfigError, match="web/strings"):
        configuration.parse('[web]\nlanguage = "yy"')


def test_assist_is_a_caretakers_to_switch_and_is_on_or_off():
    profiles = Profiles(None, FIELDS)
    posted = {"save": {"id": "1", "assist": True}}
    with pytest.raises(ProfileRefused, match="caretaker"):
        profiles.change(posted, False)
    for value in (1, "on", None, [True], {"on": True}):
        with pytest.raises(ProfileRefused):
            profiles.change({"save": {"id": "1", "assist": value}}, True)
    assert profiles.chosen()["assist"] is False
    profiles.change(posted, True)
    assert profiles.chosen()["assist"] is True
