"""The commands `gazechair map show`, `export`, `import` and `back`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from gazechair.base.user_error import UserError


def add(commands: Any) -> None:
    """Add them to argparse's subparsers `commands`."""
    maps = commands.add_parser("map", help="maps of the home: draw, exchange with ROS")
    acts = maps.add_subparsers(title="actions", required=True, metavar="ACTION")
    show = acts.add_parser("show", help="draw a map and its track as an SVG picture")
    show.add_argument("file", type=Path, help="the map")
    show.add_argument("--output", type=Path, help="the picture (default: FILE with .svg)")
    show.set_defaults(act=lambda options: _act(_show, options))
    export = acts.add_parser("export", help="write map.yaml and map.pgm for ROS, places.json")
    export.add_argument("file", type=Path, help="the map")
    export.add_argument("folder", type=Path, help="where the three files go")
    export.set_defaults(act=lambda options: _act(_export, options))
    read = acts.add_parser("import", help="make a map of a map.yaml of ROS")
    read.add_argument("yaml", type=Path, help="its image is found beside it")
    read.add_argument("file", type=Path, help="the map to write")
    read.set_defaults(act=lambda options: _act(_import, options))
    back = acts.add_parser(
        "back", help="take back the newest update by drives; again: the one before"
    )
    back.add_argument("file", type=Path, help="the map, in its folder")
    back.set_defaults(act=lambda options: _act(_back, options))


def _act(act: Any, options: argparse.Namespace) -> int:
    print(act(options))
    return 0


def _show(options: argparse.Namespace) -> str:
    from gazechair.base.output_file import write_output
    from gazechair.sensing.mapping.stored.home_map import load
    from gazechair.sensing.mapping.stored.picture import svg

    home = load(options.file)
    output: Path = options.output or options.file.with_suffix(".svg")
    write_output(output, svg(home).encode())
    grid = home.grid
    floor_m2 = float(grid.free.sum()) * grid.cell_m**2
    return (
        f"{home.name}: {floor_m2:.1f} m2 of free floor, cells of {100.0 * grid.cell_m:g} cm, "
        f"{len(home.track)} key scans; drawn in {output}"
    )


def _export(options: argparse.Namespace) -> str:
    from gazechair.sensing.mapping.stored import ros_map
    from gazechair.sensing.mapping.stored.home_map import load

    return str(ros_map.write(load(options.file), options.folder))


def _import(options: argparse.Namespace) -> str:
    from gazechair.sensing.mapping.stored import ros_map
    from gazechair.sensing.mapping.stored.places import EditRefused
    from gazechair.sensing.mapping.stored.store import FOLDER, MapStore

    if options.file.exists():
        raise UserError(f"{options.file} is there already; name another file, or remove it first")
    home = ros_map.read(options.yaml, options.file.stem)
    folder: Path = options.file.parent.resolve()
    try:
        if folder.name == FOLDER:
            MapStore(folder).add(home, options.file.name)
        else:
            home.save(options.file)
    except EditRefused as error:
        raise UserError(str(error)) from None
    return str(options.file)


def _back(options: argparse.Namespace) -> str:
    from gazechair.sensing.mapping.stored.places import EditRefused
    from gazechair.sensing.mapping.stored.store import MapStore

    file: Path = options.file
    try:
        if MapStore(file.parent).take_back(file.stem):
            return f"{file} is what it was before its newest update by drives"
    except EditRefused as error:
        raise UserError(str(error)) from None
    raise UserError(f"{file}: no drive has changed it")
