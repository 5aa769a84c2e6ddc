"""The command `gazechair settings`."""

from __future__ import annotations

import argparse
from typing import Any


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
    from gazechair.commissioning import board_settings
    from gazelink.settings_table import TABLE

    changes = [board_settings.parse(name, text) for name, text in options.set or ()]
    new: dict[int, int] = {}
    if options.defaults:  # all but the joystick's neutral
        rows = enumerate(TABLE)
        new = {index: row[1] for index, row in rows if not row[0].startswith("neutral_")}
    with board_settings.connected(options.port) as board:
        if options.defaults:
            board.defaults()
        for index, value in changes:
            board.set(index, value)
        if options.save:
            board.save(new | dict(changes))
        if options.save_heading:
            board.save_heading()
        print(board_settings.as_text(board.all()))
    return 0
