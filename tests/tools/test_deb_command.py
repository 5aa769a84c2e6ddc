"""The package's command gazechair, with stand-ins for what it calls."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from gazedeb import package

COMMAND = Path(package.__file__).parent / "files" / "gazechair"
SAYS = 'echo "$GAZECHAIR_CONFIG"; echo "$STATE_DIRECTORY"; echo "$*"'
STATE = "/var/lib/gazechair"
ROOT, SOMEBODY = 0, 1000


def program(path: Path, act: str) -> None:
    """An executable shell script."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{act}\n")
    path.chmod(0o755)


def printed(tmp_path: Path, user: int, words: str) -> list[str]:
    """What the command started with: configuration, state folder (if it is the service), words."""
    program(tmp_path / "opt/gazechair/current/bin/gazechair", SAYS)
    program(tmp_path / "bin/id", f"echo {user}")
    program(tmp_path / "bin/runuser", '[ "$1 $2 $3" = "-u gazechair --" ] && shift 3 && exec "$@"')
    command = tmp_path / "gazechair"
    program(command, COMMAND.read_text().replace("/opt/", f"{tmp_path}/opt/"))
    env = {"PATH": f"{tmp_path}/bin:{os.environ['PATH']}"}
    done = subprocess.run([command, *words.split()], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.parametrize(("user", "state"), [(ROOT, STATE), (SOMEBODY, "")])
def test_it_has_the_configuration_of_the_service(tmp_path: Path, user: int, state: str) -> None:
    file, folder, words = printed(tmp_path, user, "alert test")
    assert f"--config {file}\n" in (COMMAND.parent / "gazechair.service").read_text()
    assert (folder, words) == (state, "alert test")


def test_a_hotspot_stays_roots(tmp_path: Path) -> None:
    """NetworkManager keeps its connections from every other user."""
    assert printed(tmp_path, ROOT, "hotspot on")[1:] == ["", "hotspot on"]
