"""The command line: `gazechair run` and every other command; `gazechair --help` lists them.

The `add` of a command takes argparse's subparsers. Its `act` returns the exit code, or raises
UserError for what it cannot do; it imports then what it needs beyond the standard library, with
which alone `gazechair config` works. Other packages add theirs by an entry point of the group
`gazechair.commands`.
"""

from __future__ import annotations

import argparse
import logging
import os
import select
import signal
import sys
import threading
from collections.abc import Sequence
from importlib.metadata import entry_points

from gazechair.alerts import command as alert
from gazechair.base.user_error import UserError
from gazechair.base.version import version
from gazechair.blackbox import command as log
from gazechair.config import configuration
from gazechair.sensing.mapping import command as maps
from gazechair.service import hotspot
from gazechair.service.commands import bench, calibrate, doctor, flash, lidar, pair, settings, tune

_COMMANDS = (
    *(doctor, pair, settings, flash, bench, calibrate, tune, lidar, hotspot),
    *(log, alert, maps),
)
_ADDED = "gazechair.commands"
_SWITCH_S = 0.001  # 0.005 by default


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; its exit code: 0 well, 1 the doctor found a failure, 2 cannot run."""
    options = _parser().parse_args(arguments)
    try:
        return int(options.act(options))
    except UserError as error:
        return refuse(str(error))


def refuse(line: str) -> int:
    """Print in one line why a command failed; returns its exit code."""
    print(f"gazechair: {line}", file=sys.stderr)
    return 2


class _Version(argparse.Action):
    # Wait for git only when somebody needs the version.
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        print(f"gazechair {version()}")
        parser.exit()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="gazechair", description="Drive a power wheelchair with the eyes."
    )
    parser.add_argument(
        "--version", action=_Version, nargs=0, help="show the version and its commit"
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    run = commands.add_parser("run", help="run the host: board, lidar, camera, driver's page")
    configuration.add_option(run)
    run.set_defaults(act=_run)
    for command in _COMMANDS:
        command.add(commands)
    config = commands.add_parser("config", help="print a configuration file with all defaults")
    config.set_defaults(act=_config)
    for added in sorted(entry_points(group=_ADDED), key=lambda entry: entry.name):
        try:
            added.load()(commands)
        except Exception as error:  # code from outside; the other commands continue
            refuse(f"the command {added.name} of {added.value} cannot be loaded: {error}")
    return parser


def _run(options: argparse.Namespace) -> int:
    from gazechair.base.service_manager import ServiceManager
    from gazechair.base.sole_daemon import sole_daemon
    from gazechair.base.state_folder import state_folder
    from gazechair.base.throttled_log import ThrottledLog
    from gazechair.daemon import Daemon

    manager = ServiceManager()
    config = configuration.load(options.config)
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(name)s: %(message)s")
    threading.excepthook = ThrottledLog(logging.getLogger("gazechair.threads")).thread_ended
    # A thread that waits for its turn in Python waits this long for each that is before it.
    sys.setswitchinterval(_SWITCH_S)
    # No Event: its lock may be taken by the very thread that a signal interrupts.
    ends, ending = os.pipe()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: os.write(ending, b"."))
    with sole_daemon(state_folder(config.web.state_folder)):
        daemon = Daemon(config)
        daemon.start()
        try:
            print(f"gazechair: the driver's page is at {daemon.url}", flush=True)
            if invitation := daemon.invitation():
                print(invitation, flush=True)
            manager.ready(daemon.url)
            while not select.select([ends], [], [], manager.pace_s)[0]:
                if daemon.alive:
                    manager.alive()
            manager.ending()
        finally:
            daemon.stop()
    return 0


def _config(options: argparse.Namespace) -> int:
    print(configuration.annotated_default(), end="")
    return 0
