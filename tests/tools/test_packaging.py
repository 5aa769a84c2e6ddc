"""What an installation holds: every package of every source root, and all of the page's files."""

import sys

import pytest

import gazesetup
from gazesetup.paths import SOURCE_ROOTS

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PACKAGES = [
    f"{root}/{folder.name}"
    for root in SOURCE_ROOTS
    for folder in sorted((gazesetup.ROOT / root).glob("gaze*"))
    if folder.is_dir() and any(folder.glob("*.py"))
]
SETTINGS = tomllib.loads((gazesetup.ROOT / "pyproject.toml").read_text())


@pytest.mark.parametrize("package", PACKAGES)
def test_every_folder_with_modules_is_a_package(package: str) -> None:
    """A folder without __init__.py works in the checkout and is missing once installed."""
    folders = {file.parent for file in (gazesetup.ROOT / package).rglob("*.py")}
    assert folders
    assert [str(folder) for folder in folders if not (folder / "__init__.py").exists()] == []


def test_every_file_of_the_page_is_installed() -> None:
    """One of the patterns in pyproject.toml takes it."""
    web = gazesetup.ROOT / "web"
    patterns = SETTINGS["tool"]["setuptools"]["package-data"]["gazeweb"]
    installed = {file for pattern in patterns for file in web.glob(pattern)}
    installed |= set(web.glob("*.py"))
    files = {file for file in web.rglob("*") if file.is_file() and "__pycache__" not in file.parts}
    assert sorted(map(str, files - installed)) == []


def test_every_package_has_a_name_of_its_own() -> None:
    """Nothing generic lands among other people's packages, and setup.py takes gaze* only."""
    found = {
        folder.parent.name
        for root in SOURCE_ROOTS
        for folder in (gazesetup.ROOT / root).glob("*/__init__.py")
    }
    assert found
    assert all(name.startswith("gaze") for name in found)
