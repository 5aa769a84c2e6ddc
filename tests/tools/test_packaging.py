"""What an installation holds: every package of every source root, and all of the page's files."""

import re
import sys

import pytest

import gazesetup
from gazedeb import package
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


def test_the_debian_package_has_what_docs_and_host_ask_for() -> None:
    """A hint to `pip install` leads nowhere there: its environment is root's."""
    root = gazesetup.ROOT
    files = [*root.glob("docs/*.md"), *(root / "host").rglob("*.py")]
    named = {
        extra
        for file in files
        for extras in re.findall(r"gazechair\[([a-z,]+)\]", file.read_text())
        for extra in extras.split(",")
    }
    assert {"bench", "home", "gamepad", "flash"} <= named
    assert named - set(package.EXTRAS) == {"oak"}
    assert "`oak`" in (root / "docs/install.md").read_text()


def test_the_debian_package_pins_what_its_extras_need() -> None:
    """Directly; what those need in turn, installing without network shows (test_deb.py)."""
    project = SETTINGS["project"]
    needed = list(project["dependencies"])
    for extra in package.EXTRAS:
        needed += project["optional-dependencies"][extra]
    pinned = {line.partition("==")[0] for line in package.LOCKED.read_text().split()}
    elsewhere = ("python_version < '3.11'", "platform_machine != 'x86_64'")
    names = {
        re.match(r"[a-z0-9-]+", one.lower())[0] for one in needed if not one.endswith(elsewhere)
    }
    assert names - pinned == set()


def test_every_package_has_a_name_of_its_own() -> None:
    """Nothing generic lands among other people's packages, and setup.py takes gaze* only."""
    found = {
        folder.parent.name
        for root in SOURCE_ROOTS
        for folder in (gazesetup.ROOT / root).glob("*/__init__.py")
    }
    assert found
    assert all(name.startswith("gaze") for name in found)
