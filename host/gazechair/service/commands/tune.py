"""The command `gazechair tune`."""

from __future__ import annotations

import argparse
from typing import Any

from gazechair.base.user_error import UserError
from gazechair.config import configuration
from gazelink.settings_table import PROFILES


def add(commands: Any) -> None:
    """Add it to argparse's subparsers `commands`."""
    tune = commands.add_parser(
        "tune", help="measure how the chair turns and drives, in one profile"
    )
    tune.add_argument("--profile", required=True, choices=PROFILES, help="selected on the chair")
    configuration.add_option(tune)
    tune.add_argument("--dry-run", action="store_true", help="only show what it finds")
    tune.set_defaults(act=_tune)


def _tune(options: argparse.Namespace) -> int:
    from gazechair.service.tune import tune

    settings = configuration.load(options.config)
    try:
        tune(settings, options.profile, options.dry_run, lambda line: print(line, flush=True))
    except KeyboardInterrupt:
        raise UserError("stopped; nothing was changed") from None
    return 0
