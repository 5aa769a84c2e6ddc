"""`gazechair --version`: the version and the commit, from a checkout and from a wheel's file."""

import subprocess

import pytest

import gazesetup
from gazechair.base import version as module
from gazechair.cli import main
from gazelink import VERSION

NUMBER = ".".join(map(str, VERSION))


def test_a_checkout_names_its_commit() -> None:
    head = subprocess.run(
        ["git", "-C", gazesetup.ROOT, "rev-parse", "HEAD"], capture_output=True, text=True
    )
    assert head.returncode == 0
    text = module.version()
    assert text.startswith(f"{NUMBER} (commit {head.stdout[:12]}")


def test_a_wheel_knows_the_commit_it_was_made_from(tmp_path, monkeypatch) -> None:
    (tmp_path / module.COMMIT_FILE).write_text("0123456789ab\n")
    monkeypatch.setattr(module, "_HERE", tmp_path)
    assert module.version() == f"{NUMBER} (commit 0123456789ab)"


def test_files_copied_by_hand_say_that_it_is_unknown(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(module, "_HERE", tmp_path)
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    assert module.version() == f"{NUMBER} (commit unknown)"


def test_the_command_prints_it(capsys) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"gazechair {module.version()}\n"
