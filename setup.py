"""Lists the packages of every source root, which pyproject.toml alone cannot express."""

import subprocess
from pathlib import Path

from setuptools import find_packages, setup
from setuptools.command.build_py import build_py

packages = ["gazeweb"]
package_dir = {"gazeweb": "web"}
for root in ("protocol", "firmware", "host", "tools"):
    found = find_packages(root, include=["gaze*"])
    packages += found
    package_dir |= {name: f"{root}/{name}" for name in found if "." not in name}


class BuildWithCommit(build_py):
    """A wheel knows the commit it was made from (host/gazechair/base/version.py reads it)."""

    def run(self) -> None:
        super().run()
        if self.editable_mode:
            return
        git = ["git", "describe", "--always", "--abbrev=12", "--dirty", "--match="]
        commit = subprocess.run(git, capture_output=True, text=True, check=False).stdout.strip()
        if commit:
            (Path(self.build_lib) / "gazechair" / "base" / "commit.txt").write_text(commit + "\n")


setup(packages=packages, package_dir=package_dir, cmdclass={"build_py": BuildWithCommit})
