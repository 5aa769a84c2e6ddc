"""`gazechair plugin`: the contract in the virtual chair, for good and bad plug-ins, and `new`."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import pytest

from gazechair.plugins.found import Found, find
from gazecontract import command, paced, template
from gazecontract.contract import Contract, Row

RULES = 14


def check(kind: str, name: str, entry: str, **settings: Any) -> list[Row]:
    return list(Contract(Found(kind, name, entry, "samples"), settings or None).rows())


def broken(rows: list[Row]) -> list[str]:
    return [f"{row.rule}: {row.saw}" for row in rows if not row.ok]


def test_an_input_that_steps_keeps_the_contract() -> None:
    rows = check("input", "metronome", "pluginsamples:Metronome", how="step")
    assert broken(rows) == []
    assert len(rows) == RULES


def test_the_gamepad_keeps_it() -> None:
    assert broken(list(Contract(find("input", "gamepad")).rows())) == []


def test_a_new_package_keeps_it_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = template.write("input", "my_own", tmp_path)
    monkeypatch.syspath_prepend(str(place))
    assert 'my_own = "gazechair_my_own:MyOwn"' in (place / "pyproject.toml").read_text()
    rows = check("input", "my_own", "gazechair_my_own:MyOwn")
    assert broken(rows) == []
    assert len(rows) == RULES
    with pytest.raises(FileExistsError):
        template.write("input", "my_own", tmp_path)


@pytest.mark.parametrize("name", ["", "My", "a-b", "../x", "1a", "x" * 21])
def test_a_name_that_is_none_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="small letters"):
        template.write("input", name, tmp_path)


@pytest.mark.parametrize(
    ("entry", "settings", "why"),
    [
        ("pluginsamples:Nameless", {}, "it says what it is"),
        ("pluginsamples:Metronome", {"linear": 0}, "armed, it drives the chair: no wipers"),
        ("pluginsamples:Metronome", {"how": "raise"}, "RuntimeError: it broke"),
        ("pluginsamples:Metronome", {"how": "none"}, "returned None"),
        ("pluginsamples:Metronome", {"how": "die"}, "its process ended"),
        ("pluginsamples:Metronome", {"how": "hang"}, "did not answer within 0.5 s"),
        ("pluginsamples:Straight", {}, "is no Input"),
        ("no_such_module:X", {}, "No module named 'no_such_module'"),
        ("pluginsamples:Loose", {}, "a wrong setting is refused in one line: it took"),
    ],
)
def test_a_bad_one_is_found_out(
    entry: str, settings: dict[str, Any], why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if settings.get("how") == "hang":
        monkeypatch.setattr(paced, "ANSWER_S", 0.5)
    rows = check("input", "bad", entry, **settings)
    assert any(why in line for line in broken(rows)), rows


def test_the_command_prints_a_table_and_its_verdict(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    new = argparse.Namespace(name="straight", kind="mode", folder=tmp_path)
    assert command._new(new) == 0
    assert command._new(new) == 2
    monkeypatch.syspath_prepend(str(tmp_path / "gazechair-straight"))
    assert "plugin check mode.straight" in capsys.readouterr().out
    rows = [
        Found("mode", "straight", "gazechair_straight:Straight", "samples"),
        Found("input", "nameless", "pluginsamples:Nameless", "samples"),
        Found("input", "gone", "no_such_module:X", "elsewhere"),
    ]
    monkeypatch.setattr(command, "installed", lambda: rows)
    assert command._check(argparse.Namespace(name="straight", json=False)) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == RULES
    assert all(line.startswith("ok   ") for line in lines)
    assert command._check(argparse.Namespace(name="input.gone", json=True)) == 1
    assert json.loads(capsys.readouterr().out)["ok"] is False
    assert command._check(argparse.Namespace(name="nothing", json=False)) == 2
    assert "mode.straight, input.nameless, input.gone" in capsys.readouterr().err
    assert command._list(argparse.Namespace()) == 0
    listed = capsys.readouterr().out
    assert (
        "mode.straight (samples): Drives slowly forward while it is pressed: a template." in listed
    )
    assert "input.gone (elsewhere): ModuleNotFoundError: No module named" in listed
