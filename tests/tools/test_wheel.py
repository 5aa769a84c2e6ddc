"""An installation without a checkout: the wheel holds all that its commands need."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

COMMAND_S = 60.0
pytestmark = pytest.mark.xdist_group("wheel")


def environment(installed: Path) -> dict[str, str]:
    """This one's, with nothing of the checkout's on the path."""
    kept = {n: v for n, v in os.environ.items() if n not in ("DISPLAY", "WAYLAND_DISPLAY")}
    cache = installed.parent / "cache"
    return {**kept, "PYTHONPATH": str(installed), "XDG_CACHE_HOME": str(cache)}


def run(installed: Path, *words: str) -> str:
    done = subprocess.run(
        [sys.executable, *words],
        env=environment(installed),
        cwd=installed.parent,
        capture_output=True,
        text=True,
        timeout=COMMAND_S,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_it_is_what_runs(installed: Path) -> None:
    output = run(installed, "-c", "import gazechair, gazeboard; print(gazechair.__file__)")
    assert Path(output.strip()).is_relative_to(installed)


def test_a_module_that_an_earlier_build_left_is_not_in_it(installed: Path) -> None:
    assert (installed / "gazechair/cli.py").exists()
    assert not (installed / "gazechair/gone.py").exists()


def test_it_knows_its_commit(installed: Path) -> None:
    output = run(installed, "-m", "gazechair", "--version")
    assert "commit" in output
    assert "unknown" not in output


def test_it_holds_every_command(installed: Path) -> None:
    assert (
        run(installed, "-m", "gazechair", "--help")
        == subprocess.run(
            [sys.executable, "-m", "gazechair", "--help"],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
    )


def test_it_holds_the_firmware_to_flash(installed: Path) -> None:
    code = (
        "from gazechair.service.flash.tree import build, find_sources\n"
        "sources = find_sources()\n"
        "print(sources.main, sources.main.is_file())\n"
        "print(build(sources, None).name)"
    )
    main, name = run(installed, "-c", code).splitlines()
    assert main == f"{installed / 'gazeboard' / 'main.py'} True"
    here = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert name == here.stdout.splitlines()[1], "not the firmware of this checkout"


def test_its_demo_runs_and_ends(installed: Path) -> None:
    demo = subprocess.Popen(
        [sys.executable, "-m", "gazechair", "demo", "--port", "0"],
        env=environment(installed),
        cwd=installed.parent,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    assert demo.stdout is not None
    output = ""
    try:
        for line in demo.stdout:
            output += line
            if "The driver's page: http" in line:
                break
        else:
            raise AssertionError(f"it ended before it was ready: {output}")
        # As a shell and a parent do: twice, to the program and to its group.
        demo.send_signal(signal.SIGINT)
        os.killpg(demo.pid, signal.SIGINT)
        output += demo.communicate(timeout=COMMAND_S)[0]
    finally:
        demo.kill()
    assert "Traceback" not in output, output
    assert demo.returncode == 0, output
