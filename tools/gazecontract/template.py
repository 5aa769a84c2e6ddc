"""The package that `gazechair plugin new` writes: it runs and passes the check at once."""

from __future__ import annotations

import re
from pathlib import Path

_PROJECT = """\
[build-system]
requires = ["setuptools>=61"]
build-backend = "setuptools.build_meta"

[project]
name = "gazechair-{name}"
version = "0.1"
dependencies = ["gazechair"]

[project.entry-points."gazechair.{kind}s"]
{name} = "{module}:{title}"

[tool.setuptools]
py-modules = ["{module}"]
"""
_INPUT = '''\
"""An input of gazechair: replace sense() by what your device says."""

from dataclasses import dataclass

from gazechair.plugins import NOTHING, Input, drive, integer, setting


class {title}(Input):
    """Drives forward for 0.6 s in every 1.2 s: a template."""

    @dataclass(frozen=True)
    class Settings:
        """How it drives."""

        linear: int = setting(0, integer(-1000, 1000), "permille forward; 0 = it does nothing")

    nl = "{title}"
    en = "{title}"
    rehearsal = {{"linear": 300}}

    def sense(self, now_s):
        if now_s % 1.2 < 0.6 or self.settings.linear == 0:
            return NOTHING
        return drive(self.settings.linear, 0)
'''
_MODE = '''\
"""A mode of gazechair: replace drive() by your way of driving."""

from dataclasses import dataclass

from gazechair.plugins import Mode, integer, setting


class {title}(Mode):
    """Drives slowly forward while it is pressed: a template."""

    @dataclass(frozen=True)
    class Settings:
        """How it drives."""

        linear: int = setting(300, integer(0, 1000), "permille forward")

    nl = "{title}"
    en = "{title}"

    def drive(self, world):
        return self.settings.linear, 0
'''
_BODIES = {"input": _INPUT, "mode": _MODE}


def write(kind: str, name: str, folder: Path) -> Path:
    """A new package in `folder`; returns its place. Raises ValueError, FileExistsError."""
    if not re.fullmatch(r"[a-z][a-z0-9_]{0,19}", name):
        raise ValueError("a name is 1 to 20 small letters, digits and _, a letter first")
    place = folder / f"gazechair-{name}"
    place.mkdir(parents=True)
    words = {"name": name, "kind": kind, "module": f"gazechair_{name}"}
    title = "".join(part.capitalize() for part in name.split("_"))
    (place / "pyproject.toml").write_text(_PROJECT.format(title=title, **words))
    (place / f"gazechair_{name}.py").write_text(_BODIES[kind].format(title=title))
    return place
