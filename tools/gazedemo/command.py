"""The command `gazechair demo`: a simulated chair to drive, as `tools/demo`."""

from __future__ import annotations

import argparse
import os
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import gazesetup
from gazechair.cli import refuse

_PORT = 8080
_SHOWS = (("sim", "PIL"), ("sim", "mcap_ros2"))
_CHECKS = (("test", "playwright"),)


def add(commands: Any) -> None:
    """Add the command to argparse's subparsers `commands`."""
    demo = commands.add_parser("demo", help="a simulated chair to drive from a browser")
    add_options(demo)
    demo.set_defaults(act=_demo)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the demo's options."""
    parser.add_argument("--check", action="store_true", help="drive it headless and print figures")
    parser.add_argument(
        "--home", action="store_true", help="a flat with a stored map and places to drive to"
    )
    parser.add_argument("--room", default="living", help="room of the simulator (default: living)")
    parser.add_argument("--profile", default="3.1", help="the chair's speed profile (default: 3.1)")
    parser.add_argument("--port", type=int, default=_PORT, help=f"of the page (default: {_PORT})")
    parser.add_argument("--config", type=Path, metavar="FILE", help="inputs and modes to switch on")
    parser.add_argument(
        "--artefacts",
        type=Path,
        default=Path(os.environ.get("GAZECHAIR_ARTEFACTS", gazesetup.LOCAL / "artefacts")),
        help="folder for the check's screenshots",
    )


def _demo(options: argparse.Namespace) -> int:
    needed = [*_SHOWS, *(_CHECKS if options.check else [])]
    for extra, module in needed:
        if find_spec(module) is None:
            return refuse(f"the demo needs an extra: pip install 'gazechair[{extra}]'")
    from gazedemo.demo import demo

    return demo(options)
