"""Lists the packages of every source root, which pyproject.toml alone cannot express."""

from setuptools import find_packages, setup

packages = ["gazeweb"]
package_dir = {"gazeweb": "web"}
for root in ("protocol", "firmware", "host", "tools"):
    found = find_packages(root, include=["gaze*"])
    packages += found
    package_dir |= {name: f"{root}/{name}" for name in found if "." not in name}

setup(packages=packages, package_dir=package_dir)
