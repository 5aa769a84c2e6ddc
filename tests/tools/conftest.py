"""The project's wheel, built once for all that need it."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

import pytest

import gazesetup
from gazedeb import package

NOT_PACKED = (".local", "build", "__pycache__", "*.egg-info", ".*_cache", ".hypothesis")


@pytest.fixture(scope="session")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what the Debian package installs, built from a copy: it leaves files behind.

    An earlier build left a module that is no longer there.
    """
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    shutil.copytree(gazesetup.ROOT, source, ignore=shutil.ignore_patterns(*NOT_PACKED))
    gone = source / "build/lib/gazechair/gone.py"
    gone.parent.mkdir(parents=True)
    gone.touch()
    package.own_wheel(source, folder)
    (wheel,) = folder.glob("*.whl")
    shutil.rmtree(source)
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"
