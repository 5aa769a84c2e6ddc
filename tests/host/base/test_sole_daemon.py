"""A state folder is used by one daemon at a time."""

import errno
import os
from pathlib import Path
from typing import Any

import pytest

from gazechair import cli, daemon
from gazechair.base.sole_daemon import LOCK_NAME, AlreadyRunning, no_daemon, sole_daemon
from gazechair.base.user_error import UserError


def test_a_second_daemon_in_the_same_folder_is_refused_until_the_first_has_ended(
    tmp_path: Path,
) -> None:
    state = tmp_path / "deep" / "state"
    with sole_daemon(state):
        for _ in range(2):
            with pytest.raises(AlreadyRunning, match=r"web\.state_folder"), sole_daemon(state):
                pass
    with sole_daemon(state):
        assert (state / LOCK_NAME).stat().st_mode & 0o777 == 0o600
        assert state.stat().st_mode & 0o777 == 0o700


def test_whoever_works_on_the_folder_waits_for_no_daemon_and_keeps_them_out(
    tmp_path: Path,
) -> None:
    with no_daemon(tmp_path):  # where none ever ran
        pass
    assert not (tmp_path / LOCK_NAME).exists()
    with sole_daemon(tmp_path), pytest.raises(AlreadyRunning), no_daemon(tmp_path):
        pass
    with no_daemon(tmp_path), pytest.raises(AlreadyRunning), sole_daemon(tmp_path):
        pass


def test_a_folder_that_cannot_be_locked_keeps_no_daemon_from_starting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def refuse(*_: object) -> int:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(os, "open", refuse)
    with sole_daemon(tmp_path):
        pass
    assert "another daemon would not be noticed" in caplog.text


def test_the_folder_is_read_only_by_the_daemon_that_has_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What the daemon before writes at its end, a lower speed for one, must not be missed."""
    read: list[bool] = []

    class Reads:
        def __init__(self, _: Any) -> None:
            with pytest.raises(AlreadyRunning), no_daemon(tmp_path):
                pass
            read.append(True)
            raise UserError("it has read enough")

    monkeypatch.setattr(daemon, "Daemon", Reads)
    monkeypatch.setattr(cli.signal, "signal", lambda *_: None)
    monkeypatch.setattr(cli.sys, "setswitchinterval", lambda _: None)
    monkeypatch.setattr(cli.threading, "excepthook", cli.threading.excepthook)
    file = tmp_path / "chair.toml"
    file.write_text(f'[web]\nstate_folder = "{tmp_path}"\n')
    with sole_daemon(tmp_path):
        assert cli.main(["run", "--config", str(file)]) == 2
        assert "another gazechair runs" in capsys.readouterr().err
        assert read == []
    assert cli.main(["run", "--config", str(file)]) == 2
    assert read == [True]
