"""The commands `gazechair lidar mask` and `record`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from gazechair.config import configuration


def add(commands: Any) -> None:
    """Add them to argparse's subparsers `commands`."""
    lidar = commands.add_parser("lidar", help="masks and recordings of the lidars")
    acts = lidar.add_subparsers(title="actions", required=True, metavar="ACTION")
    mask = acts.add_parser("mask", help="find where the chair itself blocks the lidars' view")
    mask.add_argument("--seconds", type=float, default=5.0, metavar="N", help="look for N seconds")
    mask.set_defaults(act=_mask)
    record = acts.add_parser("record", help="record a lidar's measurements in a file")
    record.add_argument("file", type=Path, metavar="FILE")
    record.add_argument("--seconds", type=float, metavar="N", help="default: until Ctrl-C")
    record.add_argument("--name", help="which lidar, when there are several")
    record.set_defaults(act=_record)
    for act in (mask, record):
        configuration.add_option(act)


def _mask(options: argparse.Namespace) -> int:
    from gazechair.service import lidar_tools

    good = lidar_tools.mask(configuration.load(options.config), options.seconds, print)
    return 0 if good else 1


def _record(options: argparse.Namespace) -> int:
    from gazechair.service import lidar_tools

    config = configuration.load(options.config)
    lidar_tools.record(config, options.name, options.file, options.seconds, print)
    return 0
