"""What an installation holds: every package of every source root, and all of the page's files."""

import sys

import pytest

import gazesetup

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PACKAGES = ["protocol/gazelink", "firmware/gazeboard", "host/gazechair", "tools/gazesim"]
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


def test_the_packages_of_every_source_root_have_names_of_their_own() -> None:
    """Nothing generic lands among other people's packages."""
    for package in PACKAGES:
        root, name = package.split("/")
        found = {file.parent.name for file in (gazesetup.ROOT / root).glob("*/__init__.py")}
        assert name in found
        assert all(each.startswith("gaze") for each in found)
