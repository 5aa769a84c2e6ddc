"""Why a step of the first drive failed has a sentence in Dutch for every error that can end it."""

import ast
import json
import re
from pathlib import Path

import pytest

import gazechair
from gazechair.commissioning.calibrate.marks import WHY

HOST = Path(gazechair.__file__).parent
NL = Path(__file__).parents[3] / "web" / "strings" / "nl-first.json"
SOURCES = [
    "first_drive/floor_marks.py",
    "first_drive/moves.py",
    "sensing/lidar/mask.py",
    "commissioning/board_settings.py",
    "commissioning/calibrate/joystick.py",
    "commissioning/calibrate/marks.py",
    "commissioning/tune/armed_session.py",
    "commissioning/tune/tuning.py",
    "commissioning/tune/judge.py",
    "commissioning/tune/procedure.py",
]
# For a terminal only: what is typed there, and the tools' own connection.
TERMINAL = ("no setting", "must be a whole number", "no board", "--height")


def errors(source: str) -> list[tuple[str, list[str], set[str]]]:
    """(what is raised, its keys, its fields), of each error made there."""
    tree = ast.parse((HOST / source).read_text("utf-8"))
    found = []
    for call in ast.walk(tree):
        if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Name):
            continue
        if call.func.id not in ("TuneError", "CalibrateError", "MaskError", "SettingsError"):
            continue
        keys = []
        if len(call.args) > 1:
            key = call.args[1]
            if isinstance(key, ast.Attribute):
                named = list(WHY)  # of the fit's refusal
            elif isinstance(key, ast.Constant):
                named = [key.value]
            else:
                named = named_as(tree, key.id)
            keys = [str(one) for one in named]
        found.append((ast.unparse(call), keys, {str(one.arg) for one in call.keywords}))
    return found


def named_as(tree: ast.Module, name: str) -> list[str]:
    """What is assigned to `name`, alone or first in a tuple."""
    text = ast.unparse(tree)
    return re.findall(rf"^ +{name}(?:, \w+)? = '?\(?'(\w+)'", text, re.MULTILINE)


@pytest.mark.parametrize("source", SOURCES)
def test_every_error_of_a_step_has_a_dutch_sentence_with_its_fields(source):
    texts = json.loads(NL.read_text("utf-8"))["errors"]
    for call, keys, fields in errors(source):
        assert keys or any(words in call for words in TERMINAL), call
        for key in keys:
            assert set(re.findall(r"{(\w+)}", texts[key])) <= fields, key


def test_no_dutch_sentence_is_left_over():
    texts = json.loads(NL.read_text("utf-8"))["errors"]
    assert set(texts) == {key for one in SOURCES for _, keys, _ in errors(one) for key in keys}
