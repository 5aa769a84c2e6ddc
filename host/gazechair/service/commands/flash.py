"""The command `gazechair flash`."""

from __future__ import annotations

import argparse
from typing import Any

from gazechair.base.user_error import UserError


def add(commands: Any) -> None:
    """Add it to argparse's subparsers `commands`."""
    flash = commands.add_parser("flash", help="put the firmware on the board")
    flash.add_argument("--port", default="auto", help="the board's serial port (default: find it)")
    flash.add_argument("--dry-run", action="store_true", help="only say what would be done")
    flash.add_argument("--force", action="store_true", help="flash in spite of doubts")
    flash.set_defaults(act=_flash)


def _flash(options: argparse.Namespace) -> int:
    from gazechair.service.flash import Flasher, FlashError

    try:
        Flasher(lambda line: print(line, flush=True)).flash(
            options.port, options.dry_run, options.force
        )
    except FlashError as error:
        raise UserError(str(error)) from None
    return 0
