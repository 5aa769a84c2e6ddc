"""Creates a folder with an installed package of plug-ins, for a demo or a benchmark."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path


def package(folder: Path, name: str, groups: Mapping[str, Mapping[str, str]]) -> str:
    """Create the package `name` in `folder`; `groups`: {group: {plug-in: "module:Class"}}.

    Returns the folder, where the package's modules belong, too.
    """
    info = folder / "packages" / f"{name}-0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0\n")
    rows: list[str] = []
    for group, entries in groups.items():
        rows += [f"[{group}]", *(f"{plugin} = {entry}" for plugin, entry in entries.items())]
    (info / "entry_points.txt").write_text("\n".join(rows) + "\n")
    return str(info.parent)
