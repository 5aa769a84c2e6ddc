"""The command `gazechair pair`."""

from __future__ import annotations

import argparse
from typing import Any

from gazechair.base.state_folder import state_folder
from gazechair.config import configuration


def add(commands: Any) -> None:
    """Add it to argparse's subparsers `commands`."""
    pair = commands.add_parser("pair", help="pair a tablet or phone, list them, revoke one")
    pair.add_argument(
        "--role",
        choices=("driver", "caretaker", "viewer"),
        default="driver",
        help="what the device may do (default: driver)",
    )
    pair.add_argument("--list", action="store_true", help="show the paired devices")
    pair.add_argument("--revoke", metavar="ID", help="end this device's pairing")
    configuration.add_option(pair)
    pair.set_defaults(act=_pair)


def _pair(options: argparse.Namespace) -> int:
    from gazechair.service import pair

    folder = state_folder(configuration.load(options.config).web.state_folder)
    if options.revoke:
        pair.revoke(folder, options.revoke, print)
    elif options.list:
        pair.show_devices(folder, print)
    else:
        pair.make_code(folder, options.role, print)
    return 0
