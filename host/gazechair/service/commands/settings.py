"""The command `gazechair settings`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from gazelink.settings_table import NAMES, TABLE


def add(commands: Any) -> None:
    """Add it to argparse's subparsers `commands`."""
    settings = commands.add_parser("settings", help="read and change the board's settings")
    settings.add_argument("--port", default="auto", help="the board's serial port")
    settings.add_argument(
        "--set", nargs=2, action="append", metavar=("NAME", "VALUE"), help="change one"
    )
    settings.add_argument("--defaults", action="store_true", help="first take all defaults")
    settings.add_argument("--save", action="store_true", help="keep them across a reset")
    settings.add_argument(
        "--save-heading", action="store_true", help="keep the heading sensor's calibration"
    )
    settings.set_defaults(act=_settings)


def _settings(options: argparse.Namespace) -> int:
    from gazechair.commissioning.board_settings import parse
    from gazechair.service import board_connection

    changes = [parse(name, text) for name, text in options.set or ()]
    new: dict[int, int] = {}
    if options.defaults:  # all but the joystick's neutral
        rows = enumerate(TABLE)
        new = {index: row[1] for index, row in rows if not row[0].startswith("neutral_")}
    with board_connection.connected(options.port) as board:
        if options.defaults:
            board.defaults()
        for index, value in changes:
            board.set(index, value)
        if options.save:
            board.save(new | dict(changes))
        if options.save_heading:
            board.save_heading()
        print(_as_text(board.all()))
    return 0


def _as_text(values: Sequence[int]) -> str:
    """A table: name, value in force, default, limits."""
    width = max(len(name) for name in NAMES)
    lines = [f"{'setting':<{width}}  {'now':>6} {'default':>8}  limits"]
    for (name, default, low, high), value in zip(TABLE, values, strict=True):
        changed = " " if value == default else "*"
        lines.append(f"{name:<{width}}  {value:>6}{changed}{default:>8}  {low}..{high}")
    return "\n".join(lines)
