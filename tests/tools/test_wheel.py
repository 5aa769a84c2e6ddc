"""An installation without a checkout: the wheel holds all that its commands need."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import gazesetup

NOT_PACKED = (".local", "build", "__pycache__", "*.egg-info", ".*_cache", ".hypothesis")
BUILD_S = 240.0
COMMAND_S = 60.0


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what pip would install, built from a copy: building leaves files behind."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    shutil.copytree(gazesetup.ROOT, source, ignore=shutil.ignore_patterns(*NOT_PACKED))
    words = [sys.executable, "-m", "pip", "wheel", "--no-deps", "-w", str(folder), str(source)]
    built = subprocess.run(words, capture_output=True, text=True, timeout=BUILD_S)
    assert built.returncode == 0, built.stdout + built.stderr
    (wheel,) = folder.glob("*.whl")
    shutil.rmtree(source)
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


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
    said = run(installed, "-c", "import gazechair, gazeboard; print(gazechair.__file__)")
    assert Path(said.strip()).is_relative_to(installed)


def test_it_knows_its_commit(installed: Path) -> None:
    said = run(installed, "-m", "gazechair", "--version")
    assert "commit" in said
    assert "unknown" not in said


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


@pytest.mark.e2e
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
    said = ""
    try:
        for line in demo.stdout:
            said += line
            if "The driver's page: http" in line:
                break
        # As a shell and a parent do: twice, to the program and to its group.
        demo.send_signal(signal.SIGINT)
        os.killpg(demo.pid, signal.SIGINT)
        said += demo.communicate(timeout=COMMAND_S)[0]
    finally:
        demo.kill()
    assert "Traceback" not in said, said
    assert demo.returncode == 0, said
