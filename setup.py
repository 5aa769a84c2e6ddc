"""Lists the packages of every source root, which pyproject.toml alone cannot express."""

from setuptools import find_packages, setup

ROOTS = {
    "gazelink": "protocol",
    "gazeboard": "firmware",
    "gazechair": "host",
    "gazesim": "tools",
    "gazedemo": "tools",
    "gazemeasure": "tools",
}

packages = ["gazeweb"]
package_dir = {"gazeweb": "web"}
for name, root in ROOTS.items():
    found = find_packages(root, include=[name, name + ".*"])
    packages += found
    if found:
        package_dir[name] = f"{root}/{name}"

setup(packages=packages, package_dir=package_dir)
