"""`gazechair pair` beside a running daemon, and without one."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from gazechair import cli
from gazechair.base.sole_daemon import sole_daemon
from gazechair.people.pairing import local
from gazechair.people.pairing.local import LocalDoor


@pytest.fixture
def config(tmp_path: Path) -> str:
    file = tmp_path / "chair.toml"
    file.write_text(f'[web]\nstate_folder = "{tmp_path}/state"\n')
    return str(file)


@pytest.fixture
def daemon(desk: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    monkeypatch.setattr(local, "_LOOK_S", 0.02)  # ends sooner
    door = LocalDoor(desk, tmp_path / "state", lambda: "http://127.0.0.1:8080/pair")
    door.start()
    yield desk
    door.stop()


def pair(config: str, *words: str) -> int:
    return cli.main(["pair", "--config", config, *words])


@pytest.mark.parametrize("role", ["driver", "caretaker", "viewer"])
def test_it_shows_a_code_that_works(
    daemon: Any, config: str, role: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pair(config, "--role", role) == 0
    code = capsys.readouterr().out.splitlines()[0].split()[-1]
    assert daemon.pair(code, "x", "192.0.2.1").device.role == role


def test_the_driver_is_meant_when_nothing_is_said(
    daemon: Any, config: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pair(config) == 0
    assert capsys.readouterr().out.startswith("Pair a driver: open http://127.0.0.1:8080/pair")


def test_it_lists_and_revokes(daemon: Any, config: str, capsys: pytest.CaptureFixture[str]) -> None:
    paired = daemon.join("viewer", "kitchen")
    assert pair(config, "--list") == 0
    assert paired.device.id in capsys.readouterr().out
    assert pair(config, "--revoke", paired.device.id) == 0
    assert daemon.who(paired.token) is None


def test_without_a_daemon_it_lists_and_revokes_but_makes_no_code(
    desk: Any, again: Any, config: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    paired = desk.join("viewer", "kitchen")
    assert pair(config) == 2
    assert "start it first" in capsys.readouterr().err
    assert pair(config, "--list") == 0
    assert "kitchen" in capsys.readouterr().out
    assert pair(config, "--revoke", paired.device.id) == 0
    assert not again(tmp_path / "state").is_paired(paired.device.id)


def test_a_daemon_that_cannot_be_asked_keeps_its_devices_and_that_is_said(
    desk: Any,
    again: Any,
    config: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    paired = desk.join("viewer", "kitchen")
    state = tmp_path / "state"
    door = LocalDoor(desk, state, lambda: "")

    def unbound(_descriptor: int, _mode: int) -> None:
        raise OSError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr(os, "fchmod", unbound)
    door.start()
    with sole_daemon(state):
        assert pair(config, "--revoke", paired.device.id) == 2
    error = capsys.readouterr().err
    assert f"{paired.device.id} is still paired: a gazechair run has the state folder" in error
    assert "answers at" in error
    assert error.count("\n") == 1
    assert again(state).is_paired(paired.device.id)
    assert desk.who(paired.token) is not None
    door.stop()
    assert pair(config, "--revoke", paired.device.id) == 0
    assert "sent away" not in capsys.readouterr().out
    assert not again(state).is_paired(paired.device.id)


def test_a_state_folder_of_another_user_is_said(
    desk: Any, config: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    paired = desk.join("viewer", "kitchen")

    def refused(_path: Any, _flags: int) -> int:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(os, "open", refused)
    assert pair(config, "--revoke", paired.device.id) == 2
    assert "run this as the user of gazechair run" in capsys.readouterr().err
    assert desk.is_paired(paired.device.id)


@pytest.mark.parametrize("running", [True, False])
def test_an_unknown_device_is_said(
    running: bool,
    config: str,
    request: pytest.FixtureRequest,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if running:
        request.getfixturevalue("daemon")
    assert pair(config, "--revoke", "ffffff") == 2
    error = capsys.readouterr().err
    assert "no device 'ffffff'" in error
    assert error.count("\n") == 1


def test_a_role_that_there_is_not_is_refused(config: str) -> None:
    with pytest.raises(SystemExit):
        pair(config, "--role", "king")
