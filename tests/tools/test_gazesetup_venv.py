"""When the checkout's virtual environment is made, extended, kept and remade."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gazesetup import ROOT, venv


class FakeCommands:
    """Stands in for running commands: records them, and makes what `-m venv` would make."""

    def __init__(self) -> None:
        self.made = 0
        self.installed: list[str] = []
        self.fail: BaseException | None = None

    def __call__(self, command: list[str | Path], **_: object) -> str:
        words = [str(word) for word in command]
        if "venv" in words:
            self.made += 1
            python = Path(words[-1]) / "bin" / "python"
            python.parent.mkdir(parents=True)
            python.touch()
        else:
            if self.fail is not None:
                raise self.fail
            self.installed.append(words[-1].partition("[")[2].rstrip("]"))
        return ""


@pytest.fixture
def commands(monkeypatch: pytest.MonkeyPatch) -> FakeCommands:
    """No pip, no network."""
    fake = FakeCommands()
    monkeypatch.setattr(venv, "run_quietly", fake)
    return fake


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A checkout with nothing but what the venv rests on."""
    (tmp_path / "pyproject.toml").write_text("[project]\n")
    (tmp_path / "setup.py").write_text("")
    return tmp_path


def ensure(root: Path, *extras: str) -> Path:
    """The venv's Python for `extras`."""
    return venv.ensure_venv(extras, root=root, local=root / ".local")


def test_made_once_then_kept(root: Path, commands: FakeCommands) -> None:
    """The second start is immediate."""
    assert ensure(root, "sim") == root / ".local" / "venv" / "bin" / "python"
    ensure(root, "sim")
    ensure(root)
    assert (commands.made, commands.installed) == (1, ["sim"])


def test_more_extras_are_added_and_none_lost(root: Path, commands: FakeCommands) -> None:
    """The demo and the tests take turns without undoing each other."""
    ensure(root, "sim")
    ensure(root, "test")
    ensure(root, "sim")
    assert (commands.made, commands.installed) == (1, ["sim", "sim,test"])


@pytest.mark.parametrize("file", ["pyproject.toml", "setup.py"])
def test_remade_when_its_basis_changed(root: Path, commands: FakeCommands, file: str) -> None:
    """Another list of dependencies or packages."""
    ensure(root, "sim")
    (root / file).write_text("# changed\n")
    ensure(root)
    assert (commands.made, commands.installed) == (2, ["sim", ""])


def test_remade_for_another_python(
    root: Path, commands: FakeCommands, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A venv belongs to one version."""
    ensure(root)
    monkeypatch.setattr(venv.sys, "version", "3.99")
    ensure(root)
    assert commands.made == 2


def test_a_cut_off_installation_is_not_taken_for_a_whole_one(
    root: Path, commands: FakeCommands
) -> None:
    """The stamp comes last."""
    commands.fail = venv.NotAvailable("pip ended with 1")
    with pytest.raises(venv.NotAvailable):
        ensure(root, "sim")
    commands.fail = None
    ensure(root, "sim")
    assert (commands.made, commands.installed) == (2, ["sim"])


def test_more_extras_that_cannot_be_had_leave_the_venv_as_it_was(
    root: Path, commands: FakeCommands
) -> None:
    """Without network, what worked goes on working."""
    ensure(root, "sim")
    commands.fail = venv.NotAvailable("pip ended with 1")
    with pytest.raises(venv.NotAvailable):
        ensure(root, "test")
    ensure(root, "sim")
    assert (commands.made, commands.installed) == (1, ["sim"])


@pytest.mark.parametrize("fails", [venv.NotAvailable("pip ended with 1"), KeyboardInterrupt()])
def test_one_that_cannot_be_remade_stays_for_when_the_change_is_taken_back(
    root: Path, commands: FakeCommands, fails: BaseException
) -> None:
    """Without network, another branch must not cost what works."""
    marker = ensure(root, "sim").with_name("this one")
    marker.touch()
    (root / "pyproject.toml").write_text("# changed\n")
    commands.fail = fails
    for _ in range(2):
        with pytest.raises(type(fails)):
            ensure(root)
    assert marker.exists()
    (root / "pyproject.toml").write_text("[project]\n")
    ensure(root, "sim")
    assert commands.installed == ["sim"]


def test_the_one_before_outlasts_a_set_up_that_was_killed_and_no_longer(
    root: Path, commands: FakeCommands
) -> None:
    marker = ensure(root).with_name("this one")
    marker.touch()
    kept = root / ".local" / "venv"
    kept.rename(kept.with_name("venv.before"))
    (kept / "half").mkdir(parents=True)
    commands.fail = venv.NotAvailable("pip ended with 1")
    with pytest.raises(venv.NotAvailable):
        ensure(root)
    assert marker.exists()
    assert not (kept / "half").exists()
    (root / "pyproject.toml").write_text("# changed\n")
    commands.fail = None
    ensure(root)
    assert not marker.exists()
    assert [path.name for path in kept.parent.iterdir() if path.is_dir()] == ["venv"]


def test_an_interrupted_installation_of_more_extras_means_remaking(
    root: Path, commands: FakeCommands
) -> None:
    """Nobody knows how far pip came."""
    ensure(root, "sim")
    commands.fail = KeyboardInterrupt()
    with pytest.raises(KeyboardInterrupt):
        ensure(root, "test")
    commands.fail = None
    ensure(root, "sim")
    assert (commands.made, commands.installed) == (2, ["sim", "sim"])


@pytest.mark.parametrize("command", ["demo", "test"])
def test_a_folder_that_cannot_be_written_is_one_plain_line(tmp_path: Path, command: str) -> None:
    """As after `sudo tools/demo`, or on a read-only disk."""
    shutil.copytree(ROOT / "tools/gazesetup", tmp_path / "tools/gazesetup")
    for name in (f"tools/{command}", "pyproject.toml", "setup.py"):
        shutil.copy(ROOT / name, tmp_path / name)
    (tmp_path / ".local/setup.lock").mkdir(parents=True)
    words = [sys.executable, "-I", str(tmp_path / "tools" / command)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    output = done.stdout + done.stderr
    assert done.returncode == 2, output
    assert output.count("\n") == 1
    assert f"cannot write {tmp_path}/.local/setup.lock (Is a directory)" in output


def test_what_a_set_up_as_root_left_is_named(root: Path, commands: FakeCommands) -> None:
    ensure(root, "sim")
    commands.fail = PermissionError(13, "Permission denied", "/somewhere")
    with pytest.raises(venv.NotAvailable, match=r"cannot write /somewhere .*chown"):
        ensure(root, "test")


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", json.dumps({"basis": 1, "extras": 2})])
def test_a_broken_stamp_means_remaking(root: Path, commands: FakeCommands, text: str) -> None:
    """Whatever it holds."""
    ensure(root)
    (root / ".local" / "venv" / "gazechair-stamp.json").write_text(text)
    ensure(root)
    assert commands.made == 2
