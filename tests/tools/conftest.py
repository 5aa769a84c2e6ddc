"""The project's wheel, built once for all that need it."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import gazesetup

NOT_PACKED = (".local", "build", "__pycache__", "*.egg-info", ".*_cache", ".hypothesis")
BUILD_S = 240.0


@pytest.fixture(scope="session")
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
